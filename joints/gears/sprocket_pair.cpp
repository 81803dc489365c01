#include "joints/gears/sprocket_pair.h"

#include <numbers>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/initial_pose.h"
#include "joints/gears/limited_damping.h"

namespace lithe {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr int kArcPoints = 12;

double sprocket_radius(const SprocketPair::Parameters& p, int teeth) {
  if (teeth < 5) throw SceneError("a sprocket of " + std::to_string(teeth) + " teeth", "", "give five teeth or more");
  require::positive(p.pitch, "pitch");
  return p.polygon ? 0.5 * p.pitch / std::sin(0.5 * kTurn / teeth) : p.pitch * teeth / kTurn;
}

/// The direction at `angle` in the xy plane of a marker.
Vector3 in_plane_direction(const MarkerView& m, double angle) {
  return std::cos(angle) * m.x() + std::sin(angle) * m.y();
}

}  // namespace

SprocketPair::SprocketPair(Parameters parameters)
    : parameters_(parameters),
      radius_A_(sprocket_radius(parameters, parameters.teeth_A)),
      radius_B_(sprocket_radius(parameters, parameters.teeth_B)) {
  require::positive(parameters.axial_stiffness, "axial_stiffness");
  require::not_negative(parameters.damping, "damping");
  require::not_negative(parameters.pretension, "pretension");
  require::not_negative(parameters.slack, "slack");
  if (parameters.pretension > 0 && parameters.slack > 0)
    throw SceneError("has pretension and slack", "", "give one of the two");
}

/// Along the common tangent of both polygons: the joint nearest to its normal is the one on it.
SprocketPair::Span SprocketPair::chain_span(int side, double bearing_A, double bearing_B,
                                            std::span<const MarkerView> markers) const {
  const auto &A = markers[0], &B = markers[1];
  const double tooth_A = kTurn / parameters_.teeth_A, tooth_B = kTurn / parameters_.teeth_B;
  double lean = std::acos((radius_A_ - radius_B_) / (B.p - A.p).norm());  // of the circles, to begin with
  double joint_A = 0, joint_B = 0;
  for (int round = 0;; ++round) {
    const double normal_A = bearing_A + side * lean, normal_B = bearing_B + side * (lean - 0.5 * kTurn);
    const double next_A = std::round(normal_A / tooth_A), next_B = std::round(normal_B / tooth_B);
    const bool same = round > 0 && next_A == joint_A && next_B == joint_B;
    joint_A = next_A, joint_B = next_B;
    const Vector3 from_A = radius_A_ * in_plane_direction(A, joint_A * tooth_A),
                  from_B = radius_B_ * in_plane_direction(B, joint_B * tooth_B);
    const Vector3 line = B.p + from_B - A.p - from_A;
    if (same || round == 4) {  // where two joints lie on the line, either is right
      const double straight = line.norm();
      const Vector3 n = line / straight;
      return {normal_A,
              normal_B,
              straight,
              straight + side * parameters_.pitch * (joint_B - joint_A),
              {-n, -from_A.cross(n)},
              {n, from_B.cross(n)}};
    }
    const double along = bearing_A - std::atan2(line.dot(A.y()), line.dot(A.x()));
    lean = 0.25 * kTurn - side * std::remainder(along, kTurn);
  }
}

SprocketPair::Span SprocketPair::span(int side, std::span<const MarkerView> markers, const AngleMemory& memory) const {
  const auto &A = markers[0], &B = markers[1];
  const auto counted = [&](int place, const MarkerView& from, const MarkerView& to) {
    MeasuredCoordinate x = measure(JointCoordinate::Kind::bearing, 2, from, to);
    x.value = memory.quarter_turns() ? memory.wound(place, x.value) : initial::angle(x.value);
    return x;
  };
  const MeasuredCoordinate at_A = counted(0, A, B), at_B = counted(1, B, A);
  if (parameters_.polygon) return chain_span(side, at_A.value, at_B.value, markers);
  // A belt: its change is that of the line of centres and of the arcs, for the tangent turns without work.
  const MeasuredCoordinate apart = measure(JointCoordinate::Kind::distance, 2, A, B);
  const double lean = std::acos((radius_A_ - radius_B_) / apart.value), sine = std::sin(lean);
  const double normal_A = at_A.value + side * lean, normal_B = at_B.value + side * (lean - 0.5 * kTurn);
  const double straight = apart.value * sine, r_A = side * radius_A_, r_B = side * radius_B_;
  return {normal_A,
          normal_B,
          straight,
          straight + r_B * normal_B - r_A * normal_A,
          sine * apart.on_A + r_B * at_B.on_B - r_A * at_A.on_A,
          sine * apart.on_B + r_B * at_B.on_A - r_A * at_A.on_B};
}

void SprocketPair::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const auto power = [](const Wrench& w, const MarkerView& m) { return w.force.dot(m.v) + w.torque.dot(m.w); };
  for (int i = 0; i < 2; ++i) {
    const Span s = span(1 - 2 * i, markers, rows);
    const double stretch = std::max(0.0, s.length - material_[i]), elastic = stiffness_ * stretch;
    const LimitedDamping damped(parameters_.damping, power(s.on_A, markers[0]) + power(s.on_B, markers[1]), elastic);
    rows.add({s.on_A, s.on_B}, elastic + damped.force, stretch > 0 ? stiffness_ * damped.by_elastic : 0, damped.damping,
             0.5 * elastic * stretch);
  }
}

void SprocketPair::initialize(std::span<const MarkerView> m) {
  initial::same_direction(m[0].z(), m[1].z(), "z");
  const double apart = (m[1].p - m[0].p).norm();
  if (!(apart > radius_A_ + radius_B_))
    throw SceneError("the sprockets overlap: " + std::to_string(apart) + " m apart, radii of " +
                         std::to_string(radius_A_) + " m and " + std::to_string(radius_B_) + " m",
                     "", "move the markers apart, or give fewer teeth or a smaller pitch");
  for (int i = 0; i < 2; ++i) {
    const Span s = span(1 - 2 * i, m, {});
    // EA (straight - L₀)/L₀ is the pretension.
    const double rest = s.straight / (1 + parameters_.pretension / parameters_.axial_stiffness);
    if (i == 0) stiffness_ = parameters_.axial_stiffness / rest;
    material_[i] = s.length - parameters_.pretension / stiffness_ + parameters_.slack;
  }
}

std::vector<DrawnShape> SprocketPair::drawn_shapes(int marker) const {
  return {visual::cylinder(marker == 0 ? radius_A_ : radius_B_, 0.5 * parameters_.pitch)};
}

void SprocketPair::drawn_line(std::span<const MarkerView> markers, const AngleMemory&, Matrix3X& points) const {
  const auto &A = markers[0], &B = markers[1];
  const Span left = span(1, markers, {}), right = span(-1, markers, {});
  points.resize(3, 2 * kArcPoints + 1);
  for (int i = 0; i < kArcPoints; ++i) {
    const double x = static_cast<double>(i) / (kArcPoints - 1);
    points.col(i) =
        A.p + radius_A_ * in_plane_direction(A, right.normal_A + (left.normal_A - kTurn - right.normal_A) * x);
    points.col(kArcPoints + i) =
        B.p + radius_B_ * in_plane_direction(B, left.normal_B + (right.normal_B - kTurn - left.normal_B) * x);
  }
  points.col(2 * kArcPoints) = points.col(0);
}

template std::unique_ptr<ForceBatch> make_force_batch<SprocketPair>();

}  // namespace lithe
