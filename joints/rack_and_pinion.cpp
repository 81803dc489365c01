#include "joints/rack_and_pinion.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/initial_pose.h"
#include "engine/model/joint_coordinate.h"

namespace lithe {

RackAndPinion::RackAndPinion(Parameters parameters) : radius_(parameters.radius) {
  require::finite(radius_, "radius");
  if (radius_ == 0) throw SceneError("radius is 0", "", "give the pitch radius of the pinion, m");
}

void RackAndPinion::evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const {
  const auto &pinion = markers[0], &rack = markers[1];
  const MeasuredCoordinate x = measure(JointCoordinate::Kind::displacement, 0, rack, pinion),
                           phi = measure(JointCoordinate::Kind::angle, 2, rack, pinion);
  rows.add(x.value + radius_ * rows.wound(0, phi.value) - offset_,
           {x.on_B + radius_ * phi.on_B, x.on_A + radius_ * phi.on_A}, x.bias + radius_ * phi.bias);
}

void RackAndPinion::initialize(std::span<const MarkerView> m) {
  initial::same_direction(m[0].z(), m[1].z(), "z");
  offset_ = measure(JointCoordinate::Kind::displacement, 0, m[1], m[0]).value +
            radius_ * initial::angle(measure(JointCoordinate::Kind::angle, 2, m[1], m[0]).value);
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<RackAndPinion>();

}  // namespace lithe
