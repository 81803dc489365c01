#pragma once

#include <memory>
#include <optional>

#include "engine/archive/archive.h"
#include "engine/motion/integrator.h"
#include "engine/motion/projection.h"
#include "engine/plugin/plugin_tables.h"

/// Writes the C table of an integrator from its class.
namespace lithe::plugin {

/// The host's equations of motion as the class sees them.
class HostEquations final : public EquationsOfMotion, public StepMemory, public ComplexFactor {
 public:
  /// The host itself handles poses where loops lose rank: no loops here.
  explicit HostEquations(const lithe_equations& host)
      : host_(host),
        facts_{.layout = &layout_,
               .redundant_rows = {host.redundant_rows, host.redundant_rows + host.redundant_count},
               .velocity_rows = {host.velocity_rows, host.velocity_rows + host.velocity_row_count},
               .reacts = host.reacts != 0} {
    for (int i = 0; i < host.body_count; ++i) {
      const lithe_body_slice& b = host.bodies[i];
      layout_.add_body(b.name, {.frames = b.frame != 0, .linear = b.linear});
    }
    for (int i = 0; i < host.row_slice_count; ++i) layout_.add_rows(host.row_slices[i].name, host.row_slices[i].count);
  }

  HostEquations(const HostEquations&) = delete;
  HostEquations& operator=(const HostEquations&) = delete;

  const Facts& facts() const override { return facts_; }
  Parts parts() override { return {.memory = this, .complex_factor = this}; }
  void recall(const VectorX& quarter_turns) override {
    check(host_.recall(host_.host, quarter_turns.data(), static_cast<int32_t>(quarter_turns.size())));
  }
  void track(VectorX& quarter_turns) const override {
    check(host_.track(host_.host, quarter_turns.data(), static_cast<int32_t>(quarter_turns.size())));
  }
  void evaluate(double time, ConstVectorRef q, ConstVectorRef v, Level level) override {
    check(host_.evaluate(host_.host, time, q.data(), v.data(), static_cast<int32_t>(level)));
  }
  void residual(ConstVectorRef v_dot, ConstVectorRef lambda, VectorRef r) override {
    check(host_.residual(host_.host, v_dot.data(), lambda.data(), r.data()));
  }
  void constraint(Level which, VectorRef out) const override {
    check(host_.constraint(host_.host, static_cast<int32_t>(which), out.data()));
  }
  void factorize(const TangentWeights& w, ConstVectorRef v_dot, ConstVectorRef lambda,
                 const VectorX* increment) override {
    const lithe_tangent_weights weights{w.position, w.velocity, w.acceleration};
    check(host_.factorize(host_.host, &weights, v_dot.data(), lambda.data(), increment ? increment->data() : nullptr));
  }
  void solve(VectorRef rv, VectorRef rl) const override { check(host_.solve(host_.host, rv.data(), rl.data())); }
  void factorize_complex(const ComplexTangentWeights& w, ConstVectorRef v_dot, ConstVectorRef lambda,
                         const VectorX* increment) override {
    const lithe_complex_tangent_weights weights{{w.position.real(), w.position.imag()},
                                                {w.velocity.real(), w.velocity.imag()},
                                                {w.acceleration.real(), w.acceleration.imag()}};
    check(host_.factorize_complex(host_.host, &weights, v_dot.data(), lambda.data(),
                                  increment ? increment->data() : nullptr));
  }
  void solve_complex(ComplexVectorRef rv, ComplexVectorRef rl) const override {
    // An array of complex numbers is one of pairs of doubles, by the language.
    check(host_.solve_complex(host_.host, reinterpret_cast<double*>(rv.data()), reinterpret_cast<double*>(rl.data())));
  }
  BodyEnergy energy() override {
    double joules[3];
    check(host_.energy(host_.host, joules));
    return {joules[0], joules[1], joules[2]};
  }
  void visit_blocks(const std::function<void(int, int, ConstMatrixRef)>& visit) const override {
    using Visit = std::function<void(int, int, ConstMatrixRef)>;
    check(host_.visit_blocks(host_.host, const_cast<Visit*>(&visit),
                             [](void* visitor, int32_t row, int32_t column, int32_t rows, int32_t columns,
                                const double* values, ptrdiff_t column_stride) {
                               (*static_cast<const Visit*>(visitor))(
                                   row, column,
                                   Eigen::Map<const MatrixX, 0, Eigen::OuterStride<>>(
                                       values, rows, columns, Eigen::OuterStride<>(column_stride)));
                             }));
  }

 private:
  /// The host knows why it failed and takes the step back.
  static void check(int32_t code) {
    if (code != 0) throw SimulationError("the host could not evaluate its equations", "", "");
  }

  lithe_equations host_;
  Layout layout_;
  Facts facts_;
};

/// What the host holds: an integrator and the equations it was started with.
template <class T>
struct IntegratorInstance {
  std::unique_ptr<T> integrator;
  std::optional<HostEquations> equations;
  State state;

  /// Runs `f` on a copy of the host's state, and hands it back if that went well.
  template <class F>
  int32_t on_state(lithe_state* s, F&& f) {
    const Layout& layout = equations->layout();
    const auto map = [](double* at, int n) { return Eigen::Map<VectorX>(at, n); };
    auto q = map(s->q, layout.q_count()), v = map(s->v, layout.v_count()), v_dot = map(s->v_dot, layout.v_count()),
         lambda = map(s->lambda, layout.row_count()), quarter_turns = map(s->quarter_turns, s->quarter_turn_count);
    state.time = s->time, state.q = q, state.v = v, state.v_dot = v_dot, state.lambda = lambda;
    state.quarter_turns = quarter_turns;
    const int32_t outcome = f();
    s->time = state.time, q = state.q, v = state.v, v_dot = state.v_dot, lambda = state.lambda;
    quarter_turns = state.quarter_turns;
    return outcome;
  }
};

template <class T>
void* create_integrator(const lithe_parameter* given, size_t count, char* error, size_t size) noexcept {
  IntegratorInstance<T>* made = nullptr;
  guarded(error, size, [&] {
    made = new IntegratorInstance<T>{std::unique_ptr<T>(make<T>(given, count)), {}, {}};
    return kFine;
  });
  return made;
}

template <class T>
int32_t start(void* integrator, const lithe_equations* equations, lithe_state* state, char* error,
              size_t size) noexcept {
  return guarded(error, size, [&] {
    auto& self = *static_cast<IntegratorInstance<T>*>(integrator);
    self.equations.emplace(*equations);
    return self.on_state(state, [&] { return self.integrator->start(*self.equations, self.state), kFine; });
  });
}

template <class T>
int32_t step(void* integrator, lithe_state* state, double t_stop, char* error, size_t size) noexcept {
  return guarded(error, size, [&] {
    auto& self = *static_cast<IntegratorInstance<T>*>(integrator);
    return self.on_state(state, [&] {
      const StepResult result = self.integrator->step(*self.equations, self.state, t_stop);
      if (!result.ok()) write_error(error, size, result.why);
      return result.ok() ? kFine : kRetry;
    });
  });
}

template <class T>
void statistics(const void* integrator, lithe_statistics* out) noexcept {
  const IntegratorStatistics& s = static_cast<const IntegratorInstance<T>*>(integrator)->integrator->statistics();
  out->steps = s.steps, out->rejected = s.rejected, out->newton_iterations = s.newton_iterations;
  out->factorizations = s.factorizations, out->evaluations = s.evaluations;
}

template <class T>
int64_t save(void* integrator, unsigned char* bytes, int64_t capacity) noexcept {
  int64_t size = -1;
  guarded(nullptr, 0, [&] {
    auto& self = *static_cast<IntegratorInstance<T>*>(integrator);
    Archive archive("plug-in");
    if (!self.equations || !self.integrator->history(archive, *self.equations, self.state)) return kFine;
    const std::vector<unsigned char> all = archive.bytes();
    size = static_cast<int64_t>(all.size());
    if (capacity >= size) std::copy(all.begin(), all.end(), bytes);
    return kFine;
  });
  return size;
}

template <class T>
int32_t load(void* integrator, const lithe_state* state, const unsigned char* bytes, int64_t count, char* error,
             size_t size) noexcept {
  return guarded(error, size, [&]() -> int32_t {
    auto& self = *static_cast<IntegratorInstance<T>*>(integrator);
    if (!self.equations) return kFatal;
    Archive archive = Archive::of_bytes("plug-in", bytes, static_cast<std::size_t>(count));
    lithe_state at = *state;
    return self.on_state(
        &at, [&] { return self.integrator->history(archive, *self.equations, self.state) ? kFine : kFatal; });
  });
}

template <class T>
lithe_integrator_type integrator_type(const char* name) {
  auto table = table_of<T, lithe_integrator_type>(name);
  table.create = create_integrator<T>;
  table.destroy = destroy<IntegratorInstance<T>>;
  table.start = start<T>;
  table.step = step<T>;
  table.statistics = statistics<T>;
  table.save = save<T>;
  table.load = load<T>;
  return table;
}

}  // namespace lithe::plugin
