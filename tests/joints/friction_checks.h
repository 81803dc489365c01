#pragma once

#include "engine/model/system_graph.h"

namespace lithe::test {

/// Of a friction that may act in several directions and have states: at random states, velocities and multipliers the
/// iteration matrix, compliant rows eliminated, is the derivative of the residual by the bodies' frames, states among
/// them, and by the joint's multipliers. The followed load of JointBristles is N, as in a scene that has run for a while.
void check_friction_tangent(SystemGraph& graph, const ForceElement& force, double tolerance = 1e-6);

}  // namespace lithe::test
