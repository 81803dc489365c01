#include "integrators/reaction_states.h"

#include <algorithm>
#include <cmath>

#include "engine/contact/rigid_contacts.h"
#include "engine/model/layout.h"

namespace lithe {
namespace {

/// Of ṅ = (N - n)/τ over a step: what the midpoint rule moves n by times this is what N moves it by when it stays, so
/// that n does not pass N where steps do not resolve τ. `stiffness`: 1 + h/2τ.
double resolved(double stiffness) {
  const double a = 2 * (stiffness - 1);
  return a > 0 ? stiffness * -std::expm1(-a) / a : 1;
}

}  // namespace

void ReactionStates::find_joined(const EquationsOfMotion& equations) {
  const int velocities = equations.layout().v_count(), rows = equations.layout().row_count();
  if (!joined_.empty()) return;
  joined_.assign(static_cast<std::size_t>(velocities), 0);
  for (VectorX* x : {&push_, &v_dot_, &with_, &without_, &d_}) x->setZero(velocities);
  for (VectorX* x : {&lambda_, &none_}) x->setZero(rows);
  equations.visit_blocks([&](int row, int column, ConstMatrixRef block) {
    if (row >= velocities && row < velocities + rows && column < velocities)
      std::fill_n(joined_.begin() + column, block.cols(), char{1});
  });
}

/// The residual with these multipliers of states that they press otherwise than none do; else 0.
void ReactionStates::keep_states(EquationsOfMotion& equations, const VectorX& v_dot, const VectorX& lambda) {
  equations.residual(v_dot, lambda, with_);
  equations.residual(v_dot, none_, without_);
  for (Eigen::Index i = 0; i < with_.size(); ++i)
    if (joined_[static_cast<std::size_t>(i)] || with_[i] == without_[i]) with_[i] = 0;
}

void ReactionStates::add(EquationsOfMotion& equations, const Impulses& impulses, VectorX& push) {
  if (impulses.contact) equations.parts().rigid_contacts->add_impulses(*impulses.contact, push);
  impulses.friction.add_impulses(equations, push);
}

void ReactionStates::follow(EquationsOfMotion& equations, const VectorX& smooth, const VectorX& lambda, double h,
                            const Impulses& impulses, VectorX& v) {
  find_joined(equations);
  push_.setZero(), lambda_.setZero(), v_dot_.setZero();
  add(equations, impulses, push_);
  if (push_.isZero(0)) return;
  equations.solve(push_, lambda_);  // the impulses of the multipliers
  lambda_ = lambda + lambda_ / h;
  keep_states(equations, v_dot_, lambda_);
  equations.residual(v_dot_, lambda, without_);
  for (Eigen::Index i = 0; i < with_.size(); ++i)
    if (with_[i] != 0) with_[i] = h * (without_[i] - with_[i]);
  lambda_.setZero(), without_ = with_;
  equations.solve(with_, lambda_);
  for (Eigen::Index i = 0; i < with_.size(); ++i)
    if (without_[i] != 0) v[i] = smooth[i] + with_[i] * resolved(without_[i] / with_[i]);
}

void ReactionStates::follow_midpoint(EquationsOfMotion& equations, const State& start, double h, const VectorX& total,
                                     const Impulses& impulses, const VectorX& d, VectorX& v) {
  find_joined(equations);
  q_.resize(start.q.size());
  d_ = d / 2;
  equations.layout().retract(start.q, d_, q_);
  v_dot_ = (start.v + v) / 2;
  equations.evaluate(start.time + h / 2, q_, v_dot_, Level::velocity);
  v_dot_ = (v - start.v) / h;
  // Multipliers that balance the momenta of the step, of what closes joints at its end too.
  lambda_ = total / h;
  equations.residual(v_dot_, lambda_, push_);
  push_ *= -h;
  add(equations, impulses, push_);
  lambda_.setZero();
  equations.solve(push_, lambda_);
  lambda_ = (total + lambda_) / h;
  keep_states(equations, v_dot_, lambda_);
  with_ *= -h;
  lambda_.setZero(), without_ = with_;
  equations.solve(with_, lambda_);
  v += with_;
  for (Eigen::Index i = 0; i < with_.size(); ++i)
    if (without_[i] != 0) v[i] = start.v[i] + (v[i] - start.v[i]) * resolved(without_[i] / with_[i]);
}

}  // namespace lithe
