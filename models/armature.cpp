#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "models/armature_internal.h"

namespace lithe {

Armature::Armature(Parameters parameters) : ScalarBody(parameters.inertia, parameters.rate) {
  require::positive(parameters.inertia, "armature");
  require::finite(parameters.rate, "rate");
}

template std::unique_ptr<BodyBatch> make_body_batch<Armature>();

}  // namespace lithe
