#include <gtest/gtest.h>

#include "joints/cylindrical_joint.h"
#include "joints/forces/first_order_states.h"
#include "joints/forces/joint_bristles.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/point_force.h"
#include "joints/screw_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"
#include "tests/joints/friction_checks.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/joint_checks.h"
#include "tests/support/message_of.h"
#include "tests/support/pairs.h"

/// Friction in joints of several freedoms: sleeves, screws, balls and universal joints.
namespace lithe::test::joint_surface_test {
namespace {

constexpr double kGravity = 9.81;

TEST(JointSurface, FrictionKnowsItsDerivativesInAllDirections) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    {
      SystemGraph graph;
      auto& sleeve = graph.add<CylindricalJoint>("sleeve", pair.draw(graph, {0, 0, 0.3}));
      graph.add<JointFriction>("rub", {sleeve.angle(), sleeve.displacement()}, coarse_friction(sleeve));
      check_friction_tangent(graph);
    }
    {
      SystemGraph graph;
      auto& screw = graph.add<ScrewJoint>("screw", pair.draw(graph, {0, 0, 0.3}), {.lead = 0.2});
      graph.add<JointFriction>("rub", {screw.angle(), screw.displacement()}, coarse_friction(screw));
      check_friction_tangent(graph);
    }
    {
      SystemGraph graph;
      auto& ball = graph.add<SphericalJoint>("ball", pair.draw(graph, {0, 0, 0}));
      graph.add<JointFriction>("rub", ball.markers(), coarse_friction(ball));
      check_friction_tangent(graph);
    }
    for (const bool first : {true, false}) {
      SystemGraph graph;
      auto& cross = graph.add<UniversalJoint>("cross", pair.draw(graph, {0, 0, 0}));
      auto& rub =
          graph.add<JointFriction>("rub", {first ? cross.first_angle() : cross.second_angle()}, coarse_friction(cross));
      check_friction(graph, rub, 1e-7);
    }
  }
}

/// A sleeve that turns and slides on a level shaft: with J = m r² it slows down along a straight line of (r φ, x), by
/// μ g.
TEST(JointSurface, SleevesRubAgainstTheirHelix) {
  constexpr double kMass = 2, kRadius = 0.1, kMu = 0.2, kAlong = 0.9, kAround = 1.2, kEnd = 0.5;  // 1.5 m/s
  constexpr double kShare = 1 - kMu * kGravity * kEnd / 1.5;                                      // of the speed
  for (auto& [name, method] : every_method(1e-3)) {
    SCOPED_TRACE(name);
    const Matrix3 along = rotation_about({0, 1, 0}, kPi / 2);
    CylindricalJoint* sleeve = nullptr;
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      auto& body = graph.add<RigidBody>("body", {.mass = kMass,
                                                 .inertia = {kMass * kRadius * kRadius, 0.02, 0.02},
                                                 .velocity = {kAlong, 0, 0},
                                                 .angular_velocity = {kAround / kRadius, 0, 0}});
      sleeve = &graph.add<CylindricalJoint>("sleeve", {graph.ground().marker({}, along), body.marker({}, along)});
      graph.add<JointFriction>("rub", {sleeve->angle(), sleeve->displacement()},
                               {.joint = sleeve, .coefficient = kMu, .creep_speed = 1e-3, .radius = kRadius});
    });
    scene.run(*method, kEnd);
    EXPECT_NEAR(read(scene, coordinate_rate(sleeve->displacement(), "x")), kShare * kAlong, 1e-6);
    EXPECT_NEAR(kRadius * read(scene, coordinate_rate(sleeve->angle(), "phi")), kShare * kAround, 1e-6);
    EXPECT_NEAR(read(scene, coordinate(sleeve->displacement(), "x")), kAlong * kEnd * (1 + kShare) / 2, 1e-6);
  }
}

/// A nut of mass m and inertia J on an upright screw. Its thread presses by N and rubs by μ N along the helix of lead
/// angle λ:   m z̈ = -m g + N (cos λ + μ sin λ),   J φ̈ = r N (μ cos λ - sin λ),   z̈ = tan λ r φ̈.
struct Nut {
  static constexpr double kMass = 3, kInertia = 0.01, kRadius = 0.02;

  Nut(double tan_lead, double friction, bool bristles)
      : scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
          auto& nut = graph.add<RigidBody>("nut", {.mass = kMass, .inertia = {0.01, 0.01, kInertia}});
          screw = &graph.add<ScrewJoint>("screw", {graph.ground().marker(), nut.marker()},
                                         {.lead = 2 * kPi * kRadius * tan_lead});
          const std::vector<JointCoordinate> helix{screw->angle(), screw->displacement()};
          if (bristles)
            add_joint_bristles(
                graph, "rub", helix, graph.add<FirstOrderStates>("bristles", {.start = JointBristles::start()}),
                {.joint = screw, .coefficient = friction, .breakaway_deflection = 1e-8, .radius = kRadius});
          else
            graph.add<JointFriction>("rub", helix,
                                     {.joint = screw, .coefficient = friction, .creep_speed = 1e-6, .radius = kRadius});
        }) {}
  static double acceleration(double tan_lead, double mu) {
    const double c = 1 / std::hypot(1, tan_lead), s = tan_lead * c, up = c + mu * s, turn = mu * c - s;
    const double N = kMass * kGravity / (up - kMass * kRadius * kRadius * tan_lead / kInertia * turn);
    return -kGravity + N * up / kMass;
  }

  ScrewJoint* screw = nullptr;
  Scene scene;
};

TEST(JointSurface, NutsRunDownSteepScrewsAndHoldOnFlatOnes) {
  constexpr double kSteep = 0.5, kFlat = 0.19, kMu = 0.2, kEnd = 1;
  const double a = Nut::acceleration(kSteep, kMu);
  EXPECT_LT(std::abs(a), 0.7 * std::abs(Nut::acceleration(kSteep, 0))) << "friction counts";
  for (const bool bristles : {false, true}) {
    SCOPED_TRACE(bristles ? "bristles" : "regularised");
    Nut steep(kSteep, kMu, bristles);
    Method method = radau(1e-9);
    steep.scene.run(*method, kEnd);
    EXPECT_NEAR(read(steep.scene, coordinate(steep.screw->displacement(), "z")), a * kEnd * kEnd / 2, 3e-5);
  }
  Nut flat(kFlat, kMu, true);
  Method method = radau(1e-9);
  flat.scene.run(*method, 5);
  const double settled = read(flat.scene, coordinate(flat.screw->displacement(), "z"));
  EXPECT_NEAR(settled, 0, 1e-6);
  flat.scene.run(*method, 65);
  EXPECT_NEAR(read(flat.scene, coordinate(flat.screw->displacement(), "z")), settled, 1e-9);
}

/// A ball that spins about a slanted axis, held at its centre: J ω̇ = -r μ m g along its axis, until it rests.
TEST(JointSurface, BallsSlowDownAboutTheirOwnAxis) {
  constexpr double kMass = 2, kInertia = 0.03, kRadius = 0.05, kMu = 0.3, kSpin = 7, kEnd = 0.4;
  const Vector3 axis = Vector3(1, 2, -2) / 3;
  const double slowed = kSpin - kRadius * kMu * kMass * kGravity / kInertia * kEnd;
  ASSERT_GT(slowed, 0);
  for (const bool bristles : {false, true}) {
    SCOPED_TRACE(bristles ? "bristles" : "regularised");
    RigidBody* body = nullptr;
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      body = &graph.add<RigidBody>(
          "body",
          {.mass = kMass, .inertia = {kInertia, kInertia, kInertia}, .angular_velocity = Vector3(kSpin * axis)});
      auto& ball = graph.add<SphericalJoint>("ball", {graph.ground().marker(), body->marker()});
      if (bristles)
        add_ball_bristles(graph, "rub",
                          graph.add<FirstOrderStates>("bristles", {.start = JointBristles::start(kMass * kGravity)}),
                          {.joint = &ball, .coefficient = kMu, .radius = kRadius});
      else
        graph.add<JointFriction>("rub", ball.markers(),
                                 {.joint = &ball, .coefficient = kMu, .creep_speed = 1e-4, .radius = kRadius});
    });
    const Method method = radau(1e-9);
    scene.run(*method, kEnd);
    const Vector3 w = read_vector(scene, angular_velocity(body->marker(), "w"));
    EXPECT_NEAR(w.dot(axis), slowed, bristles ? 2e-3 : 1e-6);
    EXPECT_LT(w.cross(axis).norm(), 1e-6);
    if (!bristles) continue;
    scene.run(*method, 5);
    EXPECT_LT(read_vector(scene, angular_velocity(body->marker(), "w")).norm(), 1e-8);
  }
}

TEST(JointSurface, BadInputNamesWhatIsWrong) {
  SystemGraph graph;
  auto& body = graph.add<RigidBody>("body", {});
  auto& sleeve = graph.add<CylindricalJoint>("sleeve", {graph.ground().marker(), body.marker()});
  auto& states = graph.add<FirstOrderStates>("states", {.start = JointBristles::start()});
  const auto says = [&](const std::vector<JointCoordinate>& coordinates, const JointBristles::Parameters& p,
                        const std::string& word) {
    expect_says(message_of<SceneError>([&] { add_joint_bristles(graph, "bad", coordinates, states, p); }),
                {"'bad'", word});
  };
  const JointBristles::Parameters good{.joint = &sleeve, .coefficient = 0.3, .radius = 0.1};
  auto p = good;
  says({sleeve.displacement(), sleeve.angle()}, p, "an angle and the displacement along its axis");
  says({sleeve.angle(), displacement_between(sleeve.markers()[0], sleeve.markers()[1], 0)}, p, "along its axis");
  p = good, p.radius = 0, says({sleeve.angle()}, p, "radius");
  p = good, p.joint = nullptr, says({sleeve.angle()}, p, "names no joint");
  p = good, p.coefficient = 0, says({sleeve.angle()}, p, "coefficient");
  p = good, p.static_coefficient = 0.2, says({sleeve.angle()}, p, "below coefficient");
  p = good, p.breakaway_deflection = 0, says({sleeve.angle()}, p, "breakaway_deflection");
  p = good, p.elastic_share = 1, says({sleeve.angle()}, p, "elastic_share");
  p = good, p.damping_time = -1, says({sleeve.angle()}, p, "damping_time");
  p = good, p.load_time = 0, says({sleeve.angle()}, p, "load_time");
  auto& few = graph.add<FirstOrderStates>("few", {.start = VectorX::Zero(3)});
  expect_says(message_of<SceneError>([&] { add_joint_bristles(graph, "bad", {sleeve.angle()}, few, good); }),
              {"'bad'", "'few'"});
}

}  // namespace
}  // namespace lithe::test::joint_surface_test
