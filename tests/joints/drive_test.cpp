#include <gtest/gtest.h>

#include "engine/analysis/kinematics.h"
#include "integrators/generalized_alpha.h"
#include "joints/coordinate_drive.h"
#include "joints/cylindrical_joint.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/point_force.h"
#include "joints/universal_joint.h"
#include "tests/joints/mechanisms.h"

/// Drives, and coordinates that count their turns.
namespace lithe::test::drive_test {
namespace {

constexpr double kInertia = 0.3;
const Matrix3 kTilted = rotation_exp(Vector3(0.3, -0.8, 0.5));

/// A shaft follows each law, and the drive needs J φ̈.
TEST(CoordinateDrive, TurnsAShaftByEachLawWithTheTorqueThatItNeeds) {
  const std::vector<std::pair<std::string, MotionLaw>> laws = {
      {"constant", constant(0.4)},
      {"ramp", ramp(0.3, -5)},
      {"harmonic", harmonic(0.8, 4, 0.3, 0.1)},
      {"smooth step", smooth_step(0.2, 9, 0.1, 0.9)},
      {"tabulated", tabulated({0, 0.2, 0.5, 0.8, 1.5}, {0.1, 0.5, -0.3, 0.2, 2})},
      {"sum", ramp(0, 20) + harmonic(0.5, 6)},
  };
  for (const auto& [law_name, law] : laws)
    for (auto& [name, method] : every_method(1e-3, 1e-8)) {
      SCOPED_TRACE(law_name + ", " + name);
      Shaft shaft;
      CoordinateDrive* drive;
      Scene scene({0, 0, 0}, [&, &motion = law](SystemGraph& graph) {
        shaft = draw_shaft(graph, "shaft", kInertia, {1, 2, 3}, kTilted);
        drive = &graph.add<CoordinateDrive>("drive", {shaft.angle()}, {.motion = motion});
      });
      for (double t : {0.35, 0.7}) {
        scene.run(*method, t);
        const Motion expected = law(t);
        EXPECT_NEAR(read(scene, coordinate(shaft.angle(), "phi")), expected.value, 1e-7) << t;
        EXPECT_NEAR(read(scene, coordinate_rate(shaft.angle(), "phi")), expected.rate,
                    1e-4 * (1 + std::abs(expected.rate)))
            << t;
        EXPECT_NEAR(read(scene, drive_force(*drive)), kInertia * expected.acceleration,
                    1e-3 * (1 + std::abs(kInertia * expected.acceleration)))
            << t;
        EXPECT_NEAR(read(scene, power(*drive)), kInertia * expected.acceleration * expected.rate,
                    2e-3 * (1 + std::abs(kInertia * expected.acceleration * expected.rate)))
            << t;
      }
    }
}

TEST(JointCoordinates, CountTheTurnsOfAFreeShaftEitherWay) {
  for (double speed : {60.0, -60.0})
    for (auto& [name, method] : every_method(5e-3)) {
      SCOPED_TRACE(name);
      Shaft shaft;
      Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
        shaft = draw_shaft(graph, "shaft", kInertia, {1, 2, 3}, kTilted, speed);
      });
      scene.run(*method, 10);
      EXPECT_NEAR(read(scene, coordinate(shaft.angle(), "phi")), 10 * speed, 1e-5);  // 95 turns
      EXPECT_NEAR(read(scene, coordinate(-shaft.angle(), "phi")), -10 * speed, 1e-5);
      EXPECT_NEAR(read(scene, coordinate_rate(-shaft.angle(), "phi")), -speed, 1e-8);
    }
}

/// A polynomial motion lets automatic steps grow without bound; turns are counted all the same, at steady speed and
/// from rest.
TEST(JointCoordinates, AreNotOutrunByAutomaticSteps) {
  for (const auto& [speed, torque] : {std::pair(50.0, 0.0), {0.0, 1.5}, {-30.0, 0.9}}) {
    std::vector<NamedMethod> loose;
    loose.push_back({"Runge-Kutta", runge_kutta(1e-4)});
    loose.push_back({"IDA", ida(1e-5)});
    loose.push_back({"automatic index 3",
                     std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.tolerance = {1e-4, 1e-4}})});
    for (auto& [name, method] : loose) {
      SCOPED_TRACE(name);
      Shaft shaft;
      Scene scene({0, 0, 0}, [&, &initial = speed, &T = torque](SystemGraph& graph) {
        shaft = draw_shaft(graph, "shaft", kInertia, {1, 2, 3}, kTilted, initial);
        graph.add<PointForce>("torque", {shaft.body->marker()},
                              {.torque = {0, 0, T}, .axes = PointForce::Axes::marker});
      });
      scene.run(*method, 20);
      const double phi = speed * 20 + 0.5 * torque / kInertia * 400;
      EXPECT_NEAR(read(scene, coordinate(shaft.angle(), "phi")), phi, 0.5);
    }
  }
}

/// What is drawn counts as it is seen; turns count from there, past half a turn from the first step.
TEST(JointCoordinates, StartFromTheDrawingWithinHalfATurn) {
  for (double drawn : {3.1, -3.1, 0.0, 1.5707}) {
    CylindricalJoint* sleeve;
    Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
      const Matrix3 turned = rotation_about({0, 0, 1}, drawn);
      auto& body = graph.add<RigidBody>("body", {.orientation = turned, .angular_velocity = {0, 0, 2}});
      sleeve = &graph.add<CylindricalJoint>("sleeve", {graph.ground().marker(), body.marker()});
    });
    EXPECT_NEAR(read(scene, coordinate(sleeve->angle(), "phi")), drawn, 1e-12);
    const Method method = index2(1e-2);
    scene.run(*method, 1);
    EXPECT_NEAR(read(scene, coordinate(sleeve->angle(), "phi")), drawn + 2, 1e-9);
  }
}

/// Spring over several turns: J φ̈ = -k φ, amplitude 20 rad, as long a period as for small ones.
TEST(CoordinateSpring, IsAClockSpringOverSeveralTurns) {
  const double omega = 2, amplitude = 20, period = 2 * kPi / omega;
  for (auto& [name, method] : every_method(2e-4)) {
    SCOPED_TRACE(name);
    Shaft shaft;
    CoordinateSpring* spring;
    Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
      shaft = draw_shaft(graph, "shaft", kInertia, {0, 0, 0}, kTilted, amplitude * omega);
      spring = &graph.add<CoordinateSpring>("spring", {shaft.angle()}, {.stiffness = kInertia * omega * omega});
    });
    const double whole = scene.energy();
    for (double part : {0.125, 0.25, 0.6, 0.75, 1.0}) {
      scene.run(*method, part * period);
      const double phi = amplitude * std::sin(2 * kPi * part);
      EXPECT_NEAR(read(scene, coordinate(shaft.angle(), "phi")), phi, 1e-5) << part;
      EXPECT_NEAR(read(scene, potential_energy(*spring)), 0.5 * kInertia * omega * omega * phi * phi, 1e-3) << part;
      EXPECT_NEAR(read(scene, power(*spring)),
                  -kInertia * omega * omega * phi * amplitude * omega * std::cos(2 * kPi * part), 5e-3)
          << part;
      EXPECT_NEAR(scene.energy(), whole, 1e-5 * whole) << part;
    }
  }
}

/// Both angles of a cross, driven: the pose is the turn about x_A and then about y_B.
TEST(UniversalJoint, IsPosedByItsTwoAngles) {
  RigidBody* body;
  Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
    body = &graph.add<RigidBody>("body", {});
    auto& cross = graph.add<UniversalJoint>("cross", {graph.ground().marker(), body->marker()});
    graph.add<CoordinateDrive>("first", {cross.first_angle()}, {.motion = ramp(0, 0.5)});
    graph.add<CoordinateDrive>("second", {cross.second_angle()}, {.motion = ramp(0, -0.7)});
  });
  const Method method = index2(1e-2);
  scene.run(*method, 1);
  const Matrix3 expected = rotation_about({1, 0, 0}, 0.5) * rotation_about({0, 1, 0}, -0.7);
  EXPECT_LT((rotation_matrix(scene.state.q.segment<4>(3)) - expected).norm(), 1e-9);
}

}  // namespace
}  // namespace lithe::test::drive_test
