#include "joints/point_on_line_joint.h"

#include "engine/assembly/batch_of.h"

namespace lithe {

void PointOnLineJoint::evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const {
  const auto &A = markers[0], &B = markers[1];
  in_plane(A, A.x(), B, rows);
  in_plane(A, A.y(), B, rows);
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<PointOnLineJoint>();

}  // namespace lithe
