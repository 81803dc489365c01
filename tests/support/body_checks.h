#pragma once

#include <gtest/gtest.h>

#include "engine/model/system_graph.h"

/// What every kind of body owes (HOUSE, section 10), in one line: draw one body in a graph, add what markers it has.
namespace lithe::test {

struct BodyExpectation {
  double mass;                // kg: its weight is m g
  double speed = 1;           // of random velocities, in the units of v
  double deformation = 1e-3;  // of random linear coordinates
  double dissipation = 0;     // 1: it has damping, energy may fall; 0: it is conserved
  double tolerance = 1e-8;    // relative
};

/// At random states:
///   - M is symmetric and positive definite;
///   - kinetic energy is ½ vᵀ M v;
///   - at rest, the generalized force is -∂V/∂q (virtual work of gravity and stiffness in every coordinate);
///   - the power of all forces is the rate of energy, along the motion that the body makes by itself;
///   - J and bias of each marker are the derivatives of its pose and velocity;
///   - released at rest, its centre of mass falls with g: the force by translation is m g;
///   - the tangent's velocity part, but for the modal-modal block, is the derivative of the residual; the frame's rows
///     may have nothing at all of modal velocities either (FlexibleBody::add_couplings() says why).
void check_body(SystemGraph& graph, const Body& body, const std::vector<Marker>& markers,
                const BodyExpectation& expected);

/// The tangent's position part but for the modal-modal block, where the deformation is at rest and the frame is not:
/// the derivative of the residual by differences. Newton leaves terms with the rates of deformation out.
void check_position_tangent(SystemGraph& graph, const Body& body, double speed, double deformation);

}  // namespace lithe::test
