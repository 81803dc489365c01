#include "joints/forces/point_force.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

PointForce::PointForce(Parameters parameters) : parameters_(parameters) {
  require::finite(parameters.force, "force");
  require::finite(parameters.torque, "torque");
  parameters.factor.require_finite("factor");
}

template std::unique_ptr<ForceBatch> make_force_batch<PointForce>();

}  // namespace lithe
