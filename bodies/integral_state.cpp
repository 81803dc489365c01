#include "bodies/integral_state.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

IntegralState::IntegralState(Parameters parameters) : ScalarBody(/*mass=*/1, parameters.start) {
  require::finite(parameters.start, "start");
}

template std::unique_ptr<BodyBatch> make_body_batch<IntegralState>();

}  // namespace lithe
