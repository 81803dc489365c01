#pragma once

#include <gtest/gtest.h>

#include "engine/model/system_graph.h"

/// What every joint and every force element owes, whatever bodies it ties: draw a scene, add the element, and check it
/// in one line. Bodies of any kind serve, so a new kind of body is checked by drawing it between the joints that exist.
///   SystemGraph graph;
///   auto& link = graph.add<RigidBody>("link", {...});
///   auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker(), link.marker()});
///   check_joint(graph, pin, {.rank = 5});
namespace lithe::test {

struct JointExpectation {
  int rank;                  // of its rows where the scene is drawn
  double tolerance = 1e-9;   // relative
  double difference = 7e-4;  // step of the differences; a smaller one for rows that bend much (angles)
};

/// At random states near the drawing:
///   - the rank of its rows is as expected, and assemble() finds it too;
///   - G is the derivative of g, g_dot = G v + ∂g/∂t that of g along a motion, G a - gamma that of g_dot; rows on
///     velocities alone have no g: their G is the derivative of g_dot by v;
///   - Gᵀ lambda does no work on velocities that the joint allows;
///   - the stiffness of the loaded joint is the derivative of Gᵀ lambda by the bodies' frames, couplings included.
void check_joint(SystemGraph& graph, const Constraint& joint, const JointExpectation& expected);

struct ForceExpectation {
  bool conservative = true;
  bool exact_damping = true;  // false: the tangent knows part of ∂f/∂v alone
  double tolerance = 1e-8;    // relative
  double difference = 7e-4;   // step of the differences
  std::size_t parts = 1;      // an element that is drawn as several: how many; `force` is the first
};

/// At random states near the drawing:
///   - at rest a conservative force is -∂V/∂q: its work is what its potential loses;
///   - moving, what it adds to that takes power away, never gives it (conservative: by damping alone);
///   - its tangent is the derivative of the force by the bodies' frames and by their velocities.
void check_force(SystemGraph& graph, const ForceElement& force, const ForceExpectation& expected = {});

/// A force element driven by the reaction of a joint, whose graph holds both. At random states and multipliers: it
/// never gives power, and the iteration matrix holds the derivatives of its tension by λ and by velocities.
void check_friction(SystemGraph& graph, const ForceElement& force, double tolerance = 1e-8);

}  // namespace lithe::test
