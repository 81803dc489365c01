#include "joints/tyre/tyre_road.h"

#include <algorithm>
#include <cmath>

#include "engine/base/checks.h"

namespace lithe {

namespace {

/// Hermite's cubic through values at -1, 0, 1, 2 (spacing 1), and its slope, at t of 0 to 1.
struct Cubic {
  double value, slope;
};
Cubic cubic(const double* y, double t) {
  const double a = y[1], b = 0.5 * (y[2] - y[0]), end = 0.5 * (y[3] - y[1]);
  const double c = 3 * (y[2] - a) - 2 * b - end, d = b + end - 2 * (y[2] - a);
  return {a + t * (b + t * (c + t * d)), b + t * (2 * c + 3 * t * d)};
}

/// The cell of a place counted in spacings, and the place within it.
std::pair<Eigen::Index, double> cell(double place, Eigen::Index count) {
  const double inside = std::clamp(place, 0.0, static_cast<double>(count - 1));
  const auto i = std::min(static_cast<Eigen::Index>(inside), count - 2);
  return {i, inside - static_cast<double>(i)};
}

}  // namespace

TyreTerrain::TyreTerrain(Parameters parameters) : p_(std::move(parameters)) {
  if (p_.heights.rows() < 2 || p_.heights.cols() < 2)
    throw SceneError(
        "the terrain has " + std::to_string(p_.heights.rows()) + " x " + std::to_string(p_.heights.cols()) + " heights",
        "", "give two rows and two columns at least");
  require::finite(p_.x, "x of the terrain"), require::finite(p_.y, "y of the terrain");
  require::positive(p_.spacing_x, "spacing_x"), require::positive(p_.spacing_y, "spacing_y");
  require::finite(Eigen::Map<const VectorX>(p_.heights.data(), p_.heights.size()), "heights");
}

TyreTerrain::Height TyreTerrain::height(double x, double y) const {
  const auto rows = p_.heights.rows(), columns = p_.heights.cols();
  const double at_x = (x - p_.x) / p_.spacing_x, at_y = (y - p_.y) / p_.spacing_y;
  const auto [i, t] = cell(at_x, rows);
  const auto [j, s] = cell(at_y, columns);
  double along[4], slope[4];
  for (int a = 0; a < 4; ++a) {
    double across[4];
    const auto row = std::clamp<Eigen::Index>(i + a - 1, 0, rows - 1);
    for (int b = 0; b < 4; ++b) across[b] = p_.heights(row, std::clamp<Eigen::Index>(j + b - 1, 0, columns - 1));
    const Cubic c = cubic(across, s);
    along[a] = c.value, slope[a] = c.slope;
  }
  const Cubic value = cubic(along, t);
  const bool outside_x = at_x < 0 || at_x > static_cast<double>(rows - 1);
  const bool outside_y = at_y < 0 || at_y > static_cast<double>(columns - 1);
  return {value.value, outside_x ? 0 : value.slope / p_.spacing_x,
          outside_y ? 0 : cubic(slope, t).value / p_.spacing_y};
}

TyreRoad::Plane TyreTerrain::plane_below(const Vector3& centre, const Vector3& axle, const Vector3&) const {
  Vector3 at = centre;
  Plane plane{};
  // Onto the plane that touches at the last place, until it stays: it contracts by the radius times the curvature.
  for (int k = 0; k < 200; ++k) {
    const Height h = height(at.x(), at.y());
    plane = {{at.x(), at.y(), h.value}, Vector3(-h.by_x, -h.by_y, 1).normalized()};
    const Vector3 down = plane.normal - plane.normal.dot(axle) * axle;
    const Vector3 next = centre - plane.normal.dot(centre - plane.point) / down.squaredNorm() * down;
    const double moved = (next - at).head<2>().norm();
    at = next;
    if (moved < 1e-13 * (1 + at.norm())) break;
  }
  return plane;
}

void TyreTerrain::require_passable(double radius) const {
  const auto& h = p_.heights;
  const auto check = [&](double left, double middle, double right, double spacing, Eigen::Index i, Eigen::Index j) {
    const double curvature = std::abs(left - 2 * middle + right) / (spacing * spacing);
    if (curvature * radius > 0.9)
      throw SceneError("the terrain has a radius of " + std::to_string(1 / curvature) + " m at row " +
                           std::to_string(i) + ", column " + std::to_string(j) + ", and the tyre one of " +
                           std::to_string(radius) + " m",
                       "", "smooth the heights, or give edges as a TyreProfile");
  };
  for (Eigen::Index i = 0; i < h.rows(); ++i)
    for (Eigen::Index j = 0; j < h.cols(); ++j) {
      if (i > 0 && i + 1 < h.rows()) check(h(i - 1, j), h(i, j), h(i + 1, j), p_.spacing_x, i, j);
      if (j > 0 && j + 1 < h.cols()) check(h(i, j - 1), h(i, j), h(i, j + 1), p_.spacing_y, i, j);
    }
}

TyreProfile::TyreProfile(Parameters parameters) : p_(std::move(parameters)) {
  if (p_.x.size() != p_.heights.size() || p_.x.empty())
    throw SceneError("the profile has " + std::to_string(p_.x.size()) + " places and " +
                         std::to_string(p_.heights.size()) + " heights",
                     "", "give one height for each x, one at least");
  for (std::size_t i = 0; i < p_.x.size(); ++i) {
    require::finite(p_.x[i], "x of the profile"), require::finite(p_.heights[i], "heights of the profile");
    if (i > 0 && p_.x[i] < p_.x[i - 1])
      throw SceneError("x of the profile falls at corner " + std::to_string(i), "", "list corners along x");
  }
  for (const auto& [value, name] :
       {std::pair(p_.radius, "radius"), std::pair(p_.exponent - 1, "exponent - 1"), std::pair(p_.length, "length")})
    require::positive(value, name);
  a_ = 1.05 * p_.radius, b_ = 1.1 * p_.radius;
  // Level ends, beyond the reach of any wheel on the profile.
  p_.x.insert(p_.x.begin(), -1e9), p_.x.push_back(1e9);
  p_.heights.insert(p_.heights.begin(), p_.heights.front()), p_.heights.push_back(p_.heights.back());
}

double TyreProfile::contour(double xi) const {
  const double s = std::min(1.0, std::abs(xi) / a_);
  return b_ * (std::pow(1 - std::pow(s, p_.exponent), 1 / p_.exponent) - 1);
}

double TyreProfile::cam_height(double x) const {
  double highest = -std::numeric_limits<double>::infinity();
  const auto first = std::upper_bound(p_.x.begin(), p_.x.end(), x - a_);
  const double c = p_.exponent;
  for (auto i = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, first - p_.x.begin() - 1));
       i + 1 < p_.x.size() && p_.x[i] <= x + a_; ++i) {
    const double from = std::max(p_.x[i] - x, -a_), to = std::min(p_.x[i + 1] - x, a_);
    if (from > to) continue;
    const double run = p_.x[i + 1] - p_.x[i];
    if (run == 0) {
      highest = std::max(highest, std::max(p_.heights[i], p_.heights[i + 1]) + contour(from));
      continue;
    }
    // Where the cam's slope is the road's: (s^c / (1 - s^c))^((c - 1)/c) = |slope| a / b, s = |ξ| / a.
    const double slope = (p_.heights[i + 1] - p_.heights[i]) / run;
    const double t = std::pow(std::abs(slope) * a_ / b_, c / (c - 1));
    const double touching = std::copysign(a_ * std::pow(t / (1 + t), 1 / c), slope);
    const double xi = std::clamp(touching, from, to);
    highest = std::max(highest, p_.heights[i] + slope * (x + xi - p_.x[i]) + contour(xi));
  }
  return highest;
}

TyreRoad::Plane TyreProfile::plane_below(const Vector3& centre, const Vector3&, const Vector3& forward) const {
  const double reach = 0.5 * p_.length * forward.x();
  const double front = cam_height(centre.x() + reach), rear = cam_height(centre.x() - reach);
  const Vector3 slope = (front - rear) / p_.length * forward;
  return {{centre.x(), centre.y(), 0.5 * (front + rear)}, Vector3(-slope.x(), -slope.y(), 1).normalized()};
}

}  // namespace lithe
