#include "bodies/point_mass.h"

#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/analysis/linearization.h"
#include "engine/simplify/simplification.h"
#include "joints/coordinate_drive.h"
#include "joints/distance_joint.h"
#include "joints/forces/bushing.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "joints/orientation_joint.h"
#include "joints/point_on_line_joint.h"
#include "joints/point_on_plane_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/joints/mechanisms.h"
#include "tests/reference/contact_scene.h"
#include "tests/support/body_checks.h"
#include "tests/support/joint_checks.h"

namespace lithe::test::point_mass_test {
namespace {

constexpr double kGravity = 9.81;

TEST(PointMass, OwesWhatEveryBodyOwes) {
  SystemGraph graph{{.gravity = {1, 2, -9.81}}};
  auto& mass = graph.add<PointMass>("mass", {.mass = 2.5, .position = {1, 2, 3}, .velocity = {-1, 0, 2}});
  check_body(graph, mass, {mass.marker(), mass.marker(rotation_about({1, 1, 0}, 1.1))}, {.mass = 2.5, .speed = 3});
}

/// Between a rigid body and a point mass the rows of every joint that holds its place alone are right.
TEST(PointMass, IsHeldByJointsThatActAtItsPlace) {
  const Vector3 place(0.3, 0.1, -0.2);
  const Matrix3 axes = rotation_exp(Vector3(0.4, -0.7, 0.9));
  const auto check = [&]<class T>(std::type_identity<T>, int rank, const Vector3& gap) {
    SystemGraph graph;
    auto& body = graph.add<RigidBody>("body", {.mass = 2, .inertia = {0.5, 0.6, 0.7}});
    auto& mass = graph.add<PointMass>("mass", {.mass = 0.7, .position = place + axes * gap});
    auto& joint = graph.add<T>("joint", {body.marker_at_world(place, axes), mass.marker()});
    check_joint(graph, joint, {.rank = rank});
  };
  check(std::type_identity<SphericalJoint>{}, 3, {0, 0, 0});
  check(std::type_identity<PointOnLineJoint>{}, 2, {0, 0, 0.4});
  check(std::type_identity<PointOnPlaneJoint>{}, 1, {0.1, 0.2, 0});
  check(std::type_identity<DistanceJoint>{}, 1, {0.1, 0.2, 0.4});
}

/// The methods that move every scene, at steps or tolerances that leave 1e-6 and better.
std::vector<NamedMethod> all_methods(double h) {
  std::vector<NamedMethod> all = every_method(h);
  all.push_back({"Runge-Kutta 8", runge_kutta8(1e-9)});
  all.push_back({"Adams", adams(1e-9)});
  all.push_back({"automatic", automatic(1e-9)});
  all.push_back({"Radau", radau(1e-9)});
  all.push_back({"BDF", bdf(1e-9)});
  all.push_back({"RATTLE", rattle(h)});
  all.push_back({"HHT", hht(h)});
  all.push_back({"energy-momentum", energy_momentum(h)});
  return all;
}

/// On a string of length l that leans by α it circles at Ω² = g / (l cos α); the string pulls by m g / cos α.
TEST(PointMass, CirclesAsAConicalPendulumByEveryMethod) {
  const double m = 0.4, l = 0.8, lean = 0.6, end = 0.5;
  const double speed = std::sqrt(kGravity / (l * std::cos(lean))), r = l * std::sin(lean);
  for (auto& [name, method] : all_methods(1e-4)) {
    SCOPED_TRACE(name);
    DistanceJoint* string = nullptr;
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      auto& bob = graph.add<PointMass>(
          "bob", {.mass = m, .position = {r, 0, -l * std::cos(lean)}, .velocity = {0, speed * r, 0}});
      string = &graph.add<DistanceJoint>("string", {graph.ground().marker(), bob.marker()});
    });
    EXPECT_EQ(scene.state.q.size(), 3);
    EXPECT_EQ(scene.system.degrees_of_freedom(), 2);
    scene.run(*method, end);
    const Vector3 p(r * std::cos(speed * end), r * std::sin(speed * end), -l * std::cos(lean));
    EXPECT_LT((scene.state.q - p).norm(), 1e-6);
    const Vector3 F = read_vector(scene, reaction(*string, 1));
    EXPECT_LT((F + m * kGravity / (l * std::cos(lean)) * p).norm(), 1e-4);
  }
}

/// Steps of 0.1 ms: 1.6e-4 m by the method of first order, 2e-8 m by that of second.
TEST(PointMass, CirclesByTheLinearlyImplicitMethods) {
  const double l = 0.8, lean = 0.6, speed = std::sqrt(kGravity / (l * std::cos(lean))), r = l * std::sin(lean);
  for (const auto& [order, bound] : {std::pair(1, 5e-4), std::pair(2, 1e-7)}) {
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      auto& bob = graph.add<PointMass>(
          "bob", {.mass = 0.4, .position = {r, 0, -l * std::cos(lean)}, .velocity = {0, speed * r, 0}});
      graph.add<DistanceJoint>("string", {graph.ground().marker(), bob.marker()});
    });
    scene.run(*linearly_implicit(1e-4, order), 0.5);
    const Vector3 p(r * std::cos(speed / 2), r * std::sin(speed / 2), -l * std::cos(lean));
    expect_below("linearly implicit, order " + std::to_string(order), (scene.state.q - p).norm(), bound);
  }
}

/// A small ball of no inertia on an incline: μ = 0.3 would make a solid one roll; it slides, ẍ = g (sin α - μ cos α),
/// on rigid surfaces and on compliant ones.
TEST(PointMass, SlidesAndNeverRollsOnAnIncline) {
  const double slope = M_PI / 6, mu = 0.3, end = 0.5, m = 2;
  const Matrix3 axes = rotation_about({0, 1, 0}, slope);
  const double acceleration = kGravity * (std::sin(slope) - mu * std::cos(slope));
  for (const Stepper stepper : {Stepper::moreau_jean, Stepper::generalized_alpha}) {
    ContactScene scene;
    auto& ball = scene.graph.add<PointMass>("ball", {.mass = m, .position = 0.1 * axes.col(2)});
    const auto& contact = scene.contact({scene.plane({}, axes), {ball.marker(), shape::sphere(0.1)}}, mu);
    scene.start(stepper, 1e-3);
    scene.run(end);
    const Vector3 p = 0.1 * axes.col(2) + 0.5 * acceleration * end * end * axes.col(0);
    EXPECT_LT((scene.state().q - p).norm(), 2e-3 * p.norm());
    EXPECT_LT((scene.state().v - acceleration * end * axes.col(0)).norm(), 1e-6);
    const Sensor force = contact_force(contact, 1);
    const Vector3 load(scene.read(force, 0), scene.read(force, 1), scene.read(force, 2));
    EXPECT_LT((load - m * kGravity * std::cos(slope) * (axes.col(2) - mu * axes.col(0))).norm(), 1e-6);
  }
  Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
    auto& ball = graph.add<PointMass>("ball", {.mass = m, .position = 0.1 * axes.col(2)});
    graph.add<Contact>(
        "contact", {{graph.ground().marker({}, axes), shape::half_space()}, {ball.marker(), shape::sphere(0.1)}},
        {.law = Compliance{.stiffness = 1e6, .exponent = 1, .dissipation = Dissipation::fixed, .damping = 2},
         .friction = {.coefficient = mu}});
  });
  scene.run(*runge_kutta(1e-9), end);
  EXPECT_NEAR(scene.state.q.dot(axes.col(0)), 0.5 * acceleration * end * end, 2e-3);
}

/// m ẍ = -k x - c ẋ along the spring: a damped oscillation.
TEST(PointMass, SwingsOnASpringAsAnOscillatorDoes) {
  const double m = 0.5, k = 80, c = 0.6, rest = 1, x0 = 0.2, end = 0.7;
  for (auto& [name, method] : every_method(1e-4)) {
    SCOPED_TRACE(name);
    Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
      auto& mass = graph.add<PointMass>("mass", {.mass = m, .position = {rest + x0, 0, 0}});
      graph.add<SpringDamper>("spring", {graph.ground().marker(), mass.marker()},
                              {.stiffness = k, .damping = c, .natural_length = rest});
    });
    scene.run(*method, end);
    const double d = c / (2 * m), w = std::sqrt(k / m - d * d);
    const double x = x0 * std::exp(-d * end) * (std::cos(w * end) + d / w * std::sin(w * end));
    EXPECT_NEAR(scene.state.q[0], rest + x, 1e-6);
    EXPECT_LT(scene.state.q.tail<2>().norm(), 1e-12);
  }
}

/// A bead on a wire that turns at Ω: r = r₀ cosh Ω t, pushed by 2 m Ω ṙ; the wire's shaft feels it.
TEST(PointMass, FliesOutAlongATurningWire) {
  const double m = 0.3, speed = 3, r0 = 0.2, end = 1;
  for (auto& [name, method] : every_method(2e-4)) {
    SCOPED_TRACE(name);
    PointOnLineJoint* wire = nullptr;
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      const Shaft post = draw_shaft(graph, "post", 1);
      graph.add<CoordinateDrive>("drive", {post.angle()}, {.motion = ramp(0, speed)});
      auto& bead = graph.add<PointMass>("bead", {.mass = m, .position = {r0, 0, 0}, .velocity = {0, speed * r0, 0}});
      wire = &graph.add<PointOnLineJoint>("wire",
                                          {post.body->marker({}, rotation_about({0, 1, 0}, kPi / 2)), bead.marker()});
    });
    scene.run(*method, end);
    const double r = r0 * std::cosh(speed * end), r_dot = r0 * speed * std::sinh(speed * end);
    EXPECT_NEAR(read(scene, coordinate(wire->displacement(), "r")), r, 2e-6 * r);
    const Vector3 F = read_vector(scene, joint_reaction(*wire));
    EXPECT_LT((F - Vector3(-m * kGravity, 2 * m * speed * r_dot, 0)).norm(), 1e-4);
    EXPECT_NEAR(read(scene, reaction(*wire, 0), 5), -r * 2 * m * speed * r_dot, 1e-4) << "moment on the post";
  }
}

/// Hanging, its frequency is √(g / l) in both directions: the pull of the string is its stiffness.
TEST(PointMass, HangsWithTheFrequencyOfAPendulum) {
  SystemGraph graph{{.gravity = {0, 0, -kGravity}}};
  auto& bob = graph.add<PointMass>("bob", {.mass = 0.4, .position = {0, 0, -0.8}});
  graph.add<DistanceJoint>("string", {graph.ground().marker(), bob.marker()});
  const System system = assemble(graph);
  const Linearization about = linearize(system, system.initial_state());
  ASSERT_EQ(about.modes.size(), 2u);
  for (const Mode& mode : about.modes) EXPECT_NEAR(mode.frequency(), std::sqrt(kGravity / 0.8) / (2 * kPi), 1e-7);
}

/// It stays as it is where a scene is simplified, and so does its motion.
TEST(PointMass, HangsOnAMechanismThatIsMadePlanar) {
  const Matrix3 hinge = rotation_about({1, 0, 0}, -kPi / 2);
  const auto draw = [&](SystemGraph& graph) {
    auto& arm = graph.add<RigidBody>("arm", {.mass = 1, .inertia = {0.1, 0.2, 0.2}, .position = {0.5, 0, 0}});
    auto& bob = graph.add<PointMass>("bob", {.mass = 0.4, .position = {1, 0, -0.5}, .velocity = {0, 1, 0}});
    graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, hinge), arm.marker({-0.5, 0, 0}, hinge)});
    graph.add<DistanceJoint>("string", {arm.marker({0.5, 0, 0}), bob.marker()});
  };
  Scene drawn({0, 0, -kGravity}, draw);
  drawn.run(*runge_kutta(1e-10), 0.4);

  SystemGraph graph{{.gravity = {0, 0, -kGravity}}};
  draw(graph);
  Simplification simple{graph, {.planar = true}};
  const System system = assemble(simple.graph());
  EXPECT_EQ(system.degrees_of_freedom(), 3);
  Evaluator equations(system);
  State state = simple.start(), whole;
  const Method method = runge_kutta(1e-10);
  method->start(equations, state);
  while (state.time < 0.4) ASSERT_TRUE(method->step(equations, state, 0.4).ok());
  simple.expand(state, whole);
  EXPECT_LT((whole.q - drawn.state.q).norm(), 1e-7);
}

// ---- what would turn it ----

std::string refusal_of(const std::function<void(SystemGraph&, RigidBody&, PointMass&)>& tie) {
  SystemGraph graph;
  auto& body = graph.add<RigidBody>("body");
  auto& mass = graph.add<PointMass>("bob");
  tie(graph, body, mass);
  try {
    assemble(graph);
  } catch (const SceneError& error) {
    EXPECT_NE(error.where().find("point_mass_test.cpp"), std::string::npos) << error.where();
    return error.problem();
  }
  return "taken";
}

TEST(PointMass, RefusesWhatWouldTurnIt) {
  const std::string refused = "'tie' puts a moment on 'bob', which has no axes";
  const auto joint = [&]<class T>(std::type_identity<T>, bool mass_first) {
    return refusal_of([&](SystemGraph& graph, RigidBody& body, PointMass& mass) {
      const Marker A = body.marker(), B = mass.marker();
      graph.add<T>("tie", mass_first ? std::vector{B, A} : std::vector{A, B});
    });
  };
  EXPECT_EQ(joint(std::type_identity<RevoluteJoint>{}, false), refused);
  EXPECT_EQ(joint(std::type_identity<OrientationJoint>{}, true), refused);
  EXPECT_EQ(joint(std::type_identity<PointOnLineJoint>{}, true), refused) << "the line turns with it";
  EXPECT_EQ(joint(std::type_identity<PointOnLineJoint>{}, false), "taken");
  EXPECT_EQ(joint(std::type_identity<SphericalJoint>{}, true), "taken");
  EXPECT_EQ(refusal_of([](SystemGraph& graph, RigidBody& body, PointMass& mass) {
              graph.add<Bushing>("tie", {body.marker(), mass.marker()}, {.stiffness = Matrix6::Identity()});
            }),
            refused);
  const auto user = [&](const Wrench& w) {
    return refusal_of([&](SystemGraph& graph, RigidBody&, PointMass& mass) {
      graph.add<UserForce>("tie", {mass.marker()}, {.law = [w](double, const MarkerView&) { return w; }});
    });
  };
  EXPECT_EQ(user(force({1, 2, 3})), "taken");
  EXPECT_EQ(user(torque({1, 2, 3})), refused);
}

TEST(PointMass, NeedsMassAndFiniteNumbers) {
  SystemGraph graph;
  EXPECT_THROW(graph.add<PointMass>("a", {.mass = 0}), SceneError);
  EXPECT_THROW(graph.add<PointMass>("b", {.position = {NAN, 0, 0}}), SceneError);
  EXPECT_THROW(graph.add<PointMass>("c", {.velocity = {0, INFINITY, 0}}), SceneError);
}

}  // namespace
}  // namespace lithe::test::point_mass_test
