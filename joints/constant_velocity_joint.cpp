#include "joints/constant_velocity_joint.h"

#include "engine/assembly/batch_of.h"
#include "engine/model/initial_pose.h"

namespace lithe {

void ConstantVelocityJoint::initialize(std::span<const MarkerView> m) {
  initial::same_direction(m[0].z(), m[1].z(), "z");
  initial::same_direction(m[0].x(), m[1].x(), "x");
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<ConstantVelocityJoint>();

}  // namespace lithe
