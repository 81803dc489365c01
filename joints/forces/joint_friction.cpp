#include "joints/forces/joint_friction.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

JointFriction::JointFriction(CoordinateSet coordinates, Parameters parameters)
    : surface_(std::move(coordinates),
               {parameters.joint, parameters.radius, parameters.bending_arm, parameters.preload}),
      law_({parameters.coefficient, parameters.static_coefficient, parameters.stribeck_speed, parameters.creep_speed}) {
  require::not_negative(parameters.viscous, "viscous");
  viscous_ = surface_.viscous(parameters.viscous);
}

/// A row along the sliding velocity, the rest across it: together the derivative of a force against that velocity.
void JointFriction::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const JointSurface::Sliding sliding = surface_.sliding(markers, rows);
  const int n = surface_.directions();
  if (rows.friction_left_out()) {
    for (int k = 0; k < n; ++k) {
      surface_.fill(sliding, Vector3::Unit(k), rows.open());
      rows.finish(viscous_ * sliding.speed[k], 0, viscous_);
    }
    return;
  }
  const auto [N, by] = surface_.press(markers, rows.reaction());
  const double speed = n == 1 ? sliding.speed[0] : sliding.speed.norm();
  const Vector3 along = n == 1 || speed == 0 ? Vector3(1, 0, 0) : Vector3(sliding.speed / speed);

  const auto [mu, slope] = law_.at(speed);
  surface_.fill(sliding, along, rows.open());
  rows.finish(mu * N + viscous_ * speed, 0, slope * N + viscous_);
  rows.depends_on_reaction(mu * by);
  const double across = (speed == 0 ? slope : mu / speed) * N + viscous_;
  const Vector3 second = n == 2 ? Vector3(-along[1], along[0], 0) : Vector3(along.unitOrthogonal());
  for (int k = 1; k < n; ++k) {
    surface_.fill(sliding, k == 1 ? second : Vector3(along.cross(second)), rows.open());
    rows.finish(0, 0, across);
  }
}

template std::unique_ptr<ForceBatch> make_force_batch<JointFriction>();

}  // namespace lithe
