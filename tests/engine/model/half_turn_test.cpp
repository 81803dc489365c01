// Angles of exactly half a turn as drawn: round-off gives them either sign, and nothing may follow from which.
#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/run/simulation.h"
#include "engine/simplify/simplification.h"
#include "integrators/explicit_runge_kutta.h"
#include "joints/gear_pair.h"
#include "joints/revolute_joint.h"

namespace lithe::test::half_turn_test {
namespace {

constexpr double kRadiusA = 0.2, kRadiusB = 0.3;

/// Two gears in a frame that is turned by R, the first one spinning. From B's centre A's is seen half a turn from x.
void draw_gears(SystemGraph& graph, const Matrix3& R) {
  const Vector3 inertia(0.01, 0.012, 0.015), center = R * Vector3(kRadiusA + kRadiusB, 0, 0);
  auto& a = graph.add<RigidBody>(
      "a",
      {.inertia = inertia, .orientation = R * rotation_about({0, 0, 1}, 0.2), .angular_velocity = {0, 0, kRadiusB}});
  auto& b = graph.add<RigidBody>("b", {.inertia = inertia,
                                       .position = center + R * Vector3(0, 0, 0.1),
                                       .orientation = R * rotation_about({0, 0, 1}, -0.3),
                                       .angular_velocity = {0, 0, -kRadiusA}});
  const auto at = [&](RigidBody& body, const Vector3& place) {
    const auto& p = body.parameters();
    return body.marker(p.orientation.transpose() * (place - p.position), p.orientation.transpose() * R);
  };
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, R), at(a, {0, 0, 0})});
  graph.add<RevoluteJoint>("axle", {graph.ground().marker(center, R), at(b, center)});
  graph.add<GearPair>("teeth", {at(a, {0, 0, 0}), at(b, center)}, {.radius_A = kRadiusA, .radius_B = kRadiusB});
}

void expect_meshed(const System& system, State state, int spin_a, int spin_b, const std::string& what) {
  const VectorX drawn = state.v;
  ExplicitRungeKutta method({.step = 1e-3});
  Simulation(system, method).run(state, 0.05);
  EXPECT_NEAR(state.v[spin_a], drawn[spin_a], 1e-9) << what;
  EXPECT_NEAR(state.v[spin_b], drawn[spin_b], 1e-9) << what;
}

TEST(HalfTurn, GearsDrawnInAnyDirectionMeshInSpaceAndInTheirPlane) {
  // Without forces both spin on, in the ratio of the radii. A half turn that the joint counts one way and the engine
  // the other puts the teeth off by a whole turn. Of these directions some dozen give each sign.
  for (int k = 0; k < 60; ++k) {
    const std::string what = "direction " + std::to_string(k);
    const Matrix3 R = rotation_about({1, 0.3 * k, 2}, 0.37 * k);
    SystemGraph graph({.gravity = {0, 0, 0}});
    draw_gears(graph, R);
    Simplification simple(graph);
    const System small = assemble(simple.graph());
    ASSERT_EQ(small.layout().v_count(), 6) << what;
    EXPECT_NO_THROW(expect_meshed(simple.whole(), simple.whole().initial_state(), 5, 11, what + ", in space")) << what;
    EXPECT_NO_THROW(expect_meshed(small, simple.start(), 2, 5, what + ", in the plane")) << what;
  }
}

}  // namespace
}  // namespace lithe::test::half_turn_test
