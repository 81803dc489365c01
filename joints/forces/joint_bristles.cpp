#include "joints/forces/joint_bristles.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {
namespace {

constexpr double kFollowing = 1e-4;  // s
// N that the followed load's state counts in: so many that error control does not look at it.
constexpr double kUnit = 1e6;

}  // namespace

JointBristles::JointBristles(Parameters parameters)
    : surface_(CoordinateSet(std::move(parameters.coordinates)),
               {parameters.joint, parameters.radius, parameters.bending_arm, parameters.preload}),
      law_({{parameters.coefficient, parameters.static_coefficient, parameters.stribeck_speed},
            parameters.breakaway_deflection,
            parameters.damping_time,
            parameters.elastic_share}) {
  require::not_negative(parameters.viscous, "viscous");
  viscous_ = surface_.viscous(parameters.viscous);
}

/// The force in two parts, of the load n that a state follows and of what N is beyond it. Loads do not know N, but have
/// exact derivatives by z and n, and n by the joint's multipliers: a row's tension has none by z.
void JointBristles::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const int joint_markers = surface_.marker_count(), n = surface_.directions();
  const MarkerView &bristles = markers[joint_markers], &follower = markers[joint_markers + 1];
  const JointSurface::Sliding sliding = surface_.sliding(markers, rows);
  const auto [N, by] = surface_.press(markers, rows.reaction());
  const Vector3 z = bristles.v;
  const double followed = kUnit * follower.v[0];
  const BristleLaw::Value value = law_.at(sliding.speed, z);

  rows.add_load(bristles, force(value.rate));
  Wrench wrenches[kMaxMarkers];
  surface_.fill(sliding, -(followed * value.force + viscous_ * sliding.speed), wrenches);
  for (int m = 0; m < joint_markers; ++m) rows.add_load(markers[m], wrenches[m]);
  rows.add_energy(followed * law_.energy(z));

  const Wrench none{Vector3::Zero(), Vector3::Zero()};
  for (int k = 0; k < n; ++k) {
    Wrench* row = rows.open();
    surface_.fill(sliding, Vector3::Unit(k), row);
    row[joint_markers] = row[joint_markers + 1] = none;
    rows.finish((N - followed) * value.force[k], 0, (N - followed) * value.damping);
  }
  Wrench* row = rows.open();
  std::fill_n(row, marker_count(), none);
  row[joint_markers + 1] = force(Vector3::UnitX());
  rows.finish((follower.v[0] - N / kUnit) / kFollowing, 0, 1 / kFollowing);
  rows.depends_on_reaction(-1 / (kUnit * kFollowing) * by);
}

template std::unique_ptr<ForceBatch> make_force_batch<JointBristles>();

}  // namespace lithe
