#include "joints/gears/chain_span.h"

#include <numbers>

#include "engine/base/checks.h"
#include "engine/model/initial_pose.h"
#include "engine/model/joint_coordinate.h"
#include "joints/gears/limited_damping.h"

namespace lithe {
namespace {

constexpr double kFullTurn = 2 * std::numbers::pi;

/// Along the common tangent of both polygons: the joint nearest to its normal is the one on it. B's normal is A's, or
/// against it where the span is crossed.
ChainSpan of_polygons(const Sprocket& a, const Sprocket& b, const ChainDrive& chain, double bearing_A, double bearing_B,
                      std::span<const MarkerView> markers) {
  const auto &A = markers[0], &B = markers[1];
  const double tooth_A = kFullTurn / a.teeth, tooth_B = kFullTurn / b.teeth,
               against = a.side == b.side ? 0 : 0.5 * kFullTurn, radius_B = a.side * b.side * b.radius;
  double lean = std::acos((a.radius - radius_B) / (B.p - A.p).norm());  // of the circles, to begin with
  double joint_A = 0, joint_B = 0;
  for (int round = 0;; ++round) {
    const double normal_A = bearing_A + a.side * lean,
                 normal_B = bearing_B + a.side * (lean - 0.5 * kFullTurn) + against;
    const double next_A = std::round(normal_A / tooth_A), next_B = std::round(normal_B / tooth_B);
    const bool same = round > 0 && next_A == joint_A && next_B == joint_B;
    joint_A = next_A, joint_B = next_B;
    const Vector3 from_A = a.radius * in_plane_direction(A, joint_A * tooth_A),
                  from_B = b.radius * in_plane_direction(B, joint_B * tooth_B);
    const Vector3 line = B.p + from_B - A.p - from_A;
    if (same || round == 4) {  // where two joints lie on the line, either is right
      const double straight = line.norm();
      const Vector3 n = line / straight;
      return {normal_A,
              normal_B,
              straight,
              straight + chain.pitch * (b.side * joint_B - a.side * joint_A),
              {-n, -from_A.cross(n)},
              {n, from_B.cross(n)}};
    }
    const double along = bearing_A - std::atan2(line.dot(A.y()), line.dot(A.x()));
    lean = 0.25 * kFullTurn - a.side * std::remainder(along, kFullTurn);
  }
}

}  // namespace

Vector3 in_plane_direction(const MarkerView& m, double angle) {
  return std::cos(angle) * m.x() + std::sin(angle) * m.y();
}

void ChainDrive::check() const {
  require::positive(pitch, "pitch");
  require::positive(axial_stiffness, "axial_stiffness");
  require::not_negative(damping, "damping");
  require::not_negative(pretension, "pretension");
  require::not_negative(slack, "slack");
  if (pretension > 0 && slack > 0) throw SceneError("has pretension and slack", "", "give one of the two");
}

Sprocket::Sprocket(int teeth, const ChainDrive& chain, int side) : teeth(teeth), side(side) {
  if (teeth < 5) throw SceneError("a sprocket of " + std::to_string(teeth) + " teeth", "", "give five teeth or more");
  require::positive(chain.pitch, "pitch");
  radius = chain.polygon ? 0.5 * chain.pitch / std::sin(0.5 * kFullTurn / teeth) : chain.pitch * teeth / kFullTurn;
}

ChainSpan ChainSpan::between(const Sprocket& a, const Sprocket& b, const ChainDrive& chain,
                             std::span<const MarkerView> markers, const AngleMemory& memory) {
  const auto &A = markers[0], &B = markers[1];
  const auto counted = [&](int place, const MarkerView& from, const MarkerView& to) {
    MeasuredCoordinate x = measure(JointCoordinate::Kind::bearing, 2, from, to);
    x.value = memory.quarter_turns() ? memory.wound(place, x.value) : initial::angle(x.value);
    return x;
  };
  const MeasuredCoordinate at_A = counted(0, A, B), at_B = counted(1, B, A);
  if (chain.polygon) return of_polygons(a, b, chain, at_A.value, at_B.value, markers);
  // A belt: its change is that of the line of centres and of the arcs, for the tangent turns without work.
  const MeasuredCoordinate apart = measure(JointCoordinate::Kind::distance, 2, A, B);
  const double r_A = a.side * a.radius, r_B = b.side * b.radius, lean = std::acos(a.side * (r_A - r_B) / apart.value),
               sine = std::sin(lean), against = a.side == b.side ? 0 : 0.5 * kFullTurn;
  const double normal_A = at_A.value + a.side * lean,
               normal_B = at_B.value + a.side * (lean - 0.5 * kFullTurn) + against, straight = apart.value * sine;
  return {normal_A,
          normal_B,
          straight,
          straight + r_B * normal_B - r_A * normal_A,
          sine * apart.on_A + r_B * at_B.on_B - r_A * at_A.on_A,
          sine * apart.on_B + r_B * at_B.on_A - r_A * at_A.on_B};
}

void ChainSpan::pull(const ChainMaterial& material, double damping, std::span<const MarkerView> markers,
                     ForceRows& rows) const {
  const auto power = [](const Wrench& w, const MarkerView& m) { return w.force.dot(m.v) + w.torque.dot(m.w); };
  const double stretch = std::max(0.0, length - material.length), elastic = material.stiffness * stretch;
  const LimitedDamping damped(damping, power(on_A, markers[0]) + power(on_B, markers[1]), elastic);
  rows.add({on_A, on_B}, elastic + damped.force, stretch > 0 ? material.stiffness * damped.by_elastic : 0,
           damped.damping, 0.5 * elastic * stretch);
}

void ChainSpan::check(const Sprocket& a, const Sprocket& b, std::span<const MarkerView> markers) {
  initial::same_direction(markers[0].z(), markers[1].z(), "z");
  const double apart = (markers[1].p - markers[0].p).norm();
  if (!(apart > a.radius + b.radius))
    throw SceneError("the sprockets overlap: " + std::to_string(apart) + " m apart, radii of " +
                         std::to_string(a.radius) + " m and " + std::to_string(b.radius) + " m",
                     "", "move the markers apart, or give fewer teeth or a smaller pitch");
}

ChainMaterial::ChainMaterial(const ChainSpan& drawn, const ChainDrive& chain)
    : stiffness((chain.axial_stiffness + chain.pretension) / drawn.straight),
      length(drawn.length - chain.pretension / stiffness + chain.slack) {}

}  // namespace lithe
