#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "joints/contact/triangles_internal.h"

/// Grounds of triangles that tests of contact lay bodies on.
namespace lithe::test {

/// A square of 2n x 2n triangles about the origin, edges of the cells 0.1 m, at heights z(x, y).
template <class Height>
Shape terrain(int n, const Height& z) {
  MatrixX heights(n + 1, n + 1);
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) heights(i, j) = z(0.1 * (i - 0.5 * n), 0.1 * (j - 0.5 * n));
  return shape::height_field(heights, 0.1, 0.1);
}

/// A box of triangles, outwards, each face of n x n cells.
inline Shape table(const Vector3& half, int n = 1) {
  std::vector<Vector3> points;
  std::vector<std::array<int, 3>> triangles;
  for (int axis = 0; axis < 3; ++axis)
    for (double side : {-1.0, 1.0}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3, first = static_cast<int>(points.size());
      for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j) {
          Vector3 p;
          p[axis] = side * half[axis];
          p[u] = (2.0 * i / n - 1) * half[u], p[v] = (2.0 * j / n - 1) * half[v];
          points.push_back(p);
        }
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const int a = first + i * (n + 1) + j, b = a + n + 1;
          std::array<int, 3> one{a, b, b + 1}, two{a, b + 1, a + 1};
          if (side < 0) std::swap(one[1], one[2]), std::swap(two[1], two[2]);
          triangles.push_back(one), triangles.push_back(two);
        }
    }
  return shape::mesh(points, triangles);
}

inline const Matrix3 kTilt = rotation_about({1, 2, 0.5}, 0.7);
inline const Vector3 kPlace{0.3, -0.2, 0.5};

inline double distance_to_triangle(const Vector3& x, const Vector3& a, const Vector3& b, const Vector3& c) {
  // Independent of the code: the least of plane (if the foot is inside) and three segments.
  const Vector3 n = (b - a).cross(c - a).normalized();
  const Vector3 foot = x - n.dot(x - a) * n;
  double least = 1e300;
  if ((b - a).cross(foot - a).dot(n) >= 0 && (c - b).cross(foot - b).dot(n) >= 0 && (a - c).cross(foot - c).dot(n) >= 0)
    least = std::abs(n.dot(x - a));
  const Vector3 ends[3][2] = {{a, b}, {b, c}, {c, a}};
  for (const auto& e : ends) {
    const Vector3 d = e[1] - e[0];
    const double s = std::clamp((x - e[0]).dot(d) / d.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (x - e[0] - s * d).norm());
  }
  return least;
}

}  // namespace lithe::test
