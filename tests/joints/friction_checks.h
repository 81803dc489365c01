#pragma once

#include "engine/model/system_graph.h"

namespace lithe::test {

/// Of a friction that may act in several directions and have states, whose graph holds its joint: at random states,
/// velocities and multipliers the iteration matrix, compliant rows eliminated, is the derivative of the residual by the
/// velocities of frames, states among them, and by the joint's multipliers.
void check_friction_tangent(SystemGraph& graph, double tolerance = 1e-6);

}  // namespace lithe::test
