#include "joints/spherical_joint.h"

#include "engine/batch_of.h"

namespace lithe {
template std::unique_ptr<ConstraintBatch> make_constraint_batch<SphericalJoint>();
}
