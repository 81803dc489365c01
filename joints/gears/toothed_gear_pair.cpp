#include "joints/gears/toothed_gear_pair.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/initial_pose.h"
#include "engine/model/joint_by_residual.h"
#include "joints/gears/gear_shape.h"

namespace lithe {
namespace {

using S = ToothMesh::Coordinate;
S bearing_of_point(const PoseOf<S>& from, const Eigen::Matrix<S, 3, 1>& to) {
  return atan2(to.dot(from.y()), to.dot(from.x()));
}

}  // namespace

ToothedGearPair::ToothedGearPair(Parameters parameters)
    : parameters_(std::move(parameters)), geometry_(parameters_.gears), mesh_(geometry_, parameters_.teeth) {
  for (double z : {geometry_.A.teeth, geometry_.B.teeth})
    if (z != std::round(z))
      throw SceneError("a gear of " + std::to_string(z) + " teeth", "",
                       "give whole numbers of teeth; a rack is a ToothedRack");
}

std::array<ToothMesh::Flank, 2> ToothedGearPair::flanks(std::span<const MarkerView> markers,
                                                        const AngleMemory& memory) const {
  const GearGeometry& g = geometry_;
  const auto& [A, B] = by_residual::moved<2, 12>(markers);
  const Eigen::Matrix<S, 3, 1> d = B.p - A.p;
  const S axial_A = d.dot(A.z()), axial_B = d.dot(B.z()), apart = sqrt(d.squaredNorm() - axial_A * axial_B);
  if (!(apart.value > std::abs(g.A.base_radius + g.B.base_radius)))
    throw SimulationError("the centres are " + std::to_string(apart.value) + " m apart, within the base circles", "",
                          "hold the gears' centres apart by bearings");
  S phi_A = bearing_of_point(A, d), phi_B = bearing_of_point(B, -d);
  phi_A.value = memory.wound(0, phi_A.value) - bearing_A_, phi_B.value = memory.wound(1, phi_B.value) - bearing_B_;
  // The pitch point divides the line of centres as the base circles do.
  const double r_b = g.A.base_radius + g.B.base_radius, division = g.A.base_radius / r_b;
  const S axial = division * axial_A + (1 - division) * axial_B - axial_;
  const S lead = axial * std::tan(g.base_helix_angle) - g.A.base_radius * phi_A - g.B.base_radius * phi_B;
  const S play = g.half_play(apart);
  const S phase = (g.B.base_radius * phi_B - g.A.base_radius * phi_A) * (0.5 / g.base_pitch) + parameters_.teeth.phase;

  const Eigen::Matrix<S, 3, 1> radial = (d - A.z() * axial_A) / apart, tangent = A.z().cross(radial);
  const double side = r_b < 0 ? -1 : 1;
  const S cosine = std::abs(r_b) / apart, sine = sqrt(1.0 - cosine * cosine);
  const Eigen::Matrix<S, 3, 1> along = tangent * (side * cosine), away = radial * (side * sine), tilted = B.z() - A.z();
  const Vector3 pitch_point = markers[0].p + division * (markers[1].p - markers[0].p);
  const auto flank = [&](double way, const S& on) -> ToothMesh::Flank {
    const Eigen::Matrix<S, 3, 1> normal = along * way + away;
    const Vector3 n = ToothMesh::value(normal);
    return {lead * way - play, normal.dot(tilted), on, pitch_point, n, markers[0].z().cross(n)};
  };
  return {flank(1, phase), flank(-1, mesh_.back_phase(phase))};
}

void ToothedGearPair::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  for (const ToothMesh::Flank& flank : flanks(markers, rows)) mesh_.add(flank, markers[0], markers[1], rows);
}

void ToothedGearPair::initialize(std::span<const MarkerView> m) {
  initial::same_direction(m[0].z(), m[1].z(), "z");
  const Vector3 d = m[1].p - m[0].p;
  const double axial_A = d.dot(m[0].z()), axial_B = d.dot(m[1].z());
  const double apart = std::sqrt(d.squaredNorm() - axial_A * axial_B), meant = std::abs(geometry_.centre_distance);
  if (!(std::abs(apart - meant) < 0.01 * meant) || geometry_.half_play(apart) < -1e-6 * parameters_.gears.module)
    throw SceneError("the centres are " + std::to_string(apart) + " m apart; these gears mesh at " +
                         std::to_string(meant) + " m with a backlash of " + std::to_string(geometry_.backlash) +
                         " m, and their teeth must not overlap",
                     "", "move the markers, or give centre_distance, shifts or a backlash to match");
  const double division = geometry_.A.base_radius / (geometry_.A.base_radius + geometry_.B.base_radius);
  axial_ = division * axial_A + (1 - division) * axial_B;
  bearing_A_ = initial::angle(measure(JointCoordinate::Kind::bearing, 2, m[0], m[1]).value);
  bearing_B_ = initial::angle(measure(JointCoordinate::Kind::bearing, 2, m[1], m[0]).value);
}

std::vector<DrawnShape> ToothedGearPair::drawn_shapes(int marker) const {
  const InvoluteGear &A = geometry_.A, &B = geometry_.B;
  const double turn = 2 * std::numbers::pi;
  const GearPhase phase(geometry_, parameters_.teeth.phase);
  if (marker == 0)
    return {
        gear_shape(geometry_, A, bearing_A_ + (geometry_.is_internal() ? 0.5 * turn : 0) + turn * phase.A / A.teeth)};
  return {gear_shape(geometry_, B, bearing_B_ + turn * phase.B / B.teeth)};
}

template std::unique_ptr<ForceBatch> make_force_batch<ToothedGearPair>();

double critical_damping(const ToothedGearPair::Parameters& gears, double inertia_A, double inertia_B) {
  require::positive(inertia_A, "inertia_A");
  require::positive(inertia_B, "inertia_B");
  const ToothedGearPair pair(gears);
  const double r_A = pair.geometry().A.base_radius, r_B = pair.geometry().B.base_radius;
  return pair.mesh().critical_damping(r_A * r_A / inertia_A + r_B * r_B / inertia_B);
}

}  // namespace lithe
