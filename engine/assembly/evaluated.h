#pragma once

#include "engine/assembly/evaluator.h"

/// What bodies and markers do at the state that an evaluator evaluated last, of those too that no connector uses.
namespace lithe {

/// Throws SceneError for a body of another graph.
BodyState body_state(Evaluator& evaluator, const Body& body);

/// `level`: no higher than that of the evaluation.
MarkerKinematics marker_kinematics(Evaluator& evaluator, Marker marker, Level level);

}  // namespace lithe
