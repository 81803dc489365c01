#include "joints/constant_velocity_joint.h"

#include <cmath>
#include <cstdio>
#include <numbers>

#include "engine/assembly/batch_of.h"
#include "engine/model/initial_pose.h"

namespace lithe {

void ConstantVelocityJoint::initialize(std::span<const MarkerView> m) {
  initial::same_direction(m[0].z(), m[1].z(), "z");
  initial::same_direction(m[0].x(), m[1].x(), "x");
}

std::optional<std::string> ConstantVelocityJoint::beyond_limit(std::span<const MarkerView> m) const {
  const double c = m[0].z().dot(m[1].z());
  if (!(c < 0)) return std::nullopt;
  const double bend = std::atan2(m[0].z().cross(m[1].z()).norm(), c) * 180 / std::numbers::pi;
  char text[80];
  std::snprintf(text, sizeof text, "is bent by %.1f degrees, beyond its limit of a right angle,", bend);
  return text;
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<ConstantVelocityJoint>();

}  // namespace lithe
