#include "joints/point_on_line_joint.h"

#include "engine/assembly/batch_of.h"

namespace lithe {

template std::unique_ptr<ConstraintBatch> make_constraint_batch<PointOnLineJoint>();

}  // namespace lithe
