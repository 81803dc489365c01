#include "joints/gears/toothed_rack.h"

#include <numbers>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/initial_pose.h"
#include "engine/model/joint_by_residual.h"
#include "joints/gears/gear_shape.h"

namespace lithe {
namespace {

using S = ToothMesh::Coordinate;

GearDesign on_rack(GearDesign design) {
  if (design.teeth_B != 0)
    throw SceneError("teeth_B is " + std::to_string(design.teeth_B) + ", but B is a rack", "", "leave teeth_B out");
  if (design.teeth_A != std::round(design.teeth_A))
    throw SceneError("a gear of " + std::to_string(design.teeth_A) + " teeth", "", "give a whole number of teeth");
  design.teeth_B = kRackTeeth;
  return design;
}

/// Of the gear at the rack: x, h, u and φ, for markers or for poses with derivatives.
template <class Number, class P>
struct RackPlace {
  Number along, height, axial, angle;

  RackPlace(const P& A, const P& B, double radius) {
    using std::atan2;
    const auto d = (A.p - B.p).eval();
    along = d.dot(B.x()), height = d.dot(B.y());
    axial = -A.z().dot(B.y()) * radius - d.dot(B.z());
    angle = atan2(B.x().dot(A.y()), B.x().dot(A.x()));
  }
};

}  // namespace

ToothedRack::ToothedRack(Parameters parameters)
    : parameters_(std::move(parameters)), geometry_(on_rack(parameters_.gears)), mesh_(geometry_, parameters_.teeth) {}

std::array<ToothMesh::Flank, 2> ToothedRack::flanks(std::span<const MarkerView> markers,
                                                    const AngleMemory& memory) const {
  const GearGeometry& g = geometry_;
  const auto& [A, B] = by_residual::moved<2, 12>(markers);
  const double r = g.A.pitch_radius, cosine = std::cos(g.working_pressure_angle),
               sine = std::sin(g.working_pressure_angle);
  RackPlace<S, PoseOf<S>> at(A, B, r);
  at.angle.value = memory.wound(0, at.angle.value);
  const S turned = (at.angle - angle_) * r, moved = at.along - place_;
  const S lead = (moved - turned) * cosine + (at.axial - axial_) * std::tan(g.base_helix_angle);
  const S play = g.half_play(at.height);
  const S phase = (turned + moved) * (-0.5 * cosine / g.base_pitch) + parameters_.teeth.phase;

  const Eigen::Matrix<S, 3, 1> tilted = B.z() - A.z();
  const S tilt_along = B.x().dot(tilted) * cosine, tilt_away = B.y().dot(tilted) * -sine;
  const auto flank = [&](double way, const S& on) -> ToothMesh::Flank {
    const Vector3 n = way * cosine * markers[1].x() - sine * markers[1].y();
    return {lead * way - play,      tilt_along * way + tilt_away, on, markers[0].p - r * markers[1].y(), n,
            markers[1].z().cross(n)};
  };
  return {flank(1, phase), flank(-1, mesh_.back_phase(phase))};
}

void ToothedRack::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  for (const ToothMesh::Flank& flank : flanks(markers, rows)) mesh_.add(flank, markers[0], markers[1], rows);
}

void ToothedRack::initialize(std::span<const MarkerView> m) {
  initial::same_direction(m[0].z(), m[1].z(), "z");
  const RackPlace<double, MarkerView> at(m[0], m[1], geometry_.A.pitch_radius);
  const double module = parameters_.gears.module;
  if (!(std::abs(at.height - geometry_.centre_distance) < 0.1 * module) ||
      geometry_.half_play(at.height) < -1e-6 * module)
    throw SceneError("the gear's centre is " + std::to_string(at.height) +
                         " m from the rack's marker along its y axis; it meshes at " +
                         std::to_string(geometry_.centre_distance) + " m, and teeth must not overlap",
                     "", "move a marker, or give centre_distance, shift_A or a backlash to match");
  place_ = at.along, axial_ = at.axial, angle_ = initial::angle(at.angle);
  pitch_at_ = std::atan2(-m[1].y().dot(m[0].y()), -m[1].y().dot(m[0].x()));
}

std::vector<DrawnShape> ToothedRack::drawn_shapes(int marker) const {
  if (marker == 1) return {};
  const InvoluteGear& A = geometry_.A;
  return {gear_shape(geometry_, A,
                     pitch_at_ + 2 * std::numbers::pi * parameters_.teeth.phase / A.teeth -
                         0.5 * A.tooth_thickness / A.working_radius)};
}

template std::unique_ptr<ForceBatch> make_force_batch<ToothedRack>();

double critical_damping(const ToothedRack::Parameters& gear, double inertia_A, double mass_B) {
  require::positive(inertia_A, "inertia_A");
  require::positive(mass_B, "mass_B");
  const ToothedRack rack(gear);
  const double r = rack.geometry().A.pitch_radius, cosine = std::cos(rack.geometry().working_pressure_angle);
  return rack.mesh().critical_damping(cosine * cosine * (r * r / inertia_A + 1 / mass_B));
}

}  // namespace lithe
