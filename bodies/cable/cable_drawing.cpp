#include "bodies/cable/cable_drawing.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"

namespace lithe::cable_drawing {

double length(const std::vector<Vector3>& points) {
  double sum = 0;
  for (std::size_t i = 1; i < points.size(); ++i) sum += (points[i] - points[i - 1]).norm();
  return sum;
}

Matrix3X along(const std::vector<Vector3>& points, const VectorX& shares) {
  const double whole = length(points);
  Matrix3X nodes(3, shares.size());
  std::size_t piece = 1;
  double before = 0, own = (points[1] - points[0]).norm();
  for (Eigen::Index k = 0; k < shares.size(); ++k) {
    const double s = shares[k] * whole;
    while (s > before + own && piece + 1 < points.size()) {
      before += own;
      ++piece;
      own = (points[piece] - points[piece - 1]).norm();
    }
    const double share = own > 0 ? std::clamp((s - before) / own, 0.0, 1.0) : 0;
    nodes.col(k) = (1 - share) * points[piece - 1] + share * points[piece];
  }
  nodes.rightCols<1>() = points.back();
  return nodes;
}

/// In a circle of diameter 1/x an element L turns by 2 α = 2 asin(L x), and all together span the chord: sin Σα = d x.
Matrix3X hanging(const Vector3& from, const Vector3& to, const Vector3& sag, const VectorX& elements) {
  const double d = (to - from).norm();
  const Vector3 along = d > 0 ? Vector3((to - from) / d) : Vector3(sag.unitOrthogonal());
  Vector3 down = sag - sag.dot(along) * along;
  down = down.norm() > 1e-6 * sag.norm() ? Vector3(down.normalized()) : Vector3(along.unitOrthogonal());

  const auto turn = [&](double x) { return (elements * x).array().min(1.0).asin().sum(); };
  double low = 0, high = 1 / elements.maxCoeff();
  if (turn(high) < M_PI && std::sin(turn(high)) > d * high)
    throw SceneError("has too few elements to be drawn slack", "",
                     "give more .elements, or .points of a curve that is as long as the cable");
  for (int i = 0; i < 200; ++i) {
    const double x = 0.5 * (low + high), phi = turn(x);
    (phi < M_PI && std::sin(phi) > d * x ? low : high) = x;
  }

  Matrix3X nodes(3, elements.size() + 1);
  nodes.col(0) = from;
  double angle = turn(low);
  for (Eigen::Index e = 0; e < elements.size(); ++e) {
    const double alpha = std::asin(std::min(1.0, elements[e] * low));
    const double direction = angle - alpha;
    nodes.col(e + 1) = nodes.col(e) + elements[e] * (std::cos(direction) * along + std::sin(direction) * down);
    angle -= 2 * alpha;
  }
  nodes.rightCols<1>() = to;
  return nodes;
}

}  // namespace lithe::cable_drawing
