#include "joints/perpendicular_axes_joint.h"

#include "engine/assembly/batch_of.h"
#include "engine/model/initial_pose.h"

namespace lithe {

void PerpendicularAxesJoint::initialize(std::span<const MarkerView> m) {
  initial::not_parallel(m[0].z(), m[1].z(), "z", "z");
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<PerpendicularAxesJoint>();

}  // namespace lithe
