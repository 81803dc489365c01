// The energy that contact impulses give to bodies whose response the step does not resolve.
#include <algorithm>
#include <cmath>

#include "engine/motion/equations_of_motion.h"
#include "integrators/contact_impulses.h"

namespace lithe {
namespace {

constexpr double kMayGain = 2e-5;  // energy that contact may add in a step, of Σ |r| |u|
constexpr int kRounds = 4;         // of laws that follow from the impulses found

}  // namespace

/// Impacts at their times within the step suppose that bodies move with constant accelerations over it. What elasticity
/// or springs do faster than the step breaks that: a point that leaves as the step begins is brought back within it,
/// and an impulse that then stops it works on a mean velocity outwards; displacements that belong to the time of an
/// impact strain the body. From the motion without contact, v and d, to v' = v + Y r and d' = d + h/2 Y r + y the
/// energy of a linear system changes by
///   Σ r·(w + u')/2 + y·(g(q ⊕ d') + g(q ⊕ (d' - y)))/2,   w = 2 H z - u
/// (g: minus the forces), where z, the mean velocity, and w, that along H as the step begins, are those of the midpoint
/// rule (mean_velocity). Where islands gain by more than round-off and curvature explain, or lose in elastic impacts,
/// their impulses are found anew by a law of the mean velocity, which has y = 0 and can only take energy (resist).
void ContactImpulses::keep_energy(EquationsOfMotion& equations, const State& start, double h, const Others* others,
                                  VectorX& v_end, VectorX& d) {
  RigidContacts& contacts = *equations.parts().rigid_contacts;
  ConeProblem& problem = contacts.problem();
  const auto& points = contacts.points();
  const int n = static_cast<int>(points.size()), groups = static_cast<int>(problem.groups.size());
  bool any = false;
  for (int g = 0; g < groups; ++g) any = any || contacts.deforms(g);
  if (!any) return;  // rigid bodies move as the law supposes
  // 1. Islands of bodies that are near each other.
  islands_.form(problem, [](int) { return true; });
  const auto island_of = [&](int i) { return islands_.of(problem, i); };
  tied_.assign(groups, 0);
  for (int g = 0; g < groups; ++g)
    if (contacts.deforms(g)) tied_[islands_.of_group(g)] = 1;
  // 2. The work of their impulses, of what moved them beside the mean velocity, and a scale for both.
  const Layout& layout = equations.layout();
  q_.resize(start.q.size()), rv_.resize(start.v.size()), forces_.resize(start.v.size());
  no_multipliers_.setZero(layout.row_count()), at_rest_.setZero(start.v.size());
  const auto forces_at = [&](const VectorX& displacement, VectorX& to) {
    q_ = start.q;
    layout.retract(start.q, displacement, q_);
    equations.evaluate(start.time + h, q_, at_rest_, Level::velocity);
    equations.residual(at_rest_, no_multipliers_, to);
  };
  start_velocity_.resize(problem.rows), free_velocity_.resize(problem.rows), now_.resize(problem.rows);
  contacts.velocity(v_free_, free_velocity_);
  contacts.velocity(v_end, now_);
  mean_velocity(equations, start, h, others, rv_);
  contacts.velocity(rv_, start_velocity_);
  start_velocity_ = 2 * start_velocity_ - free_velocity_;
  work_.setZero(groups), scale_.setZero(groups);
  elastic_.assign(groups, 0);
  impulse_.setZero(problem.rows);  // of y
  bool moved = false;
  for (int i = 0; i < n; ++i) {
    const int island = island_of(i);
    if (!tied_[island]) continue;
    const int row = points[i].first, rows = points[i].rows;
    const auto r = total_.segment(row, rows);
    work_[island] += r.dot(start_velocity_.segment(row, rows) + now_.segment(row, rows)) / 2;
    scale_[island] +=
        r.norm() * (start_velocity_.segment(row, rows).norm() + free_velocity_.segment(row, rows).norm()) / 2;
    impulse_.segment(row, rows) = placed_.segment(row, rows) + late_.segment(row, rows) - h / 2 * r;
    moved = moved || impulse_.segment(row, rows).norm() > 1e-9 * h * r.norm();
    const bool bounces = start_velocity_[row] < -points[i].law.rest_speed;
    if (r[0] > 0 && bounces)
      elastic_[island] |= points[i].law.restitution == 1 && r.tail(rows - 1).norm() <= 1e-9 * r[0] ? 1 : 2;
  }
  if (moved) {
    dv_.setZero();
    contacts.add_response(impulse_, nullptr, dv_);
    forces_at(d, forces_);
    d -= dv_;
    forces_at(d, rv_);
    d += dv_;
    forces_ += rv_;
    for (int g = 0; g < groups; ++g)
      if (const int island = islands_.of_group(g); tied_[island]) work_[island] += contacts.dot(g, forces_, dv_) / 2;
  }
  // 3. Islands to be done anew.
  any = false;
  for (int g = 0; g < groups; ++g) {
    if (!tied_[g] || islands_.of_group(g) != g) continue;
    const double may = kMayGain * scale_[g];
    tied_[g] = work_[g] > may || (elastic_[g] == 1 && work_[g] < -may);
    any = any || tied_[g];
  }
  if (any) resist(contacts, h, v_end, d);
}

/// The velocity with which a force over the step does the work that the motion without contact meets. With the midpoint
/// rule's residual ρ = M (v - v_start)/h + g and δ = d - h/2 (v + v_start), which that rule has zero:
///   z = S⁻¹ (M v + h/2 g(q ⊕ d)) = d/h + S⁻¹ (h/2 ρ - M δ/h),   S = M + h²/4 K.
/// Other impulses, D p, are no part of g: what they have given to ρ is h/2 S⁻¹ D p/h, half of what they have moved.
void ContactImpulses::mean_velocity(EquationsOfMotion& equations, const State& start, double h, const Others* others,
                                    VectorX& z) {
  dv_ = (start.v + v_free_) / 2;
  z = dv_;
  if ((d_free_ - h * dv_).norm() <= 1e-12 * d_free_.norm()) return;
  const Layout& layout = equations.layout();
  q_ = start.q;
  forces_ = d_free_ / 2;
  layout.retract(start.q, forces_, q_);
  equations.evaluate(start.time + h / 2, q_, dv_, Level::velocity);
  forces_ = (v_free_ - start.v) / h;
  equations.residual(forces_, no_multipliers_, z);
  z *= h / 2;
  dv_ = d_free_ / h - dv_;
  equations.residual(dv_, no_multipliers_, forces_);
  z -= forces_;
  equations.residual(at_rest_, no_multipliers_, forces_);
  z += forces_;
  equations.solve(z, no_multipliers_);
  no_multipliers_.setZero();
  z += d_free_ / h;
  if (others) z -= others->moved / 2;
}

/// Impulses over the whole step, d' = d + h/2 Y r, so that the energy changes by Σ r·(w + u')/2 alone. Normal: u' >=
/// aim ⊥ r >= 0 with aims up to -w, for which r (w + u')/2 <= 0 whatever the number of contacts, that leave no overlap,
/// gap + h/2 (w + aim) >= 0:
///   closing, w < 0:   max(-e w, -w - 2 gap/h)        parting, w >= 0:   -w - (1 - e) 2 gap/h
/// (Kane, Repetto, Ortiz & Marsden 1999 and Acary 2016 have those of e = 0 and e = 1). Across: Coulomb's law for u', or
/// for w + u' where that would do work.
void ContactImpulses::resist(RigidContacts& contacts, double h, VectorX& v_end, VectorX& d) {
  ConeProblem& problem = contacts.problem();
  const auto& points = contacts.points();
  const int n = static_cast<int>(points.size());
  const auto chosen = [&](int i) { return tied_[islands_.of(problem, i)]; };
  some_.contacts.clear(), some_points_.clear();
  some_.rows = 0;
  for (int i = 0; i < n; ++i) {
    if (!chosen(i)) continue;
    ConeProblem::Contact& c = some_.contacts.emplace_back(as_solved_[i]);
    c.row = some_.rows;
    some_.rows += c.rows;
    some_points_.push_back(i);
  }
  some_.groups = problem.groups, some_.values = problem.values, some_.velocities = problem.velocities;
  some_.free.resize(some_.rows);
  now_.setZero(some_.rows);
  moved_.resize(problem.rows);
  contacts.velocity(d_free_, moved_);
  // 1. Aims: what nothing pushes yet is only kept from overlapping, until an impulse is found there.
  const auto set_aim = [&](std::size_t k, bool pushed) {
    const int i = some_points_[k], row = points[i].first;
    const double w = start_velocity_[row] - growth_[row], gap = std::max(gaps_[i], 0.0);
    const double e = std::abs(w) > points[i].law.rest_speed ? points[i].law.restitution : 0;
    double aim = free_velocity_[row] + growth_[row] - 2 * (gap + moved_[row]) / h;  // closes the gap
    if (pushed && w < 0) aim = std::max(-e * w, aim);
    if (pushed && w >= 0) aim = -w - (1 - e) * 2 * gap / h;
    aim = std::min(aim, -w);
    some_.free[some_.contacts[k].row] = free_velocity_[row] + growth_[row] - aim;
  };
  pushed_.assign(some_points_.size(), 0), mean_.assign(some_points_.size(), 0);
  for (std::size_t k = 0; k < some_points_.size(); ++k) {
    const int i = some_points_[k], row = points[i].first, rows = points[i].rows;
    some_.free.segment(some_.contacts[k].row, rows) = free_velocity_.segment(row, rows) + growth_.segment(row, rows);
    pushed_[k] = gaps_[i] + moved_[row] <= 0;
    set_aim(k, pushed_[k]);
  }
  // 2. Impulses, and again where a law follows from them.
  for (int round = 0; round < kRounds; ++round) {
    solve(some_, now_);
    some_.velocity(now_, u_);
    bool again = false;
    for (std::size_t k = 0; k < some_points_.size(); ++k) {
      const ConeProblem::Contact& c = some_.contacts[k];
      const int row = points[some_points_[k]].first, across = c.rows - 1;
      if (!(now_[c.row] > 0)) continue;
      if (!pushed_[k]) {
        set_aim(k, true);
        pushed_[k] = 1, again = true;
      }
      const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 5> before =
          start_velocity_.segment(row + 1, across) - growth_.segment(row + 1, across);
      if (mean_[k] || !(now_.segment(c.row + 1, across).dot(before + u_.segment(c.row + 1, across)) > 0)) continue;
      some_.free.segment(c.row + 1, across) += before;
      mean_[k] = 1, again = true;
    }
    if (!again) break;
  }
  // 3. In place of what they had.
  for (std::size_t k = 0; k < some_points_.size(); ++k) {
    const ConeProblem::Contact& c = some_.contacts[k];
    const int i = some_points_[k], row = points[i].first;
    auto r = now_.segment(c.row, c.rows);
    total_.segment(row, c.rows) = r_.segment(row, c.rows) = r;
    placed_.segment(row, c.rows) = h / 2 * r;
    late_.segment(row, c.rows).setZero();
    Eigen::Vector2d slip = u_.segment<2>(c.row + 1);
    if (mean_[k]) slip -= start_velocity_.segment<2>(row + 1) - growth_.segment<2>(row + 1);
    friction_.leave(i, slip.norm());
  }
  v_end = v_free_;
  contacts.add_response(total_, nullptr, v_end);
  d = d_free_;
  impulse_ = placed_ + late_;
  contacts.add_response(impulse_, nullptr, d);
}

}  // namespace lithe
