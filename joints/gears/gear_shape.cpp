#include "joints/gears/gear_shape.h"

#include <cmath>
#include <numbers>

namespace lithe {

DrawnShape gear_shape(const GearGeometry& pair, const InvoluteGear& gear, double angle) {
  const int teeth = static_cast<int>(std::abs(gear.teeth));
  const bool ring = gear.teeth < 0;
  const GearDesign& d = pair.design();
  const double rim = ring ? std::abs(gear.root_radius) + 2 * d.module : 0.4 * gear.root_radius;
  const double twist = (ring ? 1 : &gear == &pair.A ? 1 : -1) * std::tan(d.helix_angle) / std::abs(gear.pitch_radius);
  // Six points a tooth, each on both faces and again on the rim.
  std::vector<Vector3> points;
  const double radii[] = {gear.root_radius, gear.pitch_radius, gear.tip_radius};
  for (int tooth = 0; tooth < teeth; ++tooth)
    for (int i = 0; i < 6; ++i) {
      const double r = radii[i < 3 ? i : 5 - i];
      const double half = pair.tooth_thickness(gear, ring ? r : std::max(r, gear.base_radius)) /
                          std::abs(2 * (ring ? r : std::max(r, gear.base_radius)));
      const double at = angle + 2 * std::numbers::pi * tooth / teeth + (i < 3 ? -half : half);
      for (double z : {-0.5 * d.face_width, 0.5 * d.face_width})
        for (double radius : {std::abs(r), rim})
          points.emplace_back(radius * std::cos(at + z * twist), radius * std::sin(at + z * twist), z);
    }
  std::vector<std::array<int, 3>> triangles;
  const int n = static_cast<int>(points.size());
  const auto quad = [&](int a, int b, int c, int e) {  // a, b on one section, c, e behind them on the next
    if (ring) std::swap(a, b), std::swap(c, e);
    triangles.push_back({a, c, e}), triangles.push_back({a, e, b});
  };
  for (int i = 0; i < n; i += 4) {
    const int next = (i + 4) % n;
    quad(i, i + 2, next, next + 2);          // flanks
    quad(i + 3, i + 1, next + 3, next + 1);  // rim
    quad(i + 1, i, next + 1, next);          // faces
    quad(i + 2, i + 3, next + 2, next + 3);
  }
  return visual::mesh(points, triangles);
}

}  // namespace lithe
