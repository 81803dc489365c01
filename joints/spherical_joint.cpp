#include "joints/spherical_joint.h"

#include "engine/assembly/batch_of.h"

namespace lithe {
template std::unique_ptr<ConstraintBatch> make_constraint_batch<SphericalJoint>();
}
