#pragma once

#include <string>

#include "engine/assembly/evaluator.h"
#include "engine/model/state.h"

namespace lithe {

/// After a step from `from` that failed, or left a value that is not finite: the element that gives no finite numbers
/// on the way to the time `until`, in words ("'wind' (scene.cpp:12) gives ..."); empty if none is found. Looks at
/// samples of the motion that the state's velocities and accelerations tell, ever nearer to where it began, since the
/// true one is not known. What an element throws there is told likewise. Leaves the evaluator at another state.
std::string find_failing_element(Evaluator& evaluator, const State& from, double until);

}  // namespace lithe
