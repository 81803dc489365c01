#include "joints/gears/gear_shape.h"

#include <cmath>
#include <numbers>

namespace lithe {

namespace {

constexpr double kCircle = 2 * std::numbers::pi;

/// Half of a tooth's angle at a radius; below the base circle that of the base circle.
double half_angle(const GearGeometry& pair, const InvoluteGear& gear, double radius) {
  const double r = gear.teeth < 0 ? radius : std::max(radius, gear.base_radius);
  return pair.tooth_thickness(gear, r) / std::abs(2 * r);
}

/// A closed surface of teeth and a rim: six points a tooth, each on both faces and again on the rim. `at(i, face)`: of
/// the radii root, pitch, tip the i-th, on the flank (before the turn about z) and on the rim.
template <class At>
DrawnShape toothed_mesh(int teeth, bool hollow, At&& at) {
  std::vector<Vector3> points;
  for (int tooth = 0; tooth < teeth; ++tooth)
    for (int i = 0; i < 6; ++i)
      for (int face = 0; face < 2; ++face)
        for (const auto& [place, angle] : at(i < 3 ? i : 5 - i, i < 3 ? -1 : 1, face)) {
          const double turned = angle + kCircle * tooth / teeth;
          points.emplace_back(place[0] * std::cos(turned), place[0] * std::sin(turned), place[1]);
        }
  std::vector<std::array<int, 3>> triangles;
  const int n = static_cast<int>(points.size());
  const auto quad = [&](int a, int b, int c, int e) {  // a, b on one section, c, e behind them on the next
    if (hollow) std::swap(a, b), std::swap(c, e);
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

/// Radius and z of a point, and its angle about z.
using Placed = std::pair<Eigen::Vector2d, double>;

}  // namespace

GearPhase::GearPhase(const GearGeometry& pair, double phase)
    : A(phase - 0.5 * pair.A.tooth_thickness * pair.A.teeth / (kCircle * pair.A.working_radius)), B(0.5 - A) {}

DrawnShape gear_shape(const GearGeometry& pair, const InvoluteGear& gear, double angle) {
  const bool ring = gear.teeth < 0;
  const GearDesign& d = pair.design();
  const double rim = ring ? std::abs(gear.root_radius) + 2 * d.module : 0.4 * gear.root_radius;
  const double twist = (ring ? 1 : &gear == &pair.A ? 1 : -1) * std::tan(d.helix_angle) / std::abs(gear.pitch_radius);
  const double radii[] = {gear.root_radius, gear.pitch_radius, gear.tip_radius};
  return toothed_mesh(static_cast<int>(std::abs(gear.teeth)), ring, [&](int i, int flank, int face) {
    const double z = (face - 0.5) * d.face_width, at = angle + flank * half_angle(pair, gear, radii[i]) + z * twist;
    return std::array{Placed{{std::abs(radii[i]), z}, at}, Placed{{rim, z}, at}};
  });
}

/// By the height over the pitch cone, along the back cone; all grows with the distance from the apex.
DrawnShape bevel_gear_shape(const GearGeometry& pair, const InvoluteGear& gear, const BevelCone& cone, double angle) {
  const double sine = std::sin(cone.angle), cosine = std::cos(cone.angle), R = cone.distance;
  const double radii[] = {gear.root_radius, gear.pitch_radius, gear.tip_radius}, module = pair.design().module,
               rim = gear.pitch_radius - std::max(1.3 * module, std::min(2.75 * module, 0.6 * R * sine / cosine));
  return toothed_mesh(cone.teeth, false, [&](int i, int flank, int face) {
    const double scale = 1 + (face - 0.5) * pair.design().face_width / R;
    const auto place = [&](double radius) {
      const double height = radius - gear.pitch_radius;
      return Eigen::Vector2d(scale * (R * sine + height * cosine), cone.apex + scale * (R * cosine - height * sine));
    };
    // The tooth is as thick as that of the virtual gear.
    const double thick = half_angle(pair, gear, radii[i]) * radii[i],
                 at = angle + flank * thick / (R * sine + (radii[i] - gear.pitch_radius) * cosine);
    return std::array{Placed{place(radii[i]), at}, Placed{place(rim), at}};
  });
}

}  // namespace lithe
