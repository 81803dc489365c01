#pragma once

#include "engine/batch.h"
#include "engine/constraint.h"

namespace lithe {

/// Hinge: the markers share their position and their z axis; one rotation is left free.
///   g = (p_B - p_A, x_A · z_B, y_A · z_B), five rows. (EQUATIONS.md 7.3)
class RevoluteJoint final : public Joint</*markers=*/2, /*rows=*/5> {
 public:
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    coincident(A, B, rows);
    perpendicular(A, A.x(), B, B.z(), rows);
    perpendicular(A, A.y(), B, B.z(), rows);
  }
  /// The rows also vanish with the axes turned by 180 degrees: refused.
  void initialize(std::span<const MarkerView> markers) override;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<RevoluteJoint>();

}  // namespace lithe
