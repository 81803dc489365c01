#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/joint_coordinate.h"

namespace lithe {

/// Bead on a wire: point B keeps on the line through A along z_A; four freedoms are left.
///   g = (x_A · d, y_A · d), d = p_B - p_A, two rows.
class PointOnLineJoint final : public Joint</*markers=*/2, /*rows=*/2> {
 public:
  /// Displacement along z_A.
  JointCoordinate displacement() const { return {JointCoordinate::Kind::displacement, markers()[0], markers()[1]}; }

  bool depends_on_time() const override { return false; }
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<PointOnLineJoint>();

}  // namespace lithe
