#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/rigid_rows.h"

namespace lithe {

/// Cardan joint: the markers share their position, and the cross between them has one arm along x_A and the other along
/// y_B, at right angles; turns about either arm are left, two rotations. With equal marker axes the shafts lie along z.
///   g = (p_B - p_A, x_A · y_B), four rows. (docs/equations.md 7.3)
class UniversalJoint final : public Joint</*markers=*/2, /*rows=*/4> {
 public:
  static constexpr RigidRows kRigidRows{.point = true, .angles = 1, .perpendicular = {{{0, 1}}}};
  /// Turn about x_A, from y_A to y_B, and turn about y_B, from z_A to z_B.
  JointCoordinate first_angle() const { return {JointCoordinate::Kind::angle, markers()[0], markers()[1], 0}; }
  JointCoordinate second_angle() const { return {JointCoordinate::Kind::angle, markers()[1], markers()[0], 1, -1}; }
  std::vector<MeasuredAngle> angles() const override { return {{0, 1, 0}, {1, 0, 1}}; }
  bool depends_on_time() const override { return false; }
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    coincident(A, B, rows);
    perpendicular(A, A.x(), B, B.y(), rows);
  }
  /// Refuses arms that are nearly parallel as drawn: the last row would restrain nothing there.
  void initialize(std::span<const MarkerView> markers) override;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<UniversalJoint>();

}  // namespace lithe
