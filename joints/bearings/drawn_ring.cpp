#include <cmath>
#include <numbers>

#include "joints/bearings/drawn_ring_internal.h"

namespace lithe {

DrawnShape drawn_ring(double inner_radius, double outer_radius, double width) {
  constexpr int kSides = 32;
  std::vector<Vector3> points;
  std::vector<std::array<int, 3>> triangles;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides, c = std::cos(angle), s = std::sin(angle);
    // The corners of its section, counter-clockwise in the plane (radius, z).
    for (const auto& [radius, z] : {std::pair(inner_radius, -0.5), std::pair(outer_radius, -0.5),
                                    std::pair(outer_radius, 0.5), std::pair(inner_radius, 0.5)})
      points.emplace_back(radius * c, radius * s, z * width);
    for (int k = 0; k < 4; ++k) {
      const int a = 4 * i + k, b = 4 * i + (k + 1) % 4, shift = 4 * ((i + 1) % kSides - i);
      triangles.push_back({a, a + shift, b}), triangles.push_back({b, a + shift, b + shift});
    }
  }
  return visual::mesh(points, triangles);
}

}  // namespace lithe
