#include "tools/stability/methods/theta_rule.h"

#include "engine/base/error.h"
#include "engine/motion/projection.h"
#include "tools/stability/methods/step_pattern.h"

namespace lithe::lab {
namespace {

constexpr int kMaxNewton = 60;
constexpr double kConverged = 1e-13;  // of velocities, relative to the largest and 1

}  // namespace

void ThetaRule::prepare(EquationsOfMotion& equations, State& state) {
  if (equations.layout().row_count() > 0)
    throw SceneError("the rule knows no constraints", name(), "give it free bodies and forces");
  const int nv = equations.layout().v_count();
  statistics_ = {};
  for (VectorX* x : {&v_, &d_, &v_dot_, &rv_}) x->setZero(nv);
  q_ = state.q;
  none_.resize(0);
  state.v_dot.resize(nv);
  state.lambda.resize(0);
  Projector(equations).accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
}

StepResult ThetaRule::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  const double h = next_step(Steps::constant, parameters_.step, 0, t_stop - state.time), th = parameters_.theta * h;
  const double time = h == t_stop - state.time ? t_stop : state.time + h;
  v_dot_ = state.v_dot;
  bool converged = false;
  for (int k = 0; k < kMaxNewton && !converged; ++k) {
    v_ = state.v + th * v_dot_;
    d_ = th * v_;
    equations.layout().retract(state.q, d_, q_);
    equations.evaluate(state.time + th, q_, v_, Level::velocity);
    equations.residual(v_dot_, none_, rv_);
    rv_ *= -1;
    equations.factorize({th * th, th, 1}, v_dot_, none_, nullptr);
    equations.solve(rv_, none_);
    v_dot_ += rv_;
    ++statistics_.newton_iterations;
    if (!v_dot_.allFinite()) return {StepResult::Outcome::failed, "Newton's corrections are not finite"};
    converged = h * rv_.cwiseAbs().maxCoeff() < kConverged * (1 + state.v.cwiseAbs().maxCoeff());
  }
  if (!converged) ++statistics_.newton_failures;
  d_ = h * (state.v + th * v_dot_);
  equations.layout().retract(state.q, d_, state.q);
  state.v += h * v_dot_;
  state.v_dot = v_dot_;
  state.time = time;
  ++statistics_.steps;
  return {};
}

}  // namespace lithe::lab
