#include "joints/forces/user_force.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/error.h"

namespace lithe {

UserForce::UserForce(Parameters parameters) : parameters_(std::move(parameters)) {
  if (!parameters_.law)
    throw SceneError("it has no law", "",
                     "give a function of time and marker: {[](double t, const MarkerView& m) {...}}");
}

template std::unique_ptr<ForceBatch> make_force_batch<UserForce>();

}  // namespace lithe
