#include "joints/point_on_plane_joint.h"

#include "engine/assembly/batch_of.h"

namespace lithe {

void PointOnPlaneJoint::evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const {
  in_plane(markers[0], markers[0].z(), markers[1], rows);
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<PointOnPlaneJoint>();

}  // namespace lithe
