#include "integrators/joint_friction_impulses.h"

#include <Eigen/QR>
#include <algorithm>
#include <sstream>

#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/contact/rigid_contacts.h"

namespace lithe {
namespace {

// The factor is of the step's middle, the velocities are of its end: each round leaves a share of the order of the
// step.
constexpr int kMaxRounds = 10;
constexpr double kSettled = 1e-13;  // of the impulses; m or rad
constexpr double kRests = 1e-10;    // m/s

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
  joints->start();
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
  for (int k = 0; k < D_.cols(); ++k) equations.solve(Y_.col(k), L_.col(k));
  joints.felt(L_);
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
      const MatrixX& by = by_lambda_[i][k];
      of.presses[k].by = by * L_.middleRows(surface.joint_row, by.cols());
      of.presses[k].constant = by * felt_.segment(surface.joint_row, by.cols()) - of.presses[k].by * p_;
    }
  }
}

/// Moves positions so that surfaces which rested before the step and stick in it have not slid.
void JointFrictionImpulses::hold(const std::vector<char>& sticks, VectorX& correction) {
  std::vector<int> held;
  for (std::size_t i = 0; i < sticks.size(); ++i) {
    const auto& surface = problem_.surfaces[i];
    if (!sticks[i] || problem_.before.segment(surface.first, surface.count).norm() > kRests) continue;
    for (int k = 0; k < surface.count; ++k) held.push_back(surface.first + k);
  }
  if (held.empty()) return;
  const MatrixX W = problem_.W(held, held);
  const VectorX x = W.completeOrthogonalDecomposition().solve(way_(held));
  correction -= Y_(Eigen::all, held) * x;
}

bool JointFrictionImpulses::apply(EquationsOfMotion& equations, const State& start, double time, VectorX& rows,
                                  const VectorX& d, VectorX& q, VectorX& v) {
  JointSurfaces* joints = joints_of(equations);
  if (!joints) return false;
  const Layout& layout = equations.layout();
  const double h = time - start.time;
  sweeps_ = 0;
  respond(equations);
  problem_.W = D_.transpose() * Y_;
  p_.setZero(D_.cols());
  rv_.resize(v.size()), rl_.resize(rows.size());
  closed_.setZero(v.size()), corrected_.setZero(v.size());
  JointFrictionProblem::Result result{};
  for (int round = 0; round < kMaxRounds; ++round) {
    // 1. The end of the step by the impulses so far.
    v_ = v + closed_ + Y_ * p_;
    d_ = d + h / 2 * Y_ * p_;
    layout.retract(start.q, d_, q);
    layout.retract(q, corrected_, q);
    equations.evaluate(time, q, v_, Level::velocity);
    // 2. Joints closed there, in velocity and position.
    equations.constraint(Level::velocity, rl_);
    rl_ = -rl_;
    rv_.setZero();
    equations.solve(rv_, rl_);
    closed_ += rv_, v_ += rv_, rows += rl_;
    equations.constraint(Level::position, rl_);
    rl_ = -rl_;
    for (int row : equations.velocity_rows()) rl_[row] = 0;
    rv_.setZero();
    equations.solve(rv_, rl_);
    // 3. Impulses anew, by how the surfaces slide there.
    joints->find_directions(D_);
    problem_.free = D_.transpose() * v_ - problem_.W * p_;
    felt_ = rows + L_ * p_;
    joints->felt(felt_);
    form(equations, h);
    const VectorX last = p_;
    result = problem_.solve(p_);
    sweeps_ += result.sweeps;
    // 4. What sticks stays where it was.
    joints->slid(way_);
    way_ += D_.transpose() * (rv_ + h / 2 * Y_ * (p_ - last));
    hold(result.sticks, rv_);
    corrected_ += rv_;
    if (!p_.allFinite()) break;
    if ((p_ - last).lpNorm<Eigen::Infinity>() <= kSettled * p_.lpNorm<Eigen::Infinity>() &&
        rv_.lpNorm<Eigen::Infinity>() <= kSettled * std::max(1.0, q.lpNorm<Eigen::Infinity>()))
      break;
  }
  v = v + closed_ + Y_ * p_;
  d_ = d + h / 2 * Y_ * p_;
  layout.retract(start.q, d_, q);
  layout.retract(q, corrected_, q);
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
