#pragma once

#include "engine/model/body.h"

namespace lithe {

/// The state in which the body is drawn. Throws SceneError for coordinates that no body can have (pairs of frames that
/// it lacks) and for a start that is not finite.
void read_initial_state(const Body& body, VectorRef q, VectorRef v);

}  // namespace lithe
