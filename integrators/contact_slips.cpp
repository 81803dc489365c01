// Where ContactImpulses puts slips that end or begin within the step.
#include <algorithm>
#include <cmath>

#include "integrators/contact_impulses.h"

namespace lithe {

/// Friction that changes at a time τ within the step makes a velocity that grows from there on only. What it differs
/// by, r_late, moves bodies by (h - τ)/2 Y r_late; taken over the whole step, as other impulses are, it moves them by
/// h/2. A slip that ends at τ has r_late beyond the kinetic friction that slows it down to there, one that begins has
/// what its impulse lacks for holding it on. Surfaces in touch throughout the step, without an impact.
void ContactImpulses::place_slips(RigidContacts& contacts, double h, const VectorX& v_end, VectorX& d) {
  ConeProblem& problem = contacts.problem();
  const auto& points = contacts.points();
  const int n = static_cast<int>(points.size());
  const auto in_touch = [&](int i) {
    const int row = points[i].first;
    return r_[row] > 0 && last_[row] > 0 && weights_[i] == h / 2;
  };
  const auto before = [&](int i) -> Eigen::Vector2d {
    return points[i].before.tail<2>() - growth_.segment<2>(points[i].first + 1);
  };
  now_.resize(problem.rows), moved_.resize(problem.rows);
  contacts.velocity(v_end, now_);
  now_ += growth_;
  // 1. What friction does late, in r_late.
  impulse_.setZero(problem.rows);
  times_.setZero(n);  // τ; 0: nothing late
  bool stops = false, begins = false;
  for (int i = 0; i < n; ++i) {
    if (!in_touch(i)) continue;
    const int row = points[i].first;
    const double slip = before(i).norm(), left = now_.segment<2>(row + 1).norm();
    if (slip * h > parameters_.position_tolerance && left * h <= parameters_.position_tolerance) {
      impulse_.segment<2>(row + 1) = r_.segment<2>(row + 1) + points[i].law.friction * r_[row] / slip * before(i);
      times_[i] = h;  // found below
      stops = true;
    } else if (friction_.held_time()[i] > 0) {
      impulse_.segment<2>(row + 1) = friction_.released()[i] * r_.segment<2>(row + 1);
      begins = true;
    }
  }
  if (!stops && !begins) return;
  // 2. Slips end where kinetic friction, going on, would have turned them back.
  if (stops) {
    dv_.setZero();
    contacts.add_response(impulse_, nullptr, dv_);
    contacts.velocity(dv_, moved_);
  }
  for (int i = 0, end; i < n; i = end) {
    double time = 0, normal = 0;  // one time for a pair
    for (end = i; end < n && points[end].pair == points[i].pair; ++end) {
      const int row = points[end].first;
      if (times_[end] > 0) {
        const Eigen::Vector2d was = before(end);
        const double turns = was.dot(was - now_.segment<2>(row + 1) + moved_.segment<2>(row + 1));
        if (turns > was.squaredNorm()) time += r_[row] * h * was.squaredNorm() / turns, normal += r_[row];
      } else if (friction_.held_time()[end] > 0) {
        time += r_[row] * friction_.held_time()[end], normal += r_[row];
      }
    }
    for (int k = i; k < end; ++k) times_[k] = normal > 0 ? -0.5 * time / normal : 0;
  }
  for (int i = 0; i < n; ++i)
    late_.segment<2>(points[i].first + 1) = times_[i] * impulse_.segment<2>(points[i].first + 1);
  dv_.setZero();
  contacts.add_response(late_, nullptr, dv_);
  d += dv_;
}

}  // namespace lithe
