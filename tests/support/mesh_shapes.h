#pragma once

#include <array>
#include <vector>

#include "joints/contact/shapes.h"

/// Closed meshes to collide with.
namespace lithe::test {

/// A profile (y, z), counter-clockwise seen from +x, drawn along x from -length/2 to length/2. `caps`: the triangles of
/// the profile.
inline Shape prism_mesh(const std::vector<std::array<double, 2>>& profile, const std::vector<std::array<int, 3>>& caps,
                        double length) {
  const int n = static_cast<int>(profile.size());
  std::vector<Vector3> points;
  for (double x : {-length / 2, length / 2})
    for (const auto& [y, z] : profile) points.emplace_back(x, y, z);
  std::vector<std::array<int, 3>> triangles;
  for (const auto& [a, b, c] : caps) triangles.push_back({a, c, b}), triangles.push_back({a + n, b + n, c + n});
  for (int i = 0; i < n; ++i) {
    const int k = (i + 1) % n;
    triangles.push_back({i, k, k + n}), triangles.push_back({i, k + n, i + n});
  }
  return shape::mesh(points, triangles);
}

/// A box of full edge lengths, centred, of twelve triangles.
inline Shape box_mesh(const Vector3& edges) {
  const double y = edges[1] / 2, z = edges[2] / 2;
  return prism_mesh({{-y, -z}, {y, -z}, {y, z}, {-y, z}}, {{0, 1, 2}, {0, 2, 3}}, edges[0]);
}

/// A tetrahedron whose edge along x, `edge` long, is at z = 0 and the one along y at z = -height (or, upside down, at
/// z = height).
inline Shape tetrahedron_mesh(double edge, double height, bool upside_down = false) {
  const double h = edge / 2, z = upside_down ? height : -height;
  std::vector<std::array<int, 3>> triangles{{0, 1, 3}, {1, 0, 2}, {2, 0, 3}, {1, 2, 3}};
  if (upside_down)
    for (auto& t : triangles) std::swap(t[1], t[2]);
  return shape::mesh({{-h, 0, 0}, {h, 0, 0}, {0, -h, z}, {0, h, z}}, triangles);
}

/// Two ridges along x at y = -1 and 1 and z = 0, a valley between them at z = -0.5, on a base at z = -1.
inline Shape ridges_mesh(double length) {
  return prism_mesh({{-2, -1}, {2, -1}, {1, 0}, {0, -0.5}, {-1, 0}}, {{0, 1, 3}, {1, 2, 3}, {0, 3, 4}}, length);
}

}  // namespace lithe::test
