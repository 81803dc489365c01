#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/rigid_rows.h"

namespace lithe {

/// The z axes of the markers stay parallel; all translations and the rotation about z are free.
///   g = (x_A · z_B, y_A · z_B), two rows. (docs/equations.md 7.3, the rows of a hinge that hold its axis)
class ParallelAxesJoint final : public Joint</*markers=*/2, /*rows=*/2> {
 public:
  static constexpr RigidRows kRigidRows{.angles = 2, .perpendicular = {{{0, 2}, {1, 2}}}};
  /// From x_A to x_B about z_A.
  JointCoordinate angle() const { return {JointCoordinate::Kind::angle, markers()[0], markers()[1]}; }
  std::vector<MeasuredAngle> angles() const override { return {{0, 1, 2}}; }
  bool depends_on_time() const override { return false; }
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    perpendicular(A, A.x(), B, B.z(), rows);
    perpendicular(A, A.y(), B, B.z(), rows);
  }
  /// The rows also vanish with the axes turned by 180 degrees: refused.
  void initialize(std::span<const MarkerView> markers) override;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<ParallelAxesJoint>();

}  // namespace lithe
