#include "joints/screw_joint.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/initial_pose.h"

namespace lithe {

ScrewJoint::ScrewJoint(Parameters parameters) : rise_(parameters.lead / (2 * std::numbers::pi)) {
  require::finite(parameters.lead, "lead");
  if (parameters.lead == 0)
    throw SceneError("lead is 0", "", "give the metres that B moves a turn; without a lead take a CylindricalJoint");
}

void ScrewJoint::evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const {
  constexpr auto displacement = JointCoordinate::Kind::displacement, angle = JointCoordinate::Kind::angle;
  const auto &A = markers[0], &B = markers[1];
  perpendicular(A, A.x(), B, B.z(), rows);
  perpendicular(A, A.y(), B, B.z(), rows);
  in_plane(A, A.x(), B, rows);
  in_plane(A, A.y(), B, rows);
  const MeasuredCoordinate s = measure(displacement, 2, A, B), phi = measure(angle, 2, A, B);
  rows.add(s.value - rise_ * rows.wound(0, phi.value) - offset_, {s.on_A - rise_ * phi.on_A, s.on_B - rise_ * phi.on_B},
           s.bias - rise_ * phi.bias);
}

void ScrewJoint::initialize(std::span<const MarkerView> m) {
  initial::same_direction(m[0].z(), m[1].z(), "z");
  offset_ = measure(JointCoordinate::Kind::displacement, 2, m[0], m[1]).value -
            rise_ * initial::angle(measure(JointCoordinate::Kind::angle, 2, m[0], m[1]).value);
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<ScrewJoint>();

}  // namespace lithe
