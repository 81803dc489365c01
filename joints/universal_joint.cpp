#include "joints/universal_joint.h"

#include "engine/assembly/batch_of.h"
#include "engine/model/initial_pose.h"

namespace lithe {

void UniversalJoint::initialize(std::span<const MarkerView> m) { initial::not_parallel(m[0].x(), m[1].y(), "x", "y"); }

template std::unique_ptr<ConstraintBatch> make_constraint_batch<UniversalJoint>();

}  // namespace lithe
