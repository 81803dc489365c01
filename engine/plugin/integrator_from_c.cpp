#include "engine/plugin/integrator_from_c.h"

#include "engine/archive/archive.h"
#include "engine/base/error.h"
#include "engine/base/number_text.h"

namespace lithe {
namespace {

Eigen::Map<const VectorX> read(const double* at, int n) { return {at, n}; }
Eigen::Map<VectorX> write(double* at, int n) { return {at, n}; }

/// As given, a line each.
std::string text_of(const ParameterList& parameters) {
  std::string text;
  for (const Parameter& p : parameters) {
    text += p.name;
    if (const auto* number = std::get_if<double>(&p.value)) append_number(text += ' ', *number);
    if (const auto* said = std::get_if<std::string>(&p.value)) text += ' ' + *said;
    if (const auto* vector = std::get_if<std::vector<double>>(&p.value))
      for (double number : *vector) append_number(text += ' ', number);
    text += '\n';
  }
  return text;
}

lithe_state as_c(State& state) {
  return {sizeof(lithe_state),
          state.time,
          state.q.data(),
          state.v.data(),
          state.v_dot.data(),
          state.lambda.data(),
          state.quarter_turns.data(),
          static_cast<int32_t>(state.quarter_turns.size())};
}

[[noreturn]] void refuse_call(const std::string& problem, const char* fix) {
  throw SimulationError("the integrator of a plug-in " + problem, "lithe_equations", fix);
}

Level level_of(int32_t level) {
  if (level < LITHE_POSITION || level > LITHE_ACCELERATION)
    refuse_call("asks for level " + std::to_string(level),
                "its author is to give LITHE_POSITION, LITHE_VELOCITY or LITHE_ACCELERATION");
  return static_cast<Level>(level);
}

void check_count(int32_t count) {
  if (count < 0) refuse_call("gives " + std::to_string(count) + " quarter turns", "its author is to give all, or 0");
}

ComplexFactor& complex_factor_of(EquationsOfMotion& equations) {
  ComplexFactor* factor = equations.parts().complex_factor;
  if (!factor) refuse_call("asks for a complex factor, which these equations do not have", "take another integrator");
  return *factor;
}

}  // namespace

/// Runs f on the equations; what it throws waits at the border.
template <class F>
int32_t IntegratorFromC::Border::cross(void* border, F&& f) noexcept {
  auto& self = *static_cast<Border*>(border);
  try {
    const Layout& layout = self.equations->layout();
    f(self, layout.q_count(), layout.v_count(), layout.row_count());
    return 0;
  } catch (...) {
    if (!self.trouble) self.trouble = std::current_exception();
    return -1;
  }
}

IntegratorFromC::IntegratorFromC(const IntegratorType& type, const ParameterList& parameters)
    : table_(type.table), object_(type, parameters), parameters_(text_of(parameters)) {
  lithe_equations& t = border_.table;
  t.struct_size = sizeof t;
  t.host = &border_;
  t.evaluate = [](void* host, double time, const double* q, const double* v, int32_t level) {
    return Border::cross(host, [&](Border& self, int nq, int nv, int) {
      self.equations->evaluate(time, read(q, nq), read(v, nv), level_of(level));
    });
  };
  t.residual = [](void* host, const double* v_dot, const double* lambda, double* r) {
    return Border::cross(host, [&](Border& self, int, int nv, int rows) {
      self.equations->residual(read(v_dot, nv), read(lambda, rows), write(r, nv));
    });
  };
  t.constraint = [](void* host, int32_t which, double* out) {
    return Border::cross(
        host, [&](Border& self, int, int, int rows) { self.equations->constraint(level_of(which), write(out, rows)); });
  };
  t.factorize = [](void* host, const lithe_tangent_weights* w, const double* v_dot, const double* lambda,
                   const double* increment) {
    return Border::cross(host, [&](Border& self, int, int nv, int rows) {
      if (increment) self.increment = read(increment, nv);
      self.equations->factorize({w->position, w->velocity, w->acceleration}, read(v_dot, nv), read(lambda, rows),
                                increment ? &self.increment : nullptr);
    });
  };
  t.solve = [](void* host, double* rv, double* rl) {
    return Border::cross(
        host, [&](Border& self, int, int nv, int rows) { self.equations->solve(write(rv, nv), write(rl, rows)); });
  };
  t.factorize_complex = [](void* host, const lithe_complex_tangent_weights* w, const double* v_dot,
                           const double* lambda, const double* increment) {
    return Border::cross(host, [&](Border& self, int, int nv, int rows) {
      if (increment) self.increment = read(increment, nv);
      const auto complex = [](const double* x) { return std::complex<double>(x[0], x[1]); };
      complex_factor_of(*self.equations)
          .factorize_complex({complex(w->position), complex(w->velocity), complex(w->acceleration)}, read(v_dot, nv),
                             read(lambda, rows), increment ? &self.increment : nullptr);
    });
  };
  t.solve_complex = [](void* host, double* rv, double* rl) {
    return Border::cross(host, [&](Border& self, int, int nv, int rows) {
      using Map = Eigen::Map<ComplexVectorX>;
      complex_factor_of(*self.equations)
          .solve_complex(Map(reinterpret_cast<std::complex<double>*>(rv), nv),
                         Map(reinterpret_cast<std::complex<double>*>(rl), rows));
    });
  };
  t.energy = [](void* host, double* joules) {
    return Border::cross(host, [&](Border& self, int, int, int) {
      const BodyEnergy e = self.equations->energy();
      joules[0] = e.kinetic, joules[1] = e.elastic, joules[2] = e.gravity;
    });
  };
  t.visit_blocks = [](void* host, void* visitor,
                      void (*visit)(void*, int32_t, int32_t, int32_t, int32_t, const double*, ptrdiff_t)) {
    return Border::cross(host, [&](Border& self, int, int, int) {
      self.equations->visit_blocks([&](int row, int column, ConstMatrixRef block) {
        visit(visitor, row, column, static_cast<int32_t>(block.rows()), static_cast<int32_t>(block.cols()),
              block.data(), block.outerStride());
      });
    });
  };
  t.retract = [](void* host, const double* q, const double* d, double* out) {
    return Border::cross(host, [&](Border& self, int nq, int nv, int) {
      self.equations->layout().retract(read(q, nq), read(d, nv), write(out, nq));
    });
  };
  t.chart_rates = [](void* host, const double* d, const double* v, double* d_dot) {
    return Border::cross(host, [&](Border& self, int, int nv, int) {
      self.equations->layout().chart_rates(read(d, nv), read(v, nv), write(d_dot, nv));
    });
  };
  t.recall = [](void* host, const double* quarter_turns, int32_t count) {
    return Border::cross(host, [&](Border& self, int, int, int) {
      check_count(count);
      self.quarter_turns = read(quarter_turns, count);
      self.equations->memory().recall(self.quarter_turns);
    });
  };
  t.track = [](void* host, double* quarter_turns, int32_t count) {
    return Border::cross(host, [&](Border& self, int, int, int) {
      check_count(count);
      self.quarter_turns = read(quarter_turns, count);
      self.equations->memory().track(self.quarter_turns);
      if (self.quarter_turns.size() == count) write(quarter_turns, count) = self.quarter_turns;
    });
  };
}

void IntegratorFromC::bind(EquationsOfMotion& equations) {
  const Layout& layout = equations.layout();
  border_.equations = &equations;
  border_.bodies.clear(), border_.rows.clear();
  for (const auto& b : layout.bodies()) border_.bodies.push_back({b.name.c_str(), b.frame, b.linear});
  for (const auto& r : layout.rows()) border_.rows.push_back({r.name.c_str(), r.count});
  border_.redundant.assign(equations.redundant_rows().begin(), equations.redundant_rows().end());
  border_.on_velocity.assign(equations.velocity_rows().begin(), equations.velocity_rows().end());
  lithe_equations& t = border_.table;
  t.reacts = equations.reacts();
  t.velocity_row_count = static_cast<int32_t>(border_.on_velocity.size());
  t.velocity_rows = border_.on_velocity.data();
  t.q_count = layout.q_count(), t.v_count = layout.v_count(), t.row_count = layout.row_count();
  t.body_count = static_cast<int32_t>(border_.bodies.size());
  t.row_slice_count = static_cast<int32_t>(border_.rows.size());
  t.redundant_count = static_cast<int32_t>(border_.redundant.size());
  t.bodies = border_.bodies.data();
  t.row_slices = border_.rows.data();
  t.redundant_rows = border_.redundant.data();
}

/// After a call: statistics, and what went wrong beyond a step that failed.
void IntegratorFromC::finish(int32_t code, const ErrorText& why) {
  lithe_statistics s{};
  s.struct_size = sizeof s;
  table_.statistics(object_.get(), &s);
  statistics_ = before_;
  statistics_ += {static_cast<long>(s.steps), static_cast<long>(s.rejected), static_cast<long>(s.newton_iterations),
                  static_cast<long>(s.factorizations), static_cast<long>(s.evaluations)};
  if (border_.trouble) std::rethrow_exception(std::exchange(border_.trouble, nullptr));
  if (code < 0)
    throw SimulationError(object_.description() + " failed: " + why.problem(), "integrator",
                          why.fix().empty() ? "see what its author says; the state reached before is kept" : why.fix());
}

void IntegratorFromC::prepare(EquationsOfMotion& equations, State& state) {
  bind(equations);
  before_ = resumes() ? statistics_ : IntegratorStatistics{};
  begin(state);
}

void IntegratorFromC::begin(State& state) {
  begins_anew_ = false;
  ErrorText why;
  lithe_state s = as_c(state);
  const int32_t code = table_.start(object_.get(), &border_.table, &s, why.text, sizeof why.text);
  finish(code > 0 ? -1 : code, why);
  if (s.time != state.time)
    throw SimulationError(object_.description() + " moves time at its start", "integrator",
                          "its author is to leave the time as it is in start()");
}

bool IntegratorFromC::keep(Archive& archive, EquationsOfMotion& equations, const State& state) {
  archive.same("parameters", parameters_);
  bool keeps = table_.save && table_.load;
  std::vector<unsigned char> bytes;
  if (keeps && !archive.loads()) {
    const std::int64_t size = table_.save(object_.get(), nullptr, 0);
    constexpr std::int64_t kMost = 1'000'000'000;
    if (size > kMost)
      throw SimulationError(object_.description() + " has a past of " + std::to_string(size) + " bytes", "integrator",
                            "its author is to keep less in save(), at most " + std::to_string(kMost));
    bytes.resize(static_cast<std::size_t>(std::max<std::int64_t>(size, 0)));
    keeps = size >= 0 && table_.save(object_.get(), bytes.data(), size) == size;
  }
  archive("keeps", keeps);
  if (!keeps) return false;
  // Bytes as integers: an archive knows no smaller thing.
  std::vector<int> integers(bytes.begin(), bytes.end());
  archive("bytes", integers);
  archive("statistics", statistics_);
  archive("before", before_);
  archive("begins_anew", begins_anew_);
  if (!archive.loads()) return true;
  bind(equations);
  bytes.assign(integers.begin(), integers.end());
  ErrorText why;
  State at = state;
  const lithe_state s = as_c(at);
  if (!table_.load || table_.load(object_.get(), &s, bytes.data(), static_cast<std::int64_t>(bytes.size()), why.text,
                                  sizeof why.text) != 0)
    throw FileError(object_.description() + " cannot take its past back: " + why.problem(), archive.source(),
                    why.fix().empty() ? "resume with the plug-in that wrote it" : why.fix());
  if (border_.trouble) std::rethrow_exception(std::exchange(border_.trouble, nullptr));
  return true;
}

StepResult IntegratorFromC::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  if (&equations != border_.equations)
    throw SimulationError(object_.description() + " was started with other equations", "integrator",
                          "call start() with these equations first");
  if (begins_anew_) {
    before_ = statistics_;
    begin(state);
  }
  ErrorText why;
  lithe_state s = as_c(state);
  const int32_t code = table_.step(object_.get(), &s, t_stop, why.text, sizeof why.text);
  state.time = s.time;
  finish(code, why);
  if (code == 0) return {};
  return {StepResult::Outcome::failed, why.problem()};
}

}  // namespace lithe
