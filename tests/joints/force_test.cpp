#include <gtest/gtest.h>

#include <cmath>

#include "bodies/rigid_body.h"
#include "engine/assembly/evaluator.h"
#include "joints/forces/point_force.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "tests/support/joint_checks.h"
#include "tests/support/pairs.h"

namespace lithe::test::force_test {
namespace {

const Vector3 kGap(0.3, 0.5, -0.4);

TEST(SpringDamper, PullsByWhatItsPotentialLosesAndDampsAlone) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    const std::vector<Marker> markers = pair.draw(graph, kGap);
    auto& spring = graph.add<SpringDamper>("spring", markers,
                                           {.stiffness = 40, .damping = 3, .natural_length = 0.5, .preload = 2});
    check_force(graph, spring);
  }
}

TEST(SpringDamper, OscillatesAtTheRootOfStiffnessOverMass) {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  auto& ball = graph.add<RigidBody>("ball", {.mass = 2, .position = {1.5, 0, 0}});
  auto& spring = graph.add<SpringDamper>("spring", {graph.ground().marker(), ball.marker()},
                                         {.stiffness = 50, .natural_length = 1});
  const System system = assemble(graph);
  EXPECT_NEAR(system.initial_state().v_dot[0], -50 * 0.5 / 2, 1e-12);  // ẍ = -ω² x, ω² = k/m
  Evaluator evaluator(system);
  evaluator.evaluate(0, system.initial_state().q, system.initial_state().v, Level::velocity);
  EXPECT_NEAR(evaluator.energy().elastic, 0.5 * 50 * 0.25, 1e-12);
  EXPECT_EQ(spring.natural_length(), 1);
}

TEST(SpringDamper, IsAtRestAsDrawnIfNoLengthIsGiven) {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  auto& ball = graph.add<RigidBody>("ball", {.position = {3, 4, 0}});
  auto& spring = graph.add<SpringDamper>("spring", {graph.ground().marker(), ball.marker()}, {.stiffness = 50});
  const System system = assemble(graph);
  EXPECT_DOUBLE_EQ(spring.natural_length(), 5);
  EXPECT_LT(system.initial_state().v_dot.norm(), 1e-12);
}

/// Where its ends meet, a spring has no direction: its force is zero, not undefined.
TEST(SpringDamper, MayShrinkToAPoint) {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  auto& ball = graph.add<RigidBody>("ball");
  graph.add<SpringDamper>("spring", {graph.ground().marker(), ball.marker()}, {.stiffness = 50, .natural_length = 0});
  EXPECT_EQ(assemble(graph).initial_state().v_dot.norm(), 0);
}

TEST(PointForce, IsDeadInTheWorldOrFollowsTheMarker) {
  for (const auto axes : {PointForce::Axes::world, PointForce::Axes::marker}) {
    for (const auto& draw : {draw_rigid, +[](SystemGraph&graph, const std::string&name, const Vector3&p,
                                             const Matrix3&R) { return draw_modal(graph, name, p, R); }}) {
      SystemGraph graph{{.gravity = Vector3::Zero()}};
      const Marker marker = draw(graph, "body", {0.2, 0.3, 0.4}, rotation_exp(Vector3(1, 0.3, -0.4)));
      const bool dead = axes == PointForce::Axes::world;
      auto& thrust = graph.add<PointForce>(
          "thrust", {marker},
          {.force = {1, 2, 3}, .torque = dead ? Vector3(0, 0, 0) : Vector3(0.5, 0, 1), .axes = axes});
      check_force(graph, thrust, {.conservative = dead});
    }
  }
}

TEST(PointForce, PushesAndTurnsAboutTheCentreOfMass) {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  const Matrix3 A = rotation_about({0, 0, 1}, M_PI / 2);  // body x is world y
  auto& body = graph.add<RigidBody>("body", {.mass = 2, .inertia = {2, 3, 4}, .orientation = A});
  graph.add<PointForce>("thrust", {body.marker({0, 3, 0})}, {.force = {8, 0, 0}, .axes = PointForce::Axes::marker});
  const VectorX v_dot = assemble(graph).initial_state().v_dot;
  EXPECT_LT((v_dot.head<3>() - Vector3(0, 4, 0)).norm(), 1e-12);   // F / m, world axes
  EXPECT_LT((v_dot.tail<3>() - Vector3(0, 0, -6)).norm(), 1e-12);  // J⁻¹ (r × F), body axes
}

TEST(UserForce, FollowsItsLawOfTimeAndMotion) {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  auto& body = graph.add<RigidBody>("body", {.mass = 2, .velocity = {0, 3, 0}});
  auto& wind = graph.add<UserForce>("wind", {body.marker()}, {[](double time, const MarkerView& m) {
                                      return force(Vector3(std::cos(time), 0, m.p.z()) - 0.5 * m.v);
                                    }});
  EXPECT_LT((assemble(graph).initial_state().v_dot.head<3>() - Vector3(0.5, -0.75, 0)).norm(), 1e-12);
  check_force(graph, wind, {.conservative = false});
}

}  // namespace
}  // namespace lithe::test::force_test
