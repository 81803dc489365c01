#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/rigid_rows.h"

namespace lithe {

/// The z axes of the markers stay at right angles; five degrees of freedom are left.
///   g = z_A · z_B, one row.
class PerpendicularAxesJoint final : public Joint</*markers=*/2, /*rows=*/1> {
 public:
  static constexpr RigidRows kRigidRows{.angles = 1, .perpendicular = {{{2, 2}}}};
  bool depends_on_time() const override { return false; }
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    perpendicular(A, A.z(), B, B.z(), rows);
  }
  /// Refuses axes that are nearly parallel as drawn: the row would restrain nothing there.
  void initialize(std::span<const MarkerView> markers) override;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<PerpendicularAxesJoint>();

}  // namespace lithe
