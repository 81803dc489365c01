#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/joint_coordinate.h"

namespace lithe {

/// Block on a table: B stays in the plane through A normal to z_A, with its z axis along z_A; two translations and the
/// rotation about z are free.
///   g = (x_A · z_B, y_A · z_B, z_A · d), d = p_B - p_A, three rows. (docs/equations.md 7.3)
class PlanarJoint final : public Joint</*markers=*/2, /*rows=*/3> {
 public:
  /// Displacements along x_A and y_A, and the angle from x_A to x_B about z_A.
  JointCoordinate displacement_x() const {
    return {JointCoordinate::Kind::displacement, markers()[0], markers()[1], 0};
  }
  JointCoordinate displacement_y() const {
    return {JointCoordinate::Kind::displacement, markers()[0], markers()[1], 1};
  }
  JointCoordinate angle() const { return {JointCoordinate::Kind::angle, markers()[0], markers()[1]}; }
  std::vector<MeasuredAngle> angles() const override { return {{0, 1, 2}}; }

  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    perpendicular(A, A.x(), B, B.z(), rows);
    perpendicular(A, A.y(), B, B.z(), rows);
    in_plane(A, A.z(), B, rows);
  }
  std::optional<JointFreedom> freedom() const override {
    return JointFreedom{.x = true, .y = true, .rotation = JointFreedom::Rotation::about_z};
  }
  /// The rows also vanish with B upside down: refused.
  void initialize(std::span<const MarkerView> markers) override;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<PlanarJoint>();

}  // namespace lithe
