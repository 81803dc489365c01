#include "joints/sliding/rail_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/error.h"

namespace lithe {
namespace {

/// a, turned as `from` turns into `to` by the shortest way; unit vectors that are not opposite.
Vector3 carried(const Vector3& from, const Vector3& to, const Vector3& a) {
  const Vector3 sum = from + to;
  return a - (sum.dot(a) / (1 + from.dot(to))) * sum + (2 * from.dot(a)) * to;
}

Vector3 any_normal(const Vector3& t) {
  int least = 0;
  t.cwiseAbs().minCoeff(&least);
  return t.cross(Vector3(Vector3::Unit(least))).normalized();
}

}  // namespace

void RailCurve::draw(const RailMarkers& markers) {
  if (markers.count() < 3)
    throw SceneError("its rail has " + std::to_string(markers.count()) + " markers", "", "give three or more");
  knots_ = {0};
  for (int i = 1; i < markers.count(); ++i) {
    const double distance = (markers[i].p - markers[i - 1].p).norm();
    if (!(distance > 0))
      throw SceneError("markers " + std::to_string(i - 1) + " and " + std::to_string(i) + " of its rail coincide", "",
                       "give them in the order in which the rail passes them, each once");
    knots_.push_back(knots_.back() + distance);
  }
  along_.clear(), normals_.clear();
  Vector3 t_before = Vector3::Zero(), n = Vector3::Zero();
  for (int i = 0; i < count(); ++i) {
    const Place here = place(knots_[static_cast<std::size_t>(i)]);
    const Vector3 t = positions(markers, here, here.dw).normalized();
    n = i == 0 ? any_normal(t) : carried(t_before, t, n);
    t_before = t;
    const Matrix3& R = markers[i].R;
    along_.push_back(R.transpose() * t), normals_.push_back(R.transpose() * n);
  }
}

/// Slope of the parabola through a knot and its neighbours, times the factors (of value and derivatives).
void RailCurve::add_slope(int knot, const std::array<double, 3>& factors, Place& at) const {
  const int middle = std::clamp(knot, 1, count() - 2);
  const double *u = knots_.data() + middle, x = u[knot - middle];
  const double before = u[0] - u[-1], after = u[1] - u[0], whole = u[1] - u[-1];
  const double slope[3] = {(2 * x - u[0] - u[1]) / (before * whole), (2 * x - u[-1] - u[1]) / (-before * after),
                           (2 * x - u[-1] - u[0]) / (after * whole)};
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(middle - 1 + a - at.first);
    at.w[i] += factors[0] * slope[a], at.dw[i] += factors[1] * slope[a], at.ddw[i] += factors[2] * slope[a];
  }
}

RailCurve::Place RailCurve::place(double u) const {
  const auto after = std::upper_bound(knots_.begin(), knots_.end(), u);
  const int span = std::clamp(static_cast<int>(after - knots_.begin()) - 1, 0, count() - 2);
  Place at{u, std::clamp(span - 1, 0, std::max(0, count() - 4)), std::min(4, count()), {}, {}, {}};
  const double from = knots_[static_cast<std::size_t>(span)], h = knots_[static_cast<std::size_t>(span) + 1] - from;
  const double x = (u - from) / h;
  const auto end = [&](int knot) { return static_cast<std::size_t>(knot - at.first); };
  if (x < 0 || x > 1) {  // straight on
    const int knot = x < 0 ? span : span + 1;
    at.w[end(knot)] = 1;
    add_slope(knot, {u - knots_[static_cast<std::size_t>(knot)], 1, 0}, at);
    return at;
  }
  at.w[end(span)] = (1 + 2 * x) * (1 - x) * (1 - x), at.w[end(span + 1)] = x * x * (3 - 2 * x);
  at.dw[end(span)] = -6 * x * (1 - x) / h, at.dw[end(span + 1)] = 6 * x * (1 - x) / h;
  at.ddw[end(span)] = (12 * x - 6) / (h * h), at.ddw[end(span + 1)] = (6 - 12 * x) / (h * h);
  add_slope(span, {h * x * (1 - x) * (1 - x), (1 - x) * (1 - 3 * x), (6 * x - 4) / h}, at);
  add_slope(span + 1, {h * x * x * (x - 1), x * (3 * x - 2), (6 * x - 2) / h}, at);
  return at;
}

Vector3 RailCurve::positions(const RailMarkers& markers, const Place& at, const std::array<double, 4>& weights) {
  Vector3 sum = Vector3::Zero();
  for (int a = 0; a < at.count; ++a) sum += weights[static_cast<std::size_t>(a)] * markers[at.first + a].p;
  return sum;
}

Vector3 RailCurve::velocities(const RailMarkers& markers, const Place& at, const std::array<double, 4>& weights) {
  Vector3 sum = Vector3::Zero();
  for (int a = 0; a < at.count; ++a) sum += weights[static_cast<std::size_t>(a)] * markers[at.first + a].v;
  return sum;
}

RailCurve::Place RailCurve::nearest(const RailMarkers& markers, const Vector3& point) const {
  double least = std::numeric_limits<double>::infinity();
  int near = 0;
  for (int i = 0; i < count(); ++i) {
    const double distance = (markers[i].p - point).squaredNorm();
    if (distance < least) least = distance, near = i;
  }
  // Newton on half the squared distance; without its curvature term where that would lead to a largest distance.
  Place at = place(knots_[static_cast<std::size_t>(near)]);
  const double stretch = length() / (count() - 1);
  for (int i = 0; i < 50; ++i) {
    const Vector3 d = point - positions(markers, at, at.w), slope = positions(markers, at, at.dw),
                  bend = positions(markers, at, at.ddw);
    const double f = slope.dot(d), steepness = slope.squaredNorm(), curved = steepness - bend.dot(d);
    const double step = f / (curved > 0.1 * steepness ? curved : steepness);
    if (!(std::abs(step) > 1e-15 * length())) break;
    at = place(at.u + std::clamp(step, -0.5 * stretch, 0.5 * stretch));
  }
  return at;
}

std::array<Vector3, 2> RailCurve::across(const RailMarkers& markers, const Place& at) const {
  const auto after = std::upper_bound(knots_.begin(), knots_.end(), at.u);
  const int span = std::clamp(static_cast<int>(after - knots_.begin()) - 1, 0, count() - 2);
  const double *u = knots_.data() + span, share = std::clamp((at.u - u[0]) / (u[1] - u[0]), 0.0, 1.0);
  const auto between = [&](const std::vector<Vector3>& drawn) -> Vector3 {
    const auto* local = drawn.data() + span;
    return ((1 - share) * (markers[span].R * local[0]) + share * (markers[span + 1].R * local[1])).normalized();
  };
  const Vector3 t = positions(markers, at, at.dw).normalized();
  Vector3 n = carried(between(along_), t, between(normals_));
  n = (n - n.dot(t) * t).normalized();
  return {n, t.cross(n)};
}

}  // namespace lithe
