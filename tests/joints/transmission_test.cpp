#include <gtest/gtest.h>

#include "engine/analysis/kinematics.h"
#include "joints/constant_velocity_joint.h"
#include "joints/coordinate_coupling.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/point_force.h"
#include "joints/gear_pair.h"
#include "joints/point_on_line_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/rack_and_pinion.h"
#include "joints/screw_joint.h"
#include "joints/universal_joint.h"
#include "tests/joints/mechanisms.h"

/// Joints that pass motion on, against the motion that their geometry prescribes.
namespace lithe::test::transmission_test {
namespace {

constexpr double kBend = 40 * kPi / 180, kSpeed = 3, kLoad = 5, kInertia = 0.4;

/// Two shafts that meet in the origin, the second bent by 40 degrees about x and braked by kLoad.
template <class T>
struct BentShafts : Scene {
  explicit BentShafts(CoordinateDrive*& drive, JointCoordinate& out)
      : Scene({0, 0, 0}, [&](SystemGraph& graph) {
          const Matrix3 bent = rotation_about({1, 0, 0}, kBend);
          const Shaft in = draw_shaft(graph, "in", 0.3, {0, 0, -0.3});
          const Vector3 center = bent * Vector3(0, 0, 0.3);
          auto& shaft = graph.add<RigidBody>(
              "out", {.mass = 1, .inertia = {0.3, 0.3, kInertia}, .position = center, .orientation = bent});
          graph.add<T>("joint", {in.body->marker({0, 0, 0.3}), shaft.marker({0, 0, -0.3})});
          const Marker bearing = graph.ground().marker(center, bent);
          graph.add<PointOnLineJoint>("bearing", {bearing, shaft.marker({0, 0, 0.2})});
          graph.add<PointForce>("brake", {shaft.marker()},
                                {.torque = {0, 0, -kLoad}, .axes = PointForce::Axes::marker});
          drive = &graph.add<CoordinateDrive>("drive", {in.angle()}, {.motion = ramp(0, kSpeed)});
          out = angle_between(bearing, shaft.marker());
        }) {}
};

TEST(ConstantVelocityJoint, TurnsBothShaftsAlikeAtAnyBend) {
  CoordinateDrive* drive;
  JointCoordinate out;
  BentShafts<ConstantVelocityJoint> scene(drive, out);
  EXPECT_EQ(scene.system.rank(), scene.system.layout().row_count());
  const Method method = index2(5e-3);
  for (double t = 0.25; t < 3; t += 0.25) {
    scene.run(*method, t);
    EXPECT_NEAR(std::remainder(read(scene, coordinate(out, "out")) - kSpeed * t, 2 * kPi), 0, 1e-10) << t;
    EXPECT_NEAR(read(scene, coordinate_rate(out, "out")), kSpeed, 1e-9) << t;
    EXPECT_NEAR(read(scene, drive_force(*drive)), kLoad, 1e-8) << t;
  }
}

/// The arm of the bent shaft moves by tan φ₂ = cos β tan φ₁, its speed fluctuates by that, and so does the torque.
TEST(UniversalJoint, FluctuatesTwiceATurn) {
  CoordinateDrive* drive;
  JointCoordinate out;
  BentShafts<UniversalJoint> scene(drive, out);
  const Method method = index2(1e-3);
  const double c = std::cos(kBend);
  for (double t = 0.25; t < 3; t += 0.25) {
    scene.run(*method, t);
    const double phi = kSpeed * t, expected = std::atan2(c * std::sin(phi), std::cos(phi));
    const double D = std::pow(std::cos(phi), 2) + std::pow(c * std::sin(phi), 2);
    const double ratio = c / D, ratio_rate = c * (1 - c * c) * std::sin(2 * phi) / (D * D) * kSpeed;
    EXPECT_NEAR(std::remainder(read(scene, coordinate(out, "out")) - expected, 2 * kPi), 0, 1e-10) << t;
    EXPECT_NEAR(read(scene, coordinate_rate(out, "out")), ratio * kSpeed, 1e-9) << t;
    EXPECT_NEAR(read(scene, drive_force(*drive)), ratio * (kLoad + kInertia * ratio_rate * kSpeed), 1e-4) << t;
  }
}

/// A torque T lifts a nut of mass m: φ̈ = (T - m g r) / (J + m r²), r the rise a radian; over many turns.
TEST(ScrewJoint, LiftsANutAsTheEquivalentInertiaSays) {
  const double m = 3, J = 0.02, lead = 0.05, rise = lead / (2 * kPi), g = 9.81, T = 0.9;
  const double acceleration = (T - m * g * rise) / (J + m * rise * rise);
  for (double sense : {1.0, -1.0})
    for (auto& [name, method] : every_method(1e-3)) {
      SCOPED_TRACE(name);
      ScrewJoint* screw;
      Scene scene({0, 0, -g}, [&](SystemGraph& graph) {
        auto& nut = graph.add<RigidBody>("nut", {.mass = m, .inertia = {0.1, 0.1, J}, .position = {0, 0, 0.2}});
        screw = &graph.add<ScrewJoint>("screw", {graph.ground().marker(), nut.marker()}, {.lead = sense * lead});
        graph.add<PointForce>("torque", {nut.marker()}, {.torque = {0, 0, sense * T}});
      });
      scene.run(*method, 2.5);
      const double phi = 0.5 * acceleration * 2.5 * 2.5;
      EXPECT_GT(phi, 10 * 2 * kPi);
      EXPECT_NEAR(sense * read(scene, coordinate(screw->angle(), "phi")), phi, 1e-6 * phi);
      EXPECT_NEAR(read(scene, coordinate(screw->displacement(), "z")),
                  0.2 + sense * rise * read(scene, coordinate(screw->angle(), "phi")), 1e-9);
      EXPECT_LT(scene.violation(Level::position), 1e-8);
    }
}

TEST(RackAndPinion, MovesTheRackByItsPitchCircleAndPushesInThePitchPoint) {
  const double m = 3, J = 0.1, r = 0.2, T = 1.5, acceleration = T / (J + m * r * r);
  for (auto& [name, method] : every_method(1e-3)) {
    SCOPED_TRACE(name);
    Shaft pinion;
    RackAndPinion* mesh;
    PrismaticJoint* slide;
    Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
      const Matrix3 along_x = rotation_about({0, 1, 0}, kPi / 2);  // z of the slide is world x
      pinion = draw_shaft(graph, "pinion", J);
      auto& rack = graph.add<RigidBody>("rack", {.mass = m, .position = {0.1, -r, 0}});
      slide =
          &graph.add<PrismaticJoint>("slide", {graph.ground().marker({0, -r, 0}, along_x), rack.marker({}, along_x)});
      mesh = &graph.add<RackAndPinion>("mesh", {pinion.body->marker(), rack.marker()}, {.radius = r});
      graph.add<PointForce>("torque", {pinion.body->marker()}, {.torque = {0, 0, T}});
    });
    scene.run(*method, 2.5);
    const double phi = 0.5 * acceleration * 2.5 * 2.5, F = m * r * acceleration;
    EXPECT_GT(phi, 3 * 2 * kPi);
    EXPECT_NEAR(read(scene, coordinate(pinion.angle(), "phi")), phi, 1e-6 * phi);
    EXPECT_NEAR(read(scene, coordinate(slide->displacement(), "x")), 0.1 + r * phi, 1e-6 * phi);
    // On the rack F along x; in line with its marker, so no moment. The pinion's bearing takes the opposite push.
    EXPECT_LT((read_vector(scene, reaction(*mesh, 1)) - Vector3(F, 0, 0)).norm(), 1e-5 * F);
    EXPECT_LT(read_vector(scene, reaction(*mesh, 1), 3).norm(), 1e-5 * F);
    EXPECT_LT((read_vector(scene, reaction(*mesh, 0), 3) - Vector3(0, 0, -F * r)).norm(), 1e-5 * F);
    EXPECT_LT((read_vector(scene, reaction(*pinion.pin, 1)) - Vector3(F, 0, 0)).norm(), 1e-5 * F);
  }
}

TEST(GearPair, TurnsInverselyToTheRadiiAndLoadsTheBearings) {
  const double r1 = 0.1, r2 = 0.25, J1 = 0.02, J2 = 0.3, T = 0.8;
  for (double ring : {1.0, -1.0})  // a ring gear turns the same way
    for (auto& [name, method] : every_method(1e-3)) {
      SCOPED_TRACE(name);
      Shaft first, second;
      GearPair* mesh;
      Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
        first = draw_shaft(graph, "first", J1);
        second = draw_shaft(graph, "second", J2, {r1 + ring * r2, 0, 0});
        mesh = &graph.add<GearPair>("mesh", {first.body->marker(), second.body->marker()},
                                    {.radius_A = r1, .radius_B = ring * r2});
        graph.add<PointForce>("torque", {first.body->marker()}, {.torque = {0, 0, T}});
      });
      const double ratio = -ring * r1 / r2, acceleration = T / (J1 + J2 * ratio * ratio);
      scene.run(*method, 2.5);
      const double phi = 0.5 * acceleration * 2.5 * 2.5;
      EXPECT_GT(std::abs(phi * ratio), 2 * 2 * kPi);
      EXPECT_NEAR(read(scene, coordinate(first.angle(), "phi")), phi, 1e-6 * phi);
      EXPECT_NEAR(read(scene, coordinate(second.angle(), "phi")), ratio * phi, 1e-6 * phi);
      // The tooth pushes the second gear at (-ring r2, 0, 0) from its centre.
      const double F = J2 * ratio * acceleration / (-ring * r2);
      EXPECT_LT((read_vector(scene, reaction(*mesh, 1)) - Vector3(0, F, 0)).norm(), 1e-5 * std::abs(F));
      EXPECT_LT((read_vector(scene, reaction(*second.pin, 1)) - Vector3(0, -F, 0)).norm(), 1e-5 * std::abs(F));
      EXPECT_LT((read_vector(scene, reaction(*first.pin, 1)) - Vector3(0, F, 0)).norm(), 1e-5 * std::abs(F));
      EXPECT_NEAR(read(scene, power(*mesh)), 0, 1e-8);
    }
}

/// Sun 0.1 m, planets 0.05 m, ring 0.2 m fixed: the carrier turns at 1 : 1 + z_r / z_s = 1 : 3 of the sun.
struct PlanetaryTrain : Scene {
  static constexpr double kSun = 0.1, kPlanet = 0.05, kRing = 0.2, kArm = kSun + kPlanet;
  struct Parts {
    Shaft sun, carrier;
    CoordinateDrive* drive;
    std::vector<RevoluteJoint*> planets;
    GearPair* mesh;
  };
  PlanetaryTrain(int count, double speed, Parts& parts)
      : Scene({0, 0, 0}, [&](SystemGraph& graph) {
          parts.sun = draw_shaft(graph, "sun", 0.01);
          parts.carrier = draw_shaft(graph, "carrier", 0.05, {0, 0, 0.1}, Matrix3::Identity(), speed / 3);
          for (int i = 0; i < count; ++i) {
            const std::string name = "planet " + std::to_string(i);
            const Vector3 place = kArm * Vector3(std::cos(2 * kPi * i / 3), std::sin(2 * kPi * i / 3), 0);
            auto& planet = graph.add<RigidBody>(name, {.mass = 0.2, .inertia = {0.01, 0.01, 0.01}, .position = place});
            parts.planets.push_back(&graph.add<RevoluteJoint>(
                name + " pin", {parts.carrier.body->marker(place - Vector3(0, 0, 0.1)), planet.marker()}));
            parts.mesh = &graph.add<GearPair>(name + " sun", {parts.sun.body->marker(), planet.marker()},
                                              {.radius_A = kSun, .radius_B = kPlanet});
            graph.add<GearPair>(name + " ring", {planet.marker(), graph.ground().marker()},
                                {.radius_A = kPlanet, .radius_B = -kRing});
          }
          graph.add<PointForce>("load", {parts.carrier.body->marker()}, {.torque = {0, 0, -kLoad}});
          parts.drive = &graph.add<CoordinateDrive>("drive", {parts.sun.angle()}, {.motion = ramp(0, speed)});
        }) {}
};

TEST(GearPair, MakesAPlanetaryTrainOfRatioThreeOverTenTurnsOfTheCarrier) {
  PlanetaryTrain::Parts parts;
  const double speed = 60, end = 3.3;
  PlanetaryTrain train(3, speed, parts);
  EXPECT_EQ(train.system.redundant_rows().size(), 2u);  // the second and third planet repeat the first's ratio
  const Method method = index3(2e-3);
  train.run(*method, end);
  const double turned = speed * end / 3;
  EXPECT_GT(turned, 10 * 2 * kPi);
  EXPECT_NEAR(read(train, coordinate(parts.carrier.angle(), "carrier")), turned, 1e-8);
  EXPECT_NEAR(read(train, coordinate(parts.sun.angle(), "sun")), 3 * turned, 1e-8);
  for (RevoluteJoint* pin : parts.planets)
    EXPECT_NEAR(read(train, coordinate(pin->angle(), "planet")), -4 * turned, 1e-7);  // -z_r / z_p against the carrier
  EXPECT_NEAR(read(train, drive_force(*parts.drive)), kLoad / 3, 1e-6);
  EXPECT_NEAR(read(train, power(*parts.drive)), kLoad * speed / 3, 1e-4);
}

TEST(GearPair, LoadsThePinOfASinglePlanetByTheTorqueOverItsArm) {
  PlanetaryTrain::Parts parts;
  PlanetaryTrain train(1, 6, parts);
  EXPECT_TRUE(train.system.redundant_rows().empty());
  const Method method = index2(2e-3);
  train.run(*method, 0.7);
  const double phi = 2 * 0.7, centripetal = 0.2 * PlanetaryTrain::kArm * 4;
  const Vector3 radial(std::cos(phi), std::sin(phi), 0), across(-std::sin(phi), std::cos(phi), 0);
  const double tooth = kLoad / 3 / PlanetaryTrain::kSun;
  // On the planet: the pin holds it in its circle and brakes it by the load.
  const Vector3 pin = -kLoad / PlanetaryTrain::kArm * across - centripetal * radial;
  EXPECT_LT((read_vector(train, reaction(*parts.planets[0], 1)) - pin).norm(), 1e-5);
  EXPECT_LT((read_vector(train, reaction(*parts.mesh, 1)) - tooth * across).norm(), 1e-5);
  EXPECT_LT((read_vector(train, reaction(*parts.sun.pin, 1)) - tooth * across).norm(), 1e-5);
}

TEST(CoordinateCoupling, IsABeltOverMoreThanAHundredTurns) {
  Shaft motor, fan;
  CoordinateDrive* drive;
  Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
    motor = draw_shaft(graph, "motor", 0.1);
    fan = draw_shaft(graph, "fan", 0.3, {0.5, 0, 0}, Matrix3::Identity(), -40);
    graph.add<CoordinateCoupling>("belt", {motor.angle(), fan.angle()}, {.factors = {1, 2.5}});
    drive = &graph.add<CoordinateDrive>("drive", {motor.angle()}, {.motion = ramp(0, 100)});
  });
  const Method method = index3(5e-3);
  scene.run(*method, 8);
  EXPECT_NEAR(read(scene, coordinate(motor.angle(), "motor")), 800, 1e-7);  // 127 turns
  EXPECT_NEAR(read(scene, coordinate(fan.angle(), "fan")), -320, 1e-7);
  EXPECT_NEAR(read(scene, drive_force(*drive)), 0, 1e-6);
  EXPECT_NEAR(read_vector(scene, reaction(*fan.pin, 1)).norm(), 0, 1e-6);  // it pulls at no bearing
}

/// Σ c x = 0 of shafts with inertia: J φ̈ = T - c μ, and Σ c φ̈ = 0 gives μ.
TEST(CoordinateCoupling, SharesATorqueAmongFourShafts) {
  const double c[4] = {1, 1, -2, 0.5}, J[4] = {0.1, 0.2, 0.3, 0.4}, T[4] = {0, -0.5, 2, 0.1};
  for (auto& [name, method] : every_method(2e-3)) {
    SCOPED_TRACE(name);
    Shaft shafts[4];
    Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
      for (int i = 0; i < 4; ++i) {
        const std::string number = std::to_string(i);
        const Matrix3 axes = rotation_about(Vector3(1, i, 0.5), 0.7 * i);
        shafts[i] = draw_shaft(graph, "shaft " + number, J[i], {1.0 * i, 0, 0}, axes);
        graph.add<PointForce>("torque " + number, {shafts[i].body->marker()},
                              {.torque = {0, 0, T[i]}, .axes = PointForce::Axes::marker});
      }
      graph.add<CoordinateCoupling>("differential",
                                    {shafts[0].angle(), shafts[1].angle(), shafts[2].angle(), shafts[3].angle()},
                                    {.factors = {c[0], c[1], c[2], c[3]}});
    });
    double pull = 0, give = 0;
    for (int i = 0; i < 4; ++i) pull += c[i] * T[i] / J[i], give += c[i] * c[i] / J[i];
    scene.run(*method, 4);
    for (int i = 0; i < 4; ++i)
      EXPECT_NEAR(read(scene, coordinate(shafts[i].angle(), "phi")), (T[i] - c[i] * pull / give) / J[i] * 8, 1e-6) << i;
  }
}

}  // namespace
}  // namespace lithe::test::transmission_test
