#pragma once

#include "engine/model/system_graph.h"
#include "joints/forces/joint_friction.h"

namespace lithe::test {

/// Of a friction that may act in several directions and have states, whose graph holds its joint: at random states,
/// velocities and multipliers the iteration matrix, compliant rows eliminated, is the derivative of the residual by the
/// velocities of frames, states among them, and by the joint's multipliers.
void check_friction_tangent(SystemGraph& graph, double tolerance = 1e-6);

/// Friction so coarse that differences see all of its law.
inline JointFriction::Parameters coarse_friction(const Constraint& joint) {
  return {.joint = &joint,
          .coefficient = 0.2,
          .static_coefficient = 0.3,
          .stribeck_speed = 2,
          .creep_speed = 3,
          .viscous = 0.1,
          .radius = 0.4,
          .bending_arm = 0.6,
          .preload = 2};
}

}  // namespace lithe::test
