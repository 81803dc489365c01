#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/joint_coordinate.h"

namespace lithe {

/// Slider: all axes stay parallel and B moves along the z axis of A; one translation is left free.
///   g = (x_A · y_B, y_A · z_B, z_A · x_B, x_A · d, y_A · d), d = p_B - p_A, five rows. (docs/equations.md 7.3)
class PrismaticJoint final : public Joint</*markers=*/2, /*rows=*/5> {
 public:
  /// Of B along z_A.
  JointCoordinate displacement() const { return {JointCoordinate::Kind::displacement, markers()[0], markers()[1]}; }
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    perpendicular(A, A.x(), B, B.y(), rows);
    perpendicular(A, A.y(), B, B.z(), rows);
    perpendicular(A, A.z(), B, B.x(), rows);
    in_plane(A, A.x(), B, rows);
    in_plane(A, A.y(), B, rows);
  }
  std::optional<JointFreedom> freedom() const override { return JointFreedom{.z = true}; }
  /// The rows also vanish with two axes turned by 180 degrees, and with all three exchanged in a circle: refused.
  void initialize(std::span<const MarkerView> markers) override;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<PrismaticJoint>();

}  // namespace lithe
