#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/joint_coordinate.h"

namespace lithe {

/// Pin of a planar mechanism: the markers share their place in the plane normal to z_A, and nothing else is held. In a
/// mechanism whose bodies other joints keep in the plane it closes a loop without the rows of a hinge that repeat
/// theirs.
///   g = (x_A · d, y_A · d), d = p_B - p_A, two rows: those of a point on a line.
class PlanarPinJoint final : public Joint</*markers=*/2, /*rows=*/2> {
 public:
  /// From x_A to x_B about z_A.
  JointCoordinate angle() const { return {JointCoordinate::Kind::angle, markers()[0], markers()[1]}; }
  std::vector<MeasuredAngle> angles() const override { return {{0, 1, 2}}; }
  bool depends_on_time() const override { return false; }
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    in_plane(A, A.x(), B, rows);
    in_plane(A, A.y(), B, rows);
  }
  /// Refuses z axes that point apart: the bodies would not move in one plane.
  void initialize(std::span<const MarkerView> markers) override;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<PlanarPinJoint>();

}  // namespace lithe
