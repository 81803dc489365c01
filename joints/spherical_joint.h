#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/rigid_rows.h"

namespace lithe {

/// Ball joint: the two markers share their position. g = p_B - p_A, three rows. (docs/equations.md 7.3)
class SphericalJoint final : public Joint</*markers=*/2, /*rows=*/3> {
 public:
  static constexpr RigidRows kRigidRows{.point = true};
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override;
  std::optional<JointFreedom> freedom() const override { return JointFreedom{.rotation = JointFreedom::Rotation::any}; }
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<SphericalJoint>();

}  // namespace lithe
