#include "integrators/moreau_jean.h"

#include <algorithm>
#include <cmath>

#include "engine/archive/archive.h"
#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/cones/direct_cone_solver.h"
#include "engine/motion/projection.h"

namespace lithe {
namespace {

// Newton's corrections of a step, whose errors add up over thousands of steps: of the velocities, what further ones
// would change at most.
constexpr double kStable = 1e-8, kEnergy = 1e-9;
constexpr int kMostCorrections = 20, kEnoughToJudge = 4;
constexpr double kFar = 1e-6, kLastDigits = 1e-12;  // of the velocities, of the coordinates: a last one that will do
constexpr double kShortest = 1.0 / 1024;            // of the given step

}  // namespace

MoreauJean::MoreauJean(Parameters parameters, std::unique_ptr<ConeSolver> solver)
    : parameters_(parameters),
      impulses_(parameters.contact, solver ? std::move(solver) : std::make_unique<AutomaticConeSolver>()) {
  require::at("MoreauJean", [&] { require::positive(parameters.step, "step"); });
}

void MoreauJean::prepare(EquationsOfMotion& equations, State& state) {
  friction_.prepare(equations);
  pressed_.forget();
  const int nv = equations.layout().v_count(), rows = equations.layout().row_count();
  if (!resumes()) statistics_ = {}, impulses_.forget();
  for (VectorX* x : {&v_, &d_, &rv_, &lack_, &mean_, &push_, &late_, &free_, &response_, &linear_}) x->setZero(nv);
  for (VectorX* x : {&rl_, &more_, &total_}) x->setZero(rows);
  deforms_ = nodal_ = false;
  for (const auto& body : equations.layout().bodies()) {
    deforms_ |= (body.frame ? 6 : 0) + body.linear > 6;
    nodal_ |= !body.frame && body.linear > 6;
  }
  q_ = state.q;
  if (state.v_dot.size() != nv) state.v_dot.setZero(nv);
  if (state.lambda.size() != rows) state.lambda.setZero(rows);
  projector_.emplace(equations);
  projector_->accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
  lambda_ = state.lambda;
}

StepResult MoreauJean::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  t_stop = impulses_.next_stop(state.time, t_stop);
  if (!(t_stop > state.time)) return {};
  // Equal steps up to t_stop, no longer than the given one.
  const double left = t_stop - state.time, count = std::max(1.0, std::ceil(left / parameters_.step - 1e-6));
  const double h = std::abs(count * parameters_.step - left) > 1e-9 * left ? left / count : parameters_.step;
  const double time = count == 1 ? t_stop : state.time + h;
  const Layout& layout = equations.layout();

  // 1. Without contact: forces and their derivatives in the middle.
  const bool rigid = equations.parts().rigid_contacts != nullptr;
  // Friction by a joint's reaction is linearised about that of this state, loads of contact in the last step included.
  if (equations.reacts())
    projector_->accelerations(state.time, state.q, state.v, v_, lambda_);
  else if (state.lambda.size() == lambda_.size())
    lambda_ = state.lambda;
  if (rigid) impulses_.leave_out_rigid(equations, state.contacts), friction_.leave_out(equations, state);
  d_ = h / 2 * state.v;
  layout.retract(state.q, d_, q_);
  equations.evaluate(state.time + h / 2, q_, state.v, Level::velocity);
  ++statistics_.evaluations;
  rl_.setZero();
  v_.setZero();
  equations.residual(v_, equations.reacts() ? lambda_ : rl_, rv_);
  if (!rv_.allFinite()) {
    friction_.put_back(state.v);
    const auto broken = std::find_if(rv_.begin(), rv_.end(), [](double x) { return !std::isfinite(x); });
    return {StepResult::Outcome::failed, "the equations give no finite values at the step of " + step_text(h) +
                                             "; first in " +
                                             layout.velocity_name(static_cast<int>(broken - rv_.begin()))};
  }
  equations.factorize({h * h / 4, h / 2, 1}, state.v_dot, lambda_, nullptr);
  ++statistics_.factorizations;
  rv_ *= -h;
  equations.constraint(Level::velocity, rl_);
  rl_ = -rl_;
  equations.solve(rv_, rl_);
  v_ = state.v + rv_;
  d_ = h / 2 * (state.v + v_);
  if (deforms_) {
    total_ = rl_;
    if (equations.reacts()) total_ += h * lambda_;
    push_.setZero(), late_.setZero();
    // The factor leaves out how a turn couples modes: corrections have to see what closes joints, too, or it would cost
    // an order.
    if (rl_.size() > 0) {
      layout.retract(state.q, d_, q_);
      close_joints(equations, time);
      total_ += rl_;
      d_ = h / 2 * (state.v + v_);
    }
    if (!correct(equations, state, h)) return halve(equations, state, time);  // it turns too far in a step
    if (rigid) {                                                              // back to where points are found
      mean_ = h / 2 * state.v;
      layout.retract(state.q, mean_, q_);
      equations.evaluate(state.time + h / 2, q_, state.v, Level::velocity);
    }
  }

  // 2. With contact, then with closed joints.
  bool rubs = false, near = false;
  if (rigid) {
    if (!deforms_) total_ = rl_;
    if (!deforms_ && equations.reacts()) total_ += h * lambda_;
    near = impulses_.find(equations, state, h);
    if (impulses_.cut() == 0) {
      rubs = friction_.apply(equations, state, time, near ? &impulses_ : nullptr, total_, d_, q_, v_);
      if (near && !rubs && !nodal_) impulses_.act(equations, state, h, v_, d_);
      if (near && !rubs && nodal_ && !settle(equations, state, h)) return halve(equations, state, time);
    }
    if (impulses_.cut() > 0) {
      impulses_.finish_by(time);
      friction_.put_back(state.v);
      return advance(equations, state, state.time + impulses_.cut());
    }
    statistics_.newton_iterations += impulses_.iterations() + friction_.sweeps();
  }
  if (!rubs) {
    layout.retract(state.q, d_, q_);
    if (rl_.size() > 0) close_joints(equations, time);
  }
  if (rigid && equations.reacts()) {
    const ReactionStates::Impulses acted{near ? &impulses_.total() : nullptr, friction_};
    pressed_.follow_midpoint(equations, state, h, total_, acted, d_, v_);
    equations.evaluate(time, q_, v_, Level::velocity);
    statistics_.evaluations += 2;
  }
  if (rigid) impulses_.remember(equations, v_, h, state.contacts);
  if (!q_.allFinite() || !v_.allFinite()) {
    friction_.put_back(state.v);
    return {StepResult::Outcome::failed, "the contact problem gives no finite values at the step of " + step_text(h)};
  }

  state.v_dot = (v_ - state.v) / h;
  if (rigid) friction_.keep(equations, h, v_, state.v_dot);
  state.time = time;
  state.q = q_;
  state.v = v_;
  state.lambda.resize(0);  // who wants the multipliers asks Snapshot
  ++statistics_.steps;
  return {};
}

/// The step up to `time`, whose corrections do not end.
StepResult MoreauJean::halve(EquationsOfMotion& equations, State& state, double time) {
  const double h = time - state.time;
  friction_.put_back(state.v);
  if (h < kShortest * parameters_.step)
    return {StepResult::Outcome::failed, "Newton's iteration does not converge at the step of " + step_text(h)};
  impulses_.finish_by(time);
  return advance(equations, state, state.time + h / 2);
}

/// Of bodies that deform by linear coordinates: Newton's iteration goes on, along the same factor, to the implicit
/// midpoint rule. Its first iterate alone turns stiff elements by the rotation that the step began with and stretches
/// them; where the step does not resolve them, that feeds their vibrations until they burst (a solid in nodal
/// coordinates: in 0.2 s). A beam's frames turn with it. The midpoint rule keeps the energy of what is linear alone;
/// where bodies have coordinates in the world only, so that their mass is constant, forces are the mean along the step
/// instead (average vector field, Quispel & McLaren 2008), by Simpson's rule, which is exact for the fourth order in
/// which nodes strain a St. Venant-Kirchhoff solid. The factor knows little of how inertia couples modes with a fast
/// turn: false where corrections do not end, or will not, so that the step is halved.
bool MoreauJean::correct(EquationsOfMotion& equations, const State& state, double h) {
  const double tolerance = nodal_ ? kEnergy : kStable;
  double first = 0, before = 0, last = 0;  // corrections
  for (int k = 0; k < kMostCorrections; ++k) {
    rv_ = push_;
    const auto add = [&](double part, double weight) {
      mean_ = part * d_;
      equations.layout().retract(state.q, mean_, q_);
      mean_ = d_ / h;
      equations.evaluate(state.time + part * h, q_, mean_, Level::velocity);
      ++statistics_.evaluations;
      mean_ = (v_ - state.v) / h;
      more_ = total_ / h;
      equations.residual(mean_, more_, lack_);
      rv_ -= weight * h * lack_;
    };
    if (nodal_) add(0, 1.0 / 6), add(1, 1.0 / 6);
    add(0.5, nodal_ ? 2.0 / 3 : 1);
    more_.setZero();
    equations.solve(rv_, more_);
    const double change = rv_.norm();
    if (!std::isfinite(change)) return false;
    v_ += rv_;
    total_ += more_;
    d_ = h / 2 * (state.v + v_) + late_;
    ++statistics_.newton_iterations;
    const double size = v_.norm();
    // By two corrections: where modes and the turn exchange energy they shrink by turns.
    const double rate = k > 1 ? std::sqrt(change / before) : k == 1 ? change / last : 1;
    if (change <= tolerance * size || change * rate <= tolerance * size * (1 - rate)) return true;
    const bool round_off = h * change <= kLastDigits * (1 + q_.cwiseAbs().maxCoeff());
    if (round_off && rate > 0.5) return true;
    if (k == 0) first = change;
    if (k >= kEnoughToJudge && !round_off &&
        change * std::pow(change / first, static_cast<double>(kMostCorrections - 1 - k) / k) > kFar * size)
      return false;
    before = last, last = change;
  }
  return true;
}

/// Contact moves bodies along the step's factor, as if they were linear. Where its law keeps the energy, Newton's
/// iteration goes on with its impulses given; by what that changes the motion without contact is another, for which
/// impulses are found anew. Where they go to and fro between two answers they stay as they were at first. False where
/// corrections do not end.
bool MoreauJean::settle(EquationsOfMotion& equations, const State& state, double h) {
  constexpr int kMostRounds = 10;
  constexpr double kNear = 1e-5;  // of the velocities
  RigidContacts& contacts = *equations.parts().rigid_contacts;
  free_ = v_;
  impulses_.act(equations, state, h, v_, d_);
  if (!std::ranges::all_of(contacts.points(), [](const RigidContacts::Point& point) {
        return point.law.restitution == 1 && point.law.static_friction == 0;
      }))
    return true;
  for (int k = 1; impulses_.cut() == 0 && !impulses_.total().isZero(0); ++k) {
    push_.setZero(), response_.setZero();
    contacts.add_impulses(impulses_.total(), push_);
    contacts.add_response(impulses_.total(), nullptr, response_);
    late_ = d_ - h / 2 * (state.v + v_);
    linear_ = v_;
    if (!correct(equations, state, h)) return false;
    const double off = (v_ - linear_).norm(), size = v_.norm();
    if (off <= kEnergy * size || (k == kMostRounds && off <= kNear * size)) return true;
    const bool last = k == kMostRounds;
    if (last)
      v_ = free_;
    else
      v_ -= response_;
    d_ = h / 2 * (state.v + v_);
    impulses_.act(equations, state, h, v_, d_);
    if (last) return true;
  }
  return true;
}

bool MoreauJean::keep(Archive& archive, EquationsOfMotion& /*equations*/, const State& /*state*/) {
  archive.same("step", parameters_.step);
  archive("statistics", statistics_);
  archive("lambda", lambda_);
  impulses_.history(archive);
  return true;
}

/// Moves positions, then velocities, onto the constraints along the last factor.
void MoreauJean::close_joints(EquationsOfMotion& equations, double time) {
  equations.evaluate(time, q_, v_, Level::velocity);
  ++statistics_.evaluations;
  equations.constraint(Level::position, rl_);
  rl_ = -rl_;
  for (int row : equations.velocity_rows()) rl_[row] = 0;
  rv_.setZero();
  equations.solve(rv_, rl_);
  equations.layout().retract(q_, rv_, q_);
  equations.constraint(Level::velocity, rl_);
  rl_ = -rl_;
  rv_.setZero();
  equations.solve(rv_, rl_);
  v_ += rv_;
}

}  // namespace lithe
