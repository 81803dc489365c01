#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/joint_coordinate.h"

namespace lithe {

/// Sleeve on a shaft: the markers share their z axis as a line; B slides along it and turns about it, two freedoms.
///   g = (x_A · z_B, y_A · z_B, x_A · d, y_A · d), d = p_B - p_A, four rows. (docs/equations.md 7.3)
class CylindricalJoint final : public Joint</*markers=*/2, /*rows=*/4> {
 public:
  /// From x_A to x_B about z_A.
  JointCoordinate angle() const { return {JointCoordinate::Kind::angle, markers()[0], markers()[1]}; }
  /// Of B along z_A.
  JointCoordinate displacement() const { return {JointCoordinate::Kind::displacement, markers()[0], markers()[1]}; }
  std::vector<MeasuredAngle> angles() const override { return {{0, 1, 2}}; }
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    perpendicular(A, A.x(), B, B.z(), rows);
    perpendicular(A, A.y(), B, B.z(), rows);
    in_plane(A, A.x(), B, rows);
    in_plane(A, A.y(), B, rows);
  }
  std::optional<JointFreedom> freedom() const override {
    return JointFreedom{.z = true, .rotation = JointFreedom::Rotation::about_z};
  }
  /// The rows also vanish with the axes turned by 180 degrees: refused.
  void initialize(std::span<const MarkerView> markers) override;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<CylindricalJoint>();

}  // namespace lithe
