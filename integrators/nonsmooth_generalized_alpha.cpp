#include "integrators/nonsmooth_generalized_alpha.h"

#include "engine/archive/archive.h"
#include "engine/base/checks.h"
#include "engine/cones/direct_cone_solver.h"

namespace lithe {
namespace {

constexpr double kTells = 0.1;  // of a step: accelerations of shorter ones are round-off over h²

}  // namespace

NonsmoothGeneralizedAlpha::NonsmoothGeneralizedAlpha(Parameters parameters, std::unique_ptr<ConeSolver> solver)
    : GeneralizedAlpha(
          {.step = parameters.step, .spectral_radius = parameters.spectral_radius, .form = Form::stabilized_index2}),
      impulses_(parameters.contact, solver ? std::move(solver) : std::make_unique<AutomaticConeSolver>()) {
  require::at("NonsmoothGeneralizedAlpha", [&] { require::positive(parameters.step, "step"); });
}

void NonsmoothGeneralizedAlpha::prepare(EquationsOfMotion& equations, State& state) {
  friction_.prepare(equations);
  pressed_.forget();
  impulses_.leave_out_rigid(equations, state.contacts);
  if (!resumes()) impulses_.forget();
  jumped_ = false;
  friction_.leave_out(equations, state);
  GeneralizedAlpha::prepare(equations, state);
  friction_.put_back(state.v);
}

bool NonsmoothGeneralizedAlpha::keep(Archive& archive, EquationsOfMotion& equations, const State& state) {
  GeneralizedAlpha::keep(archive, equations, state);
  impulses_.history(archive);
  archive("jumped", jumped_);
  archive("smooth_v_dot", smooth_v_dot_);
  archive("smooth_lambda", smooth_lambda_);
  return true;
}

StepResult NonsmoothGeneralizedAlpha::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  // 1. The smooth motion.
  t_stop = impulses_.next_stop(state.time, t_stop);
  impulses_.leave_out_rigid(equations, state.contacts);
  friction_.leave_out(equations, state);
  start_ = state;
  if (jumped_) {
    if (state.lambda.size() == 0) state.lambda.swap(no_lambda_);
    state.v_dot = smooth_v_dot_, state.lambda = smooth_lambda_;
  }
  jumped_ = false;
  drift(state, drift_);
  rl_ = state.lambda;
  const StepResult result = GeneralizedAlpha::advance(equations, state, t_stop);
  if (!result.ok()) friction_.put_back(state.v);
  if (!result.ok() || !equations.parts().rigid_contacts) return result;
  const Layout& layout = equations.layout();
  const double h = state.time - start_.time;
  if (!(h > 0)) return result;

  // 2. Contact, in the middle of it.
  d_.resize(state.v.size());
  layout.difference(start_.q, state.q, d_);
  v_ = state.v;
  q_ = start_.q;
  rv_ = h / 2 * start_.v;  // an expression would be a vector of its own
  layout.retract(start_.q, rv_, q_);
  equations.evaluate(start_.time + h / 2, q_, start_.v, Level::velocity);
  equations.factorize({h * h / 4, h / 2, 1}, state.v_dot, state.lambda, nullptr);
  rl_ = h / 2 * (rl_ + state.lambda);
  const bool near = impulses_.find(equations, start_, h);
  bool rubs = false;
  if (impulses_.cut() == 0) {
    rubs = friction_.apply(equations, start_, state.time, near ? &impulses_ : nullptr, rl_, d_, q_, v_);
    if (near && !rubs) impulses_.act(equations, start_, h, v_, d_);
  }
  if (impulses_.cut() > 0) {
    impulses_.finish_by(state.time);
    state = start_;
    restart(equations, state, &drift_);
    smooth_v_dot_ = state.v_dot, smooth_lambda_ = state.lambda;
    jumped_ = true;
    friction_.put_back(state.v);
    return advance(equations, state, start_.time + impulses_.cut());
  }
  if (!near && !rubs) {
    impulses_.remember(equations, v_, h, state.contacts);
    return result;
  }
  if (h > kTells * parameters().step) drift(state, drift_);
  if (!rubs) layout.retract(start_.q, d_, q_);

  // 3. Joints closed again, and a history from here on.
  rl_.resize(layout.row_count());
  if (rl_.size() > 0 && !rubs) {
    equations.evaluate(state.time, q_, v_, Level::velocity);
    equations.constraint(Level::position, rl_);
    rl_ = -rl_;
    for (int row : equations.velocity_rows()) rl_[row] = 0;
    rv_.setZero(v_.size());
    equations.solve(rv_, rl_);
    layout.retract(q_, rv_, q_);
    equations.constraint(Level::velocity, rl_);
    rl_ = -rl_;
    rv_.setZero();
    equations.solve(rv_, rl_);
    v_ += rv_;
  }
  if (equations.reacts()) {
    const ReactionStates::Impulses acted{near ? &impulses_.total() : nullptr, friction_};
    pressed_.follow(equations, state.v, state.lambda, h, acted, v_);
  }
  state.q = q_;
  state.v = v_;
  if (!q_.allFinite() || !v_.allFinite()) {
    friction_.put_back(state.v);
    return {StepResult::Outcome::failed, "the contact problem gives no finite values at the step of " + step_text(h)};
  }
  // The smooth motion goes on as before it, or each step would begin with an acceleration (am - af) h too late, which
  // damps what slides or rests for long in proportion to the step.
  restart(equations, state, &drift_);
  smooth_v_dot_ = state.v_dot, smooth_lambda_ = state.lambda;
  jumped_ = true;
  state.v_dot = (state.v - start_.v) / h;
  friction_.keep(equations, h, state.v, state.v_dot);
  no_lambda_.resize(0);
  state.lambda.swap(no_lambda_);
  impulses_.remember(equations, v_, h, state.contacts);
  return result;
}

}  // namespace lithe
