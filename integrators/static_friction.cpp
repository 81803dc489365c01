#include "integrators/static_friction.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lithe {
namespace {

constexpr double kRoundOff = 1e-9;  // of a coefficient
constexpr double kOnCone = 1e-7;    // of a coefficient, above the tolerance of impulses

Eigen::Vector2d across(const VectorX& x, int row) { return x.segment<2>(row + 1); }

}  // namespace

void StaticFriction::begin(RigidContacts& contacts, const ContactMemory& memory, const VectorX& last,
                           const VectorX& growth, double h, double at_rest) {
  const auto& points = contacts.points();
  const auto n = static_cast<Eigen::Index>(points.size());
  h_ = h, at_rest_ = at_rest;
  for (VectorX* x : {&start_, &end_, &held_time_, &released_}) x->setZero(n);
  any_ = std::any_of(points.begin(), points.end(),
                     [](const RigidContacts::Point& p) { return p.law.static_friction > p.law.friction; });
  if (!any_) return;
  phases_.assign(points.size(), Phase::equal);
  rested_.assign(points.size(), 0);
  last_ = last, growth_ = growth;
  held_slip_.setZero(n), earlier_.resize(n);
  contacts.recall_slip(memory, earlier_, start_);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const RigidContacts::Point& point = points[i];
    const auto k = static_cast<Eigen::Index>(i);
    // What did not act yet slides as its bodies move.
    const bool acted = !std::isnan(start_[k]);
    if (!acted) start_[k] = (point.before.tail<2>() - across(growth, point.first)).norm();
    if (!(point.law.static_friction > point.law.friction)) continue;
    const bool rests = start_[k] * h <= at_rest;
    rested_[i] = acted && rests && earlier_[k] * h <= at_rest;
    phases_[i] = rests ? Phase::sticks : Phase::slides;
    contacts.problem().contacts[i].friction = rests ? point.law.static_friction : point.law.friction;
  }
}

/// Sums over the points of a pair: loads now, the mean slip of what they carry, and the ratio in the last step of all
/// that were held then. A pair's points may share its load otherwise at each step, and one that carries nothing has no
/// memory: the pair as a whole has.
StaticFriction::Load StaticFriction::load(const RigidContacts& contacts, const VectorX& r, int first, int end,
                                          Phase phase) const {
  Load sum;
  Eigen::Vector2d last_across(0, 0);
  double last_normal = 0;
  bool rested = true;
  for (int i = first; i < end; ++i) {
    const int row = contacts.points()[i].first;
    if (last_[row] > 0 && (phases_[i] == Phase::sticks || phases_[i] == Phase::breaks)) {
      last_across += across(last_, row), last_normal += last_[row];
      rested = rested && rested_[i];
    }
    if (phases_[i] != phase || !(r[row] > 0)) continue;
    sum.across += across(r, row), sum.normal += r[row];
    sum.slip += r[row] * across(u_, row).norm();
  }
  if (sum.normal > 0) sum.slip /= sum.normal;
  sum.last_ratio = rested && last_normal > 0 ? last_across.norm() / last_normal : std::nan("");
  return sum;
}

/// The load over its normal part passes the static coefficient within the step, on a straight line of the mean
/// `last_ratio` in the last step and `ratio` in this one.
bool StaticFriction::settle(RigidContacts& contacts, int first, int end, Phase phase, double ratio, double last_ratio) {
  const RigidContact& law = contacts.points()[first].law;
  const double rise = ratio - last_ratio;
  double friction = law.friction, share = 0;
  if (rise > 0) {  // false for NaN
    share = std::clamp(0.5 + (law.static_friction - ratio) / rise, 0.0, 1.0);
    const double held = ratio + rise * (share - 1) / 2;  // mean up to then
    friction = share * held + (1 - share) * law.friction;
  }
  bool changed = false;
  for (int i = first; i < end; ++i) {
    if (phases_[i] != phase) continue;
    phases_[i] = Phase::settled;
    held_time_[i] = share * h_;
    released_[i] = friction > 0 ? 1 - ratio / friction : 0;
    double& now = contacts.problem().contacts[i].friction;
    changed = changed || now != friction;
    now = friction;
  }
  return changed;
}

bool StaticFriction::revise(RigidContacts& contacts, const VectorX& r) {
  if (!any_) return false;
  const auto& points = contacts.points();
  ConeProblem& problem = contacts.problem();
  const int n = static_cast<int>(points.size());
  problem.velocity(r, u_);
  for (int i = 0; i < n; ++i) end_[i] = across(u_, points[i].first).norm();
  bool changed = false;
  for (int first = 0, end; first < n; first = end) {
    for (end = first; end < n && points[end].pair == points[first].pair; ++end) {
    }
    const RigidContact& law = points[first].law;
    if (!(law.static_friction > law.friction)) continue;
    // 1. What broke away with the static cone slides now with the kinetic one: from both, the load that it had.
    if (const Load now = load(contacts, r, first, end, Phase::breaks); now.normal > 0) {
      double held_slip = 0;
      for (int i = first; i < end; ++i)
        if (phases_[i] == Phase::breaks && r[points[i].first] > 0) held_slip += held_slip_[i] * r[points[i].first];
      held_slip /= now.normal;
      const double more = now.slip - held_slip;
      const double ratio =
          law.static_friction + (law.static_friction - law.friction) * (more > 0 ? held_slip / more : 0);
      changed |= settle(contacts, first, end, Phase::breaks, ratio, now.last_ratio);
    }
    // 2. What is held through the step, but will not be at its end.
    const Load held = load(contacts, r, first, end, Phase::sticks);
    const double ratio = held.normal > 0 ? held.across.norm() / held.normal : 0;
    const bool holds = held.slip * h_ <= at_rest_;
    // A load that grows slowly leaves the cone by a slip below what counts as rest: the cone hides how large it is.
    bool leaves = false;
    if (holds && ratio + (ratio - held.last_ratio) / 2 > law.static_friction * (1 + kRoundOff)) {
      leaves = ratio > law.static_friction * (1 - kOnCone);
      if (!leaves) changed |= settle(contacts, first, end, Phase::sticks, ratio, held.last_ratio);
    }
    // Points that carry nothing too: what leaves the loaded ones may go to them.
    for (int i = first; i < end; ++i) {
      const int row = points[i].first;
      if (phases_[i] == Phase::sticks && (leaves || end_[i] * h_ > at_rest_)) {
        held_slip_[i] = end_[i];
        phases_[i] = Phase::breaks;
        problem.contacts[i].friction = law.friction;
        changed = true;
      } else if (phases_[i] == Phase::slides && end_[i] * h_ > at_rest_) {
        // 3. What turned back has been at rest.
        const Eigen::Vector2d was = points[i].before.tail<2>() - across(growth_, row);
        if (was.dot(across(u_, row)) >= 0) continue;
        phases_[i] = Phase::sticks;
        problem.contacts[i].friction = law.static_friction;
        changed = true;
      }
    }
  }
  return changed;
}

}  // namespace lithe
