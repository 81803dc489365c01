#include "joints/distance_joint.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/adjustable.h"
#include "engine/model/initial_pose.h"

namespace lithe {

DistanceJoint::DistanceJoint(Parameters parameters)
    : as_drawn_(!parameters.length), length_law_(std::move(parameters.length_law)) {
  require::without_jumps(length_law_, "length_law");
  if (as_drawn_) return;
  require::positive(*parameters.length, "length");
  length_ = *parameters.length;
}

void DistanceJoint::initialize(std::span<const MarkerView> m) {
  initial::apart(m[0], m[1]);
  if (as_drawn_) length_ = (m[1].p - m[0].p).norm();
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<DistanceJoint>();

}  // namespace lithe
