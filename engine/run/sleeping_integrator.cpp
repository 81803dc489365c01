#include "engine/run/sleeping_integrator.h"

#include "engine/archive/archive.h"
#include "engine/motion/projection.h"

namespace lithe {
namespace {

constexpr double kFirstSleep = 10;  // s
constexpr Tolerance kRoundOff{1e-10, 1e-11};

/// Whether the state is at rest for a time h; fills v_dot and lambda.
bool rests(EquationsOfMotion& equations, State& state, double h) {
  const Layout& layout = equations.layout();
  if (!state.v.isZero(0)) return false;
  // 1. What pushes: f - Gᵀ λ at v_dot = 0, with the λ of the motion that would begin.
  const VectorX still = VectorX::Zero(layout.v_count());
  VectorX move = still, rows = VectorX::Zero(layout.row_count());
  VectorX lambda = state.lambda.size() == rows.size() ? state.lambda : rows;
  Projector(equations).accelerations(state.time, state.q, state.v, move, lambda);
  if (!move.allFinite() || !lambda.allFinite()) return false;
  equations.residual(still, lambda, move);
  equations.constraint(Level::position, rows);
  // 2. How far it would come.
  equations.factorize({1, 1 / h, 1 / (h * h)}, still, lambda, nullptr);
  move = -move, rows = -rows;
  equations.solve(move, rows);
  VectorX allowed(move.size());
  layout.magnitudes(state.q, allowed);
  allowed = (kRoundOff.absolute + kRoundOff.relative * allowed.array()).matrix();
  if (!move.allFinite() || (move.array().abs() > allowed.array()).any()) return false;
  state.v_dot = still;
  state.lambda = lambda;
  return true;
}

}  // namespace

void SleepingIntegrator::prepare(EquationsOfMotion& equations, State& state) {
  since_ = state.time;
  // Modes that ModeFreezing held in an earlier run could hide that they are bent.
  if (HeldCoordinates* held = equations.parts().held) held->hold({});
  doze(equations, state, kFirstSleep);
}

StepResult SleepingIntegrator::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  if (asleep_ && t_stop > until_) doze(equations, state, 2 * (t_stop - since_));
  if (!asleep_) return method_->step(equations, state, t_stop, multipliers());
  state.time = t_stop;
  return {};
}

/// Sleeps for `length` since the rest began, or sets the method to work.
void SleepingIntegrator::doze(EquationsOfMotion& equations, State& state, double length) {
  asleep_ = rests(equations, state, length);
  until_ = since_ + length;
  if (!asleep_) method_->start(equations, state);
}

bool SleepingIntegrator::keep(Archive& archive, EquationsOfMotion& equations, const State& state) {
  archive("asleep", asleep_);
  archive("since", since_);
  archive("until", until_);
  if (asleep_) return true;
  if (archive.loads()) {
    State begun = state;
    method_->start(equations, begun);
  }
  bool kept = false;
  archive.group("awake", [&] { kept = method_->history(archive, equations, state); });
  return kept;
}

void SleepingIntegrator::interpolate(const Layout& layout, const State& from, const State& to, double time,
                                     State& out) const {
  if (!asleep_) return method_->interpolate(layout, from, to, time, out);
  out = from;
  out.time = time;
}

}  // namespace lithe
