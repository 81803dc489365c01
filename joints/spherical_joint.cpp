#include "joints/spherical_joint.h"

#include "engine/assembly/batch_of.h"

namespace lithe {

void SphericalJoint::evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const {
  coincident(markers[0], markers[1], rows);
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<SphericalJoint>();

}  // namespace lithe
