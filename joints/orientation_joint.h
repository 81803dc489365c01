#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/rigid_rows.h"

namespace lithe {

/// The markers keep equal axes; B translates freely, three degrees of freedom.
///   g = (x_A · y_B, y_A · z_B, z_A · x_B), three rows. (docs/equations.md 7.3, the rows of a slider that hold its
///   axes)
class OrientationJoint final : public Joint</*markers=*/2, /*rows=*/3> {
 public:
  static constexpr RigidRows kRigidRows{.angles = 3, .perpendicular = {{{0, 1}, {1, 2}, {2, 0}}}};
  /// Displacement of B along the axes of A.
  JointCoordinate displacement_x() const { return displacement(0); }
  JointCoordinate displacement_y() const { return displacement(1); }
  JointCoordinate displacement_z() const { return displacement(2); }
  bool depends_on_time() const override { return false; }
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    perpendicular(A, A.x(), B, B.y(), rows);
    perpendicular(A, A.y(), B, B.z(), rows);
    perpendicular(A, A.z(), B, B.x(), rows);
  }
  /// The rows also vanish with other turns of the axes: refused.
  void initialize(std::span<const MarkerView> markers) override;

 private:
  JointCoordinate displacement(int axis) const {
    return {JointCoordinate::Kind::displacement, markers()[0], markers()[1], axis};
  }
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<OrientationJoint>();

}  // namespace lithe
