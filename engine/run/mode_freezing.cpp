#include "engine/run/mode_freezing.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <tuple>

#include "engine/archive/archive.h"
#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/model/deformable_body.h"

namespace lithe {
namespace {

// Of the displacement: what a mode may move while it is found quiet, and what all frozen ones of a body may lack when
// another one joins them. Those that lack more than the whole thaw.
constexpr double kQuiet = 0.25, kJoin = 0.5;
constexpr double kGain = 0.7;   // at most, of the highest frequency that moves, is that which is left
constexpr double kPeriods = 2;  // that a mode is quiet before it freezes,
constexpr int kLeastSteps = 4;  // and steps
constexpr double kShortly = 4;  // of these times: one that thaws sooner waits twice as long the next time
constexpr double kLeastMobility = 1e-6;
constexpr double kDone = 1e-6;     // of what modes do to the rows of joints: what the rest may leave undone
constexpr double kNothing = 1e-9;  // in the units of the rows, of a node's way of a metre

double largest(ConstVectorRef x) { return x.size() > 0 ? x.cwiseAbs().maxCoeff() : 0; }

}  // namespace

ModeFreezing::ModeFreezing(std::unique_ptr<Integrator> method, Parameters parameters)
    : method_(std::move(method)), parameters_(parameters) {
  require::at("ModeFreezing", [&] {
    require::positive(parameters.displacement, "displacement");
    require::positive(parameters.interval, "interval");
  });
}

/// m, at the node that the mode moves most.
double ModeFreezing::Mode::lack() const {
  return reach * std::hypot(swing.z, swing.rate / std::sqrt(mobility * stiffness));
}
double ModeFreezing::Mode::motion() const {
  return reach * std::max(0.5 * (high - low), fastest / std::sqrt(stiffness));
}
/// s, that it is to be quiet.
double ModeFreezing::wait(const Mode& m) const {
  return m.patience * (kPeriods * 2 * std::numbers::pi / std::sqrt(m.stiffness) + parameters_.interval);
}

void ModeFreezing::list_modes(const Layout& layout) {
  std::vector<Mode> modes;
  for (std::size_t b = 0; b < layout.bodies().size(); ++b) {
    const Layout::BodySlice& slice = layout.bodies()[b];
    const auto* body = dynamic_cast<const DeformableBody*>(slice.body);
    if (!body || body->candidate_stiffness().size() == 0) continue;
    const VectorX stiffness = body->candidate_stiffness(), damping = body->candidate_damping(),
                  reach = body->candidate_reach();
    const int frame_q = slice.frame ? 7 : 0, frame_v = slice.frame ? 6 : 0;
    for (int k = 0; k < slice.linear; ++k) {
      const int mode = body->fidelity().modes[static_cast<std::size_t>(k)];
      if (!(stiffness[mode] > 0)) continue;
      modes.push_back({.body = static_cast<int>(b),
                       .mode = mode,
                       .q = slice.q + frame_q + k,
                       .v = slice.v + frame_v + k,
                       .stiffness = stiffness[mode],
                       .damping = damping[mode],
                       .reach = reach[mode]});
      modes.back().history = {
          .body = slice.name, .mode = mode, .frequency = std::sqrt(stiffness[mode]) / (2 * std::numbers::pi)};
    }
  }
  std::ranges::stable_sort(modes, std::ranges::greater{}, &Mode::stiffness);
  const bool same = std::ranges::equal(modes, modes_, [](const Mode& a, const Mode& b) {
    return a.v == b.v && a.stiffness == b.stiffness && a.history.body == b.history.body;
  });
  if (!same) begun_ = {}, watched_time_ = 0, fresh_.clear(), modes_ = std::move(modes);
}

void ModeFreezing::prepare(EquationsOfMotion& equations, State& state) {
  list_modes(equations.layout());
  // Time set back to where the last step began undoes what froze there; set back further, all begins anew.
  if (state.time == begun_.time)
    undo_freezing();
  else if (state.time < begun_.time)
    modes_.clear(), list_modes(equations.layout());
  fresh_.clear();
  const Layout& layout = equations.layout();
  r_.setZero(layout.v_count()), zero_v_.setZero(layout.v_count()), zero_rows_.setZero(layout.row_count());
  for (Mode& m : modes_) {
    m.frozen = false;
    m.seen = 0;
    m.patience = 1;
  }
  earlier_ = statistics_ = {};
  HeldCoordinates* held = equations.parts().held;
  if (!modes_.empty() && (!held || !held->hold({modes_.front().v})))
    throw SceneError("modes of '" + modes_.front().history.body + "' cannot be frozen in these equations",
                     "ModeFreezing", "put it around the integrator, not into a loaded one");
  hold(equations);
  method_->start(equations, state);
  watch(state);
}

void ModeFreezing::undo_freezing() {
  for (std::size_t i = 0; i < fresh_.size(); ++i) {
    fresh_[i]->history.energy_taken -= fresh_energy_[i];
    --fresh_[i]->history.freezes;
  }
}

StepResult ModeFreezing::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  if (!(t_stop > state.time)) return {};
  // 1. What is quiet freezes, less the softest if joints need them to move.
  fresh_.clear(), fresh_energy_.clear();
  std::vector<Mode*> quiet = find_quiet(state.time);
  while (!quiet.empty() && !freeze(equations, state, quiet)) {
    quiet.back()->seen = 0;
    quiet.back()->patience *= 4;
    quiet.pop_back();
    if (quiet.empty()) start_method(equations, state);  // its factor is gone
  }
  // 2. The step, again with fewer modes frozen where they would have lacked too much.
  StepResult result;
  do {
    begun_ = state;
    const bool holds = !held_.empty();
    const double left = t_stop - state.time, cuts = holds ? std::ceil(left / parameters_.interval - 1e-6) : 1;
    result = method_->step(equations, state, cuts > 1 ? state.time + left / cuts : t_stop,
                           holds ? Multipliers::found : multipliers());
    statistics_ = earlier_;
    statistics_ += method_->statistics();
    if (!result.ok()) return result;
  } while (!held_.empty() && thaw(equations, state));

  const double length = state.time - begun_.time;
  watched_time_ += length;
  for (Mode& m : modes_)
    if (m.frozen) m.frozen_time += length;
  watch(state);
  return result;
}

/// How far the modes that move have moved since they became quiet.
void ModeFreezing::watch(const State& state) {
  for (Mode& m : modes_) {
    if (m.frozen) continue;
    const double eta = state.q[m.q], speed = std::abs(state.v[m.v]);
    m.low = std::min(m.low, eta), m.high = std::max(m.high, eta), m.fastest = std::max(m.fastest, speed);
    if (m.seen++ == 0 || m.motion() > kQuiet * parameters_.displacement) {
      m.low = m.high = eta, m.fastest = speed, m.since = state.time;
      m.seen = 1;
    }
  }
}

/// The stiffest modes, as far as they are quiet; none if that would not lengthen the steps.
std::vector<ModeFreezing::Mode*> ModeFreezing::find_quiet(double time) {
  std::vector<Mode*> quiet;
  for (Mode& m : modes_) {
    if (m.frozen) continue;
    double lacking = lack(m.body) + m.motion();
    for (const Mode* other : quiet)
      if (other->body == m.body) lacking += other->motion();
    const bool rests =
        m.seen >= kLeastSteps && time - m.since >= wait(m) && lacking <= kJoin * parameters_.displacement;
    if (rests) {
      quiet.push_back(&m);
      continue;
    }
    if (!quiet.empty() && m.stiffness > kGain * kGain * quiet.front()->stiffness) quiet.clear();
    break;
  }
  return quiet;
}

void ModeFreezing::hold(EquationsOfMotion& equations) {
  held_.clear();
  for (const Mode& m : modes_)
    if (m.frozen) held_.push_back(m.v);
  if (HeldCoordinates* held = equations.parts().held) held->hold(held_);
}

/// False, and nothing has happened, where joints need these modes: what they do to the rows nothing else can.
bool ModeFreezing::freeze(EquationsOfMotion& equations, State& state, const std::vector<Mode*>& quiet) {
  constexpr TangentWeights kMass{0, 0, 1};
  const auto rate_of_rows = [&](const VectorX& v) {
    VectorX rate = zero_rows_;
    equations.evaluate(state.time, state.q, v, Level::velocity);
    if (rate.size() > 0) equations.constraint(Level::velocity, rate);
    return rate;
  };
  // 1. With these modes still free: their mobility, the momentum of the rates that go, and what they do to the rows.
  equations.memory().recall(state.quarter_turns);
  VectorX rates = zero_v_, trial = zero_v_, momentum = zero_v_;
  for (std::size_t i = 0; i < quiet.size(); ++i) {
    rates[quiet[i]->v] = state.v[quiet[i]->v];
    trial[quiet[i]->v] = std::cos(static_cast<double>(i)) / quiet[i]->reach;  // any mixture
  }
  const VectorX still = rate_of_rows(zero_v_), moved = rate_of_rows(trial) - still;
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  equations.factorize(kMass, zero_v_, zero_rows_, nullptr);
  for (Mode* m : quiet) {
    VectorX unit = VectorX::Unit(zero_v_.size(), m->v), rows = zero_rows_;
    equations.solve(unit, rows);
    m->mobility = std::max(unit[m->v], kLeastMobility);
  }
  equations.residual(rates, zero_rows_, momentum);
  equations.residual(zero_v_, zero_rows_, r_);
  momentum -= r_;
  const double kinetic = equations.energy().kinetic;

  // 2. With them held: what moves on takes that momentum over.
  for (Mode* m : quiet) m->frozen = true;
  hold(equations);
  VectorX v = state.v - rates, rows = -rate_of_rows(v);
  equations.factorize(kMass, zero_v_, zero_rows_, nullptr);
  for (int velocity : held_) momentum[velocity] = 0;
  equations.solve(momentum, rows);
  v += momentum;
  for (int velocity : held_) v[velocity] = 0;
  rows = moved;
  trial.setZero();
  equations.solve(trial, rows);
  if (!v.allFinite() || !(largest(rate_of_rows(trial) - still - moved) <= kDone * largest(moved) + kNothing)) {
    for (Mode* m : quiet) m->frozen = false;
    hold(equations);
    return false;
  }

  // 3. The account.
  equations.evaluate(state.time, state.q, v, Level::velocity);
  const double taken = kinetic - equations.energy().kinetic, squares = rates.squaredNorm();
  for (Mode* m : quiet) {
    const double rate = rates[m->v], share = squares > 0 ? rate * rate / squares : 0;
    m->swing = {.z = 0, .rate = rate};
    m->frozen_since = state.time;
    m->history.energy_taken += share * taken;
    ++m->history.freezes;
    fresh_.push_back(m), fresh_energy_.push_back(share * taken);
  }
  state.v = v;
  start_method(equations, state);
  return true;
}

void ModeFreezing::start_method(EquationsOfMotion& equations, State& state) {
  earlier_ += method_->statistics();
  hold(equations);
  method_->start(equations, state);
  if (!held_.empty()) find_holding_forces(equations, state);
}

void ModeFreezing::find_holding_forces(EquationsOfMotion& equations, const State& state) {
  equations.parts().held->hold({});
  equations.memory().recall(state.quarter_turns);
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  equations.residual(state.v_dot, state.lambda, r_);
  equations.parts().held->hold(held_);
  for (Mode& m : modes_)
    if (m.frozen) m.force = -m.mobility * r_[m.v];
}

/// Where frozen modes lack too much at the end of a step, lets the largest go at its start; true: it did.
bool ModeFreezing::thaw(EquationsOfMotion& equations, State& state) {
  for (Mode& m : modes_) m.force_then = m.force, m.swing_then = m.swing;
  find_holding_forces(equations, state);
  order_.clear();
  for (Mode& m : modes_) {
    if (!m.frozen) continue;
    m.swing = driven(m.swing, m.mobility * m.stiffness, m.mobility * m.damping, m.force_then, m.force,
                     state.time - begun_.time);
    order_.push_back(&m);
  }
  std::ranges::sort(order_, std::ranges::greater{}, [](const Mode* m) { return m->lack(); });
  bool thawed = false;
  for (Mode* m : order_) {
    if (lack(m->body) <= parameters_.displacement) continue;
    m->frozen = false;
    m->seen = 0;
    if (begun_.time - m->frozen_since < kShortly * wait(*m)) m->patience *= 2;
    ++m->history.thaws;
    thawed = true;
  }
  if (!thawed) return false;
  state = begun_;
  for (Mode& m : modes_) m.swing = m.swing_then;
  start_method(equations, state);
  return true;
}

/// What a body's frozen modes lack together.
double ModeFreezing::lack(int body) const {
  double sum = 0;
  for (const Mode& m : modes_)
    if (m.frozen && m.body == body) sum += m.lack();
  return sum;
}

bool ModeFreezing::keep(Archive& archive, EquationsOfMotion& equations, const State& state) {
  archive.same("displacement", parameters_.displacement);
  archive.same("interval", parameters_.interval);
  archive.same("modes", static_cast<double>(modes_.size()));
  archive("statistics", statistics_);
  archive("earlier", earlier_);
  archive("watched_time", watched_time_);
  archive("begun", begun_);
  std::vector<int> fresh;
  for (const Mode* m : fresh_) fresh.push_back(static_cast<int>(m - modes_.data()));
  archive("fresh", fresh);
  archive("fresh_energy", fresh_energy_);
  fresh_.clear();
  for (int m : fresh)
    if (m >= 0 && static_cast<std::size_t>(m) < modes_.size() && fresh_.size() < fresh_energy_.size())
      fresh_.push_back(&modes_[static_cast<std::size_t>(m)]);
  for (std::size_t i = 0; i < modes_.size(); ++i)
    archive.group("mode " + std::to_string(i), [&] {
      Mode& m = modes_[i];
      std::array<double, 12> motion{m.since, m.low,        m.high,    m.fastest,      m.patience,   m.mobility,
                                    m.force, m.force_then, m.swing.z, m.frozen_since, m.swing.rate, m.frozen_time};
      archive("motion", motion);
      m.since = motion[0], m.low = motion[1], m.high = motion[2], m.fastest = motion[3], m.patience = motion[4];
      m.mobility = motion[5], m.force = motion[6], m.force_then = motion[7];
      m.swing = {.z = motion[8], .rate = motion[10]}, m.frozen_since = motion[9], m.frozen_time = motion[11];
      archive("then", m.swing_then.z);
      archive("then_rate", m.swing_then.rate);
      archive("seen", m.seen);
      archive("frozen", m.frozen);
      archive("freezes", m.history.freezes);
      archive("thaws", m.history.thaws);
      archive("energy_taken", m.history.energy_taken);
    });
  if (archive.loads()) {
    hold(equations);
    State begun = state;
    method_->start(equations, begun);
  }
  bool kept = false;
  archive.group("moving", [&] { kept = method_->history(archive, equations, state); });
  return kept;
}

void ModeFreezing::interpolate(const Layout& layout, const State& from, const State& to, double time,
                               State& out) const {
  method_->interpolate(layout, from.time == begun_.time ? begun_ : from, to, time, out);
}

std::vector<ModeFreezing::History> ModeFreezing::history() const {
  std::vector<History> all;
  for (const Mode& m : modes_) {
    all.push_back(m.history);
    all.back().frozen_part = watched_time_ > 0 ? m.frozen_time / watched_time_ : 0;
  }
  std::ranges::sort(all, {}, [](const History& h) { return std::tie(h.body, h.mode); });
  return all;
}

double ModeFreezing::energy_taken() const {
  double sum = 0;
  for (const Mode& m : modes_) sum += m.history.energy_taken;
  return sum;
}

std::string ModeFreezing::report() const {
  double part = 0;
  int freezes = 0, thaws = 0;
  for (const History& h : history()) part += h.frozen_part, freezes += h.freezes, thaws += h.thaws;
  char line[160];
  std::snprintf(line, sizeof line, "of %zu modes %.1f frozen in the mean; %d freezes, %d thaws, %.3g J taken",
                modes_.size(), part, freezes, thaws, energy_taken());
  return line;
}

}  // namespace lithe
