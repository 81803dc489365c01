#include "engine/gradient/unreached_directions.h"

#include <algorithm>

#include "engine/base/error.h"
#include "engine/contact/contact_forces.h"
#include "engine/gradient/contact_numbers.h"
#include "engine/gradient/differences.h"

namespace lithe {
namespace {

constexpr double kNothing = 1e-7;  // of a change, along the rows
constexpr double kTouch = 1e-8;    // m
constexpr double kRest = 1e-6;     // m/s
constexpr double kNearby = 1e-2;   // m: points are looked for again within this

/// Points of rigid surfaces within reach at q.
ContactRows find_points(Evaluator& equations, const State& state, const VectorX& q) {
  equations.evaluate(state.time, q, state.v, Level::velocity);
  ContactForces& contacts = *equations.contacts();
  ContactRows rows;
  std::vector<ContactPoint> points;
  for (const ContactRecord& record : equations.system().contacts()) {
    if (record.element->law() != ContactElement::Law::rigid) continue;
    points.clear();
    contacts.find(record.number, std::vector<double>(record.markers.size(), kNearby), points);
    for (const ContactPoint& point : points)
      if (record.bodies[static_cast<std::size_t>(point.A.collider)] !=
          record.bodies[static_cast<std::size_t>(point.B.collider)])
        rows.add(contacts.places()[static_cast<std::size_t>(record.number)], point, 3);
  }
  return rows;
}

/// B's velocity relative to A's: along the normal, then in world axes.
using PointSpeed = Eigen::Vector4d;
PointSpeed speed(const ContactRows& rows, const ContactRows::Row& row, const VectorX& v) {
  Vector3 u;
  rows.velocity(row, v.data(), u.data());
  PointSpeed speed;
  speed << u[0], row.frame * u;
  return speed;
}

auto key(const ContactRows::Row& row) { return contact_key(row.element, row.point); }

}  // namespace

void UnreachedDirections::add(VectorX row) {
  const double size = largest_entry(row);
  for (int i = 0; i < 2; ++i) row -= rows_.transpose() * (rows_ * row);  // twice: orthogonal to round-off
  if (!(row.norm() > kNothing * std::max(1.0, size))) return;
  rows_.conservativeResize(rows_.rows() + 1, Eigen::NoChange);
  rows_.bottomRows(1) = row.normalized().transpose();
}

VectorX UnreachedDirections::leave_out(VectorX change) const {
  const double size = change.norm();
  change -= rows_.transpose() * (rows_ * change);
  if (change.norm() <= kNothing * size) change.setZero();
  return change;
}

bool UnreachedDirections::lead(ConstVectorRef change, double noise) const {
  return !empty() && largest_entry(rows_ * change) > kNothing * largest_entry(change) + noise;
}

TouchingPoints touching_points(Evaluator& equations, const State& state) {
  const Eigen::Index n = state.v.size();
  const ContactRows near = find_points(equations, state, state.q);
  // 1. Those at rest to each other along the normal, and those that are remembered.
  std::vector<const ContactRows::Row*> points;
  std::vector<Eigen::Index> numbers;  // of each: its first in the memory; -1: none
  std::vector<char> closed;
  for (const ContactRows::Row& row : near.points()) {
    const bool rests = std::abs(row.point.gap) <= kTouch && std::abs(speed(near, row, state.v)[0]) <= kRest;
    const Eigen::Index number = velocity_number(state.contacts, key(row));
    if (!rests && number < 0) continue;
    points.push_back(&row), numbers.push_back(number), closed.push_back(rests);
  }
  const auto count = static_cast<Eigen::Index>(points.size());
  // 2. How their velocities change.
  MatrixX rates(4 * count, 2 * n);
  double scale = 0;
  VectorX q(state.q.size());
  for (Eigen::Index k = 0; k < n && count > 0; ++k) {
    const VectorX unit = VectorX::Unit(n, k);
    rates.col(k) = difference(kDirectionStep, false, scale, [&](double t) {
      equations.layout().retract(state.q, t * unit, q);
      const ContactRows moved = find_points(equations, state, q);
      VectorX speeds(4 * count);
      for (Eigen::Index i = 0; i < count; ++i) {
        const auto again = std::find_if(moved.points().begin(), moved.points().end(), [&](const auto& other) {
          return key(other) == key(*points[static_cast<std::size_t>(i)]);
        });
        if (again == moved.points().end())
          throw SimulationError("a point in touch at t = " + std::to_string(state.time) + " s is another one nearby",
                                "the derivative of a run, backwards", "take GradientOptions::Mode::tangent");
        speeds.segment<4>(4 * i) = speed(moved, *again, state.v);
      }
      return speeds;
    });
    for (Eigen::Index i = 0; i < count; ++i)
      rates.block<4, 1>(4 * i, n + k) = speed(near, *points[static_cast<std::size_t>(i)], unit);
  }
  // 3. What touches may slide on, what sticks may not.
  TouchingPoints found{MatrixX(5 * count, 2 * n), MatrixX::Zero(contact_numbers(state.contacts).size(), 2 * n)};
  Eigen::Index rows = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (numbers[at] >= 0) found.carried.middleRows<3>(numbers[at]) = rates.middleRows<3>(4 * i + 1);
    if (!closed[at]) continue;
    found.blocked.row(rows).setZero();
    found.blocked.row(rows++).head(n) = rates.row(4 * i).tail(n);  // the gap
    const Eigen::Index more = speed(near, *points[at], state.v).norm() <= kRest ? 4 : 1;
    found.blocked.middleRows(rows, more) = rates.middleRows(4 * i, more);
    rows += more;
  }
  found.blocked.conservativeResize(rows, Eigen::NoChange);
  return found;
}

}  // namespace lithe
