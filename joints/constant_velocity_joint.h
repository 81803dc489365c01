#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/limited_motion.h"

namespace lithe {

/// Homokinetic joint of two shafts along z (Rzeppa, Tripod): the markers share their position, and B does not twist
/// against A about the line that bisects the angle of the shafts, so both turn at the same speed at any bend angle; two
/// degrees of freedom are left.
///   g = (p_B - p_A, y_A · x_B - x_A · y_B), four rows: the relative rotation has no component about z. The bend
///   angle must be below a right angle.
class ConstantVelocityJoint final : public Joint</*markers=*/2, /*rows=*/4>, public LimitedMotion {
 public:
  bool depends_on_time() const override { return false; }
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    coincident(A, B, rows);
    const Vector3 n = A.y().cross(B.x()) - A.x().cross(B.y());
    const Vector3 n_dot = A.w.cross(A.y()).cross(B.x()) + A.y().cross(B.w.cross(B.x())) -
                          A.w.cross(A.x()).cross(B.y()) - A.x().cross(B.w.cross(B.y()));
    rows.add(A.y().dot(B.x()) - A.x().dot(B.y()), {torque(n), torque(-n)}, n_dot.dot(A.w - B.w));
  }
  /// The last row also vanishes with B twisted by half a turn: refused.
  void initialize(std::span<const MarkerView> markers) override;
  /// A run ends at a right angle. Bent by half a turn the last row would lose its gradient, and B could twist freely.
  std::optional<std::string> beyond_limit(std::span<const MarkerView> markers) const override;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<ConstantVelocityJoint>();

}  // namespace lithe
