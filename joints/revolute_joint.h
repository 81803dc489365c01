#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/rigid_rows.h"

namespace lithe {

/// Hinge: the markers share their position and their z axis; one rotation is left free.
///   g = (p_B - p_A, x_A · z_B, y_A · z_B), five rows. (docs/equations.md 7.3)
class RevoluteJoint final : public Joint</*markers=*/2, /*rows=*/5> {
 public:
  static constexpr RigidRows kRigidRows{.point = true, .angles = 2, .perpendicular = {{{0, 2}, {1, 2}}}};
  /// From x_A to x_B about z_A.
  JointCoordinate angle() const { return {JointCoordinate::Kind::angle, markers()[0], markers()[1]}; }
  std::vector<MeasuredAngle> angles() const override { return {{0, 1, 2}}; }
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    coincident(A, B, rows);
    perpendicular(A, A.x(), B, B.z(), rows);
    perpendicular(A, A.y(), B, B.z(), rows);
  }
  std::optional<JointFreedom> freedom() const override {
    return JointFreedom{.rotation = JointFreedom::Rotation::about_z};
  }
  /// The rows also vanish with the axes turned by 180 degrees: refused.
  void initialize(std::span<const MarkerView> markers) override;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<RevoluteJoint>();

}  // namespace lithe
