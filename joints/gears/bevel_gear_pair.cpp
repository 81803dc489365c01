#include "joints/gears/bevel_gear_pair.h"

#include <numbers>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/initial_pose.h"
#include "engine/model/joint_by_residual.h"
#include "joints/gears/gear_shape.h"

namespace lithe {
namespace {

using S = ToothMesh::Coordinate;
using Vector3S = Eigen::Matrix<S, 3, 1>;

double cone_angle(const BevelGearPair::Parameters& p) {
  for (double z : {p.teeth_A, p.teeth_B})
    if (!(z >= 4) || z != std::round(z))
      throw SceneError("a bevel gear of " + std::to_string(z) + " teeth", "",
                       "give whole numbers of four teeth or more");
  require::positive(p.module, "module");
  require::positive(p.face_width, "face_width");
  const double sine = std::sin(p.shaft_angle), cosine = std::cos(p.shaft_angle);
  const double A = std::atan2(sine, p.teeth_B / p.teeth_A + cosine),
               B = std::atan2(sine, p.teeth_A / p.teeth_B + cosine);
  if (!(p.shaft_angle > 0.05 && std::max(A, B) < 1.5))
    throw SceneError("shaft_angle is " + std::to_string(p.shaft_angle) + " rad: cones of " + std::to_string(A) +
                         " and " + std::to_string(B) + " rad",
                     "", "give one from 0.05 rad up to where the larger cone has 1.5 rad");
  const double distance = 0.5 * p.module * p.teeth_A / std::sin(A);
  if (0.5 * p.face_width >= distance)
    throw SceneError("face_width is " + std::to_string(p.face_width) + " m, and the middle of the face is " +
                         std::to_string(distance) + " m from the apex",
                     "", "give a face below twice that; a third is usual");
  return A;
}

GearDesign virtual_gears(const BevelGearPair::Parameters& p, double cone_A) {
  return {.module = p.module,
          .teeth_A = p.teeth_A / std::cos(cone_A),
          .teeth_B = p.teeth_B / std::cos(p.shaft_angle - cone_A),
          .pressure_angle = p.pressure_angle,
          .face_width = p.face_width,
          .backlash = p.backlash};
}

/// Angle of the other axis about this one.
template <class P>
auto bearing_of_axis(const P& from, const P& other) {
  using std::atan2;
  return atan2(other.z().dot(from.y()), other.z().dot(from.x()));
}

}  // namespace

BevelGearPair::BevelGearPair(Parameters parameters)
    : parameters_(std::move(parameters)),
      cone_A_(cone_angle(parameters_)),
      geometry_(virtual_gears(parameters_, cone_A_)),
      mesh_(geometry_, parameters_.teeth) {}

std::array<ToothMesh::Flank, 2> BevelGearPair::flanks(std::span<const MarkerView> markers, const AngleMemory&) const {
  const Parameters& p = parameters_;
  const auto& [A, B] = by_residual::moved<2, 12>(markers);
  const double cosine = std::cos(p.pressure_angle), sine = std::sin(p.pressure_angle);
  const double r_A = 0.5 * p.module * p.teeth_A, r_B = 0.5 * p.module * p.teeth_B, R = r_A / std::sin(cone_A_);

  const Vector3S z_A = A.z(), z_B = B.z(), e = B.p - A.p + z_B * apex_B_ - z_A * apex_A_, normal = z_A.cross(z_B);
  const S size = sqrt(normal.squaredNorm());
  const Vector3S t = normal / size;
  const Vector3S line = z_A * std::sin(cone_angle_B()) + z_B * std::sin(cone_A_);
  const Vector3S m = t.cross(line) / sqrt(line.squaredNorm());

  const S moved_A = (bearing_A_ - bearing_of_axis(A, B)) * r_A, moved_B = (bearing_of_axis(B, A) - bearing_B_) * r_B;
  S lead = (moved_A - moved_B - t.dot(e)) * cosine;
  lead.value -= geometry_.base_pitch * std::round(lead.value / geometry_.base_pitch);
  const S play = (m.dot(e) + (atan2(size, z_A.dot(z_B)) - p.shaft_angle) * R) * sine + 0.5 * p.backlash;
  const S phase = (moved_A * cosine - lead * 0.5) / geometry_.base_pitch + p.teeth.phase;

  const Vector3 along = ToothMesh::value(t), away = ToothMesh::value(m), on_line = ToothMesh::value(line).normalized();
  const Vector3 pitch_point = markers[0].p + apex_A_ * markers[0].z() + R * on_line;
  const auto flank = [&](double way, const S& on) -> ToothMesh::Flank {
    const Vector3 n = way * cosine * along + sine * away;
    return {lead * way - play, 0, on, pitch_point, n, on_line.cross(n)};
  };
  return {flank(1, phase), flank(-1, mesh_.back_phase(phase))};
}

void BevelGearPair::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  for (const ToothMesh::Flank& flank : flanks(markers, rows)) mesh_.add(flank, markers[0], markers[1], rows);
}

void BevelGearPair::initialize(std::span<const MarkerView> m) {
  const Vector3 z_A = m[0].z(), z_B = m[1].z(), d = m[1].p - m[0].p;
  const double cosine = z_A.dot(z_B), angle = std::atan2(z_A.cross(z_B).norm(), cosine);
  if (!(std::abs(angle - parameters_.shaft_angle) < 0.01))
    throw SceneError("the z axes make an angle of " + std::to_string(angle) + " rad; shaft_angle is " +
                         std::to_string(parameters_.shaft_angle) + " rad",
                     "", "turn the markers so that both z axes point away from where they meet, or give that angle");
  // Where the axes are nearest to each other: p_A + a z_A and p_B + b z_B.
  const double across = 1 - cosine * cosine;
  apex_A_ = (d.dot(z_A) - cosine * d.dot(z_B)) / across;
  apex_B_ = (cosine * d.dot(z_A) - d.dot(z_B)) / across;
  const double gap = (d + apex_B_ * z_B - apex_A_ * z_A).norm();
  if (!(gap < 0.1 * parameters_.module))
    throw SceneError("the axes pass each other by " + std::to_string(gap) + " m", "", "let them meet in one point");
  bearing_A_ = bearing_of_axis(m[0], m[1]), bearing_B_ = bearing_of_axis(m[1], m[0]);
}

std::vector<DrawnShape> BevelGearPair::drawn_shapes(int marker) const {
  const double turn = 2 * std::numbers::pi, R = 0.5 * parameters_.module * parameters_.teeth_A / std::sin(cone_A_);
  const GearPhase phase(geometry_, parameters_.teeth.phase);
  const auto shape = [&](const InvoluteGear& gear, double teeth, double cone, double apex, double at) {
    return bevel_gear_shape(geometry_, gear, {static_cast<int>(teeth), cone, R, apex}, at);
  };
  if (marker == 0)
    return {
        shape(geometry_.A, parameters_.teeth_A, cone_A_, apex_A_, bearing_A_ + turn * phase.A / parameters_.teeth_A)};
  return {shape(geometry_.B, parameters_.teeth_B, cone_angle_B(), apex_B_,
                bearing_B_ + turn * phase.B / parameters_.teeth_B)};
}

template std::unique_ptr<ForceBatch> make_force_batch<BevelGearPair>();

double critical_damping(const BevelGearPair::Parameters& gears, double inertia_A, double inertia_B) {
  require::positive(inertia_A, "inertia_A");
  require::positive(inertia_B, "inertia_B");
  const BevelGearPair pair(gears);
  const double arm = 0.5 * gears.module * std::cos(gears.pressure_angle);  // on the line of action, by a tooth
  return pair.mesh().critical_damping(
      arm * arm * (gears.teeth_A * gears.teeth_A / inertia_A + gears.teeth_B * gears.teeth_B / inertia_B));
}

}  // namespace lithe
