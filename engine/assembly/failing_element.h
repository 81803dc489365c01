#pragma once

#include <string>

#include "engine/assembly/evaluator.h"
#include "engine/model/state.h"

namespace lithe {

/// After a step from `from` that failed, or left a value that is not finite: the element that gives no finite numbers
/// on the way to the time `until`, in words ("'wind' (scene.cpp:12) gives ..."); empty if none is found. Looks at
/// samples of the motion predicted from the state's velocities and accelerations, ever closer to where it began, since
/// the true motion is not known. Reports what an element throws there, too. Leaves the evaluator at another state.
std::string find_failing_element(Evaluator& evaluator, const State& from, double until);

/// Where a step failed, or steps have become too short for time to tell: the angle of a connector that is lost in this
/// state, since what it measures lies along the axis that it turns about, in words; empty if there is none.
std::string find_lost_angle(Evaluator& evaluator, const State& state);

}  // namespace lithe
