#include "joints/prismatic_joint.h"

#include "engine/assembly/batch_of.h"
#include "engine/model/initial_pose.h"

namespace lithe {

void PrismaticJoint::initialize(std::span<const MarkerView> m) { initial::same_axes(m[0], m[1]); }

template std::unique_ptr<ConstraintBatch> make_constraint_batch<PrismaticJoint>();

}  // namespace lithe
