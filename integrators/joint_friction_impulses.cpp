#include "integrators/joint_friction_impulses.h"

#include <sstream>

#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/contact/rigid_contacts.h"

namespace lithe {
namespace {

// The factor is of the step's middle, the velocities are of its end: each round leaves a share of the order of the
// step.
constexpr int kMaxRounds = 10;
constexpr double kSettled = 1e-13;  // of the impulses

JointSurfaces* joints_of(EquationsOfMotion& equations) {
  const RigidContacts* rigid = equations.parts().rigid_contacts;
  return rigid ? rigid->joints() : nullptr;
}

}  // namespace

void JointFrictionImpulses::check(EquationsOfMotion& equations) {
  const RigidContacts* rigid = equations.parts().rigid_contacts;
  if (rigid && rigid->joints() && rigid->any())
    throw SceneError("set-valued friction in joints and contacts of rigid surfaces are in one scene",
                     "Integrator::start",
                     "give the joints JointBristles, or the contacts a compliant law: {.law = Compliance{...}}");
}

void JointFrictionImpulses::leave_out(EquationsOfMotion& equations, State& state) {
  JointSurfaces* joints = joints_of(equations);
  if (!joints) return;
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  joints->find_directions(D_);
  problem_.before = D_.transpose() * state.v;
  places_.clear();
  for (const auto& surface : joints->surfaces())
    for (int k = 0; k < surface.count; ++k) places_.push_back(surface.kept + k);
  kept_ = state.v(places_);
  state.v(places_).setZero();
}

void JointFrictionImpulses::put_back(VectorX& v) const {
  if (!places_.empty()) v(places_) = kept_;
}

void JointFrictionImpulses::keep(EquationsOfMotion& equations, double h, VectorX& v, VectorX& v_dot) const {
  if (!joints_of(equations)) return;
  v(places_) = p_ / h;
  v_dot(places_).setZero();
}

/// What unit impulses do, by the last factor.
void JointFrictionImpulses::respond(EquationsOfMotion& equations) {
  JointSurfaces& joints = *joints_of(equations);
  joints.find_directions(D_);
  Y_ = D_;
  L_.setZero(equations.layout().row_count(), D_.cols());
  for (int k = 0; k < D_.cols(); ++k) {
    equations.solve(Y_.col(k), L_.col(k));
    joints.felt(L_.col(k));
  }
  by_lambda_.resize(joints.surfaces().size());
  for (std::size_t i = 0; i < by_lambda_.size(); ++i) joints.find_presses(joints.surfaces()[i], by_lambda_[i]);
}

void JointFrictionImpulses::form(EquationsOfMotion& equations, double h) {
  const auto& surfaces = joints_of(equations)->surfaces();
  problem_.surfaces.resize(surfaces.size());
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const auto& surface = surfaces[i];
    auto& of = problem_.surfaces[i];
    of.first = surface.first, of.count = surface.count;
    of.load = h * surface.friction->load();
    of.friction = [&law = *surface.friction](double speed) { return law.friction(speed); };
    of.presses.resize(by_lambda_[i].size());
    for (std::size_t k = 0; k < by_lambda_[i].size(); ++k) {
      of.presses[k].by = by_lambda_[i][k] * L_;
      of.presses[k].constant = by_lambda_[i][k] * felt_ - of.presses[k].by * p_;
    }
  }
}

bool JointFrictionImpulses::apply(EquationsOfMotion& equations, const State& start, double time, VectorX& rows,
                                  VectorX& v, VectorX& d) {
  JointSurfaces* joints = joints_of(equations);
  if (!joints) return false;
  const double h = time - start.time;
  sweeps_ = 0;
  respond(equations);
  problem_.W = D_.transpose() * Y_;
  p_.setZero(D_.cols());
  rv_.resize(v.size()), rl_.resize(rows.size());
  closed_.setZero(v.size());
  JointFrictionProblem::Result result{};
  for (int round = 0; round < kMaxRounds; ++round) {
    // 1. The end of the step by the impulses so far, with joints closed.
    v_ = v + closed_ + Y_ * p_;
    d_ = d + h / 2 * Y_ * p_;
    q_ = start.q;
    equations.layout().retract(start.q, d_, q_);
    equations.evaluate(time, q_, v_, Level::velocity);
    equations.constraint(Level::velocity, rl_);
    rl_ = -rl_;
    rv_.setZero();
    equations.solve(rv_, rl_);
    closed_ += rv_, v_ += rv_, rows += rl_;
    // 2. Impulses anew, by how the surfaces slide there.
    joints->find_directions(D_);
    problem_.free = D_.transpose() * v_ - problem_.W * p_;
    felt_ = rows + L_ * p_;
    joints->felt(felt_);
    form(equations, h);
    const VectorX last = p_;
    result = problem_.solve(p_);
    sweeps_ += result.sweeps;
    if (!p_.allFinite() || (p_ - last).lpNorm<Eigen::Infinity>() <= kSettled * p_.lpNorm<Eigen::Infinity>()) break;
  }
  v += closed_ + Y_ * p_;
  d += h / 2 * Y_ * p_;
  rows += L_ * p_;
  if (!result.converged && !warned_) {
    warned_ = true;
    std::ostringstream message;
    message << "friction in joints: after " << result.sweeps << " sweeps an impulse still changes by " << result.change
            << " N s at t = " << time << " s (later steps are not reported)\n  fix:  a smaller step.";
    log::warn(message.str());
  }
  return true;
}

}  // namespace lithe
