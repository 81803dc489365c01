#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/rigid_rows.h"

namespace lithe {

/// Weld: the markers share their position and all axes; no freedom is left.
///   g = (p_B - p_A, x_A · y_B, y_A · z_B, z_A · x_B), six rows. (docs/equations.md 7.3)
class FixedJoint final : public Joint</*markers=*/2, /*rows=*/6> {
 public:
  static constexpr RigidRows kRigidRows{.point = true, .angles = 3, .perpendicular = {{{0, 1}, {1, 2}, {2, 0}}}};
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    coincident(A, B, rows);
    perpendicular(A, A.x(), B, B.y(), rows);
    perpendicular(A, A.y(), B, B.z(), rows);
    perpendicular(A, A.z(), B, B.x(), rows);
  }
  std::optional<JointFreedom> freedom() const override { return JointFreedom{}; }
  /// The rows also vanish with two axes turned by 180 degrees, and with all three exchanged in a circle: refused.
  void initialize(std::span<const MarkerView> markers) override;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<FixedJoint>();

}  // namespace lithe
