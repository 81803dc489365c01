#include "joints/revolute_joint.h"

#include "engine/assembly/batch_of.h"
#include "engine/model/initial_pose.h"

namespace lithe {

void RevoluteJoint::initialize(std::span<const MarkerView> m) { initial::same_direction(m[0].z(), m[1].z(), "z"); }

template std::unique_ptr<ConstraintBatch> make_constraint_batch<RevoluteJoint>();

}  // namespace lithe
