#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"

namespace lithe {

/// Ball on a table that never lifts off: point B keeps in the plane through A normal to z_A; five freedoms are left.
///   g = z_A · (p_B - p_A), one row.
class PointOnPlaneJoint final : public Joint</*markers=*/2, /*rows=*/1> {
 public:
  bool depends_on_time() const override { return false; }
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<PointOnPlaneJoint>();

}  // namespace lithe
