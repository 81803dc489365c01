#include "engine/assembly/evaluated.h"

#include "engine/base/error.h"

namespace lithe {

BodyState body_state(Evaluator& evaluator, const Body& body) {
  const auto& bodies = evaluator.system().graph().bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (bodies[i].body == &body) return evaluator.body_state(i);
  throw SceneError("body '" + body.name() + "' is not in this system", body.where(),
                   "use a body of the assembled graph");
}

MarkerKinematics marker_kinematics(Evaluator& evaluator, Marker marker, Level level) {
  MarkerKinematics k;
  marker.body->marker_kinematics(body_state(evaluator, *marker.body), marker.index, level, k);
  return k;
}

}  // namespace lithe
