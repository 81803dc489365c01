#include "bodies/rigid_body.h"
#include "joints/constant_velocity_joint.h"
#include "joints/coordinate_coupling.h"
#include "joints/forces/bushing.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/coordinate_stop.h"
#include "joints/forces/joint_friction.h"
#include "joints/gear_pair.h"
#include "joints/perpendicular_axes_joint.h"
#include "joints/planar_pin_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/rack_and_pinion.h"
#include "joints/revolute_joint.h"
#include "joints/revolute_spherical_joint.h"
#include "joints/rolling_disc.h"
#include "joints/sliding/sliding_joint.h"
#include "joints/three_node_fixation.h"
#include "joints/universal_joint.h"
#include "tests/gradient/gradient_support.h"

namespace lithe::test {
namespace {

/// Two bodies on bushings, tied by the joint between markers at a given place and turn of the second body.
template <class Joint, class... Parameters>
ParametricScene tied(const char* name, const Vector3& aside, const Matrix3& turned, Parameters... parameters) {
  return {.name = name,
          .duration = 0.2,
          .draw =
              [=](SystemGraph& graph, const SweepPoint& p) {
                auto& first = graph.add<RigidBody>(
                    "first", {.mass = 2, .inertia = {0.05, 0.06, 0.07}, .angular_velocity = {0.4, -0.3, 0.5}});
                const Matrix3 tilt = rotation_about({1, 2, 0.5}, p["tilt"]);
                const Vector3 place(0.3, p["place"], 0.1);
                const Vector3 center = place + tilt * Vector3(0.2, 0, 0) + tilt * aside;
                auto& second = graph.add<RigidBody>(
                    "second",
                    {.mass = p["mass"], .inertia = {0.02, 0.03, 0.025}, .position = center, .orientation = tilt});
                for (auto* body : {&first, &second})
                  graph.add<Bushing>(body == &first ? "left" : "right",
                                     {graph.ground().marker(body == &first ? Vector3::Zero() : center), body->marker()},
                                     {.stiffness = Bushing::diagonal({p["stiffness"], 900, 800}, {60, 50, 40}),
                                      .damping = Bushing::diagonal({5, 5, 5}, {0.5, 0.5, 0.5})});
                auto& joint = graph.add<Joint>(
                    "joint", {first.marker(place, tilt), second.marker({-0.2, 0, 0}, turned)}, parameters...);
                return std::vector<Sensor>{position(second.marker({0.2, 0, 0}), "end"), multipliers(joint, "lambda"),
                                           kinetic_energy("kinetic")};
              },
          .integrator = exact_alpha(5e-3)};
}

const std::vector<DesignParameter> kTied{{"tilt", 0.3}, {"place", 0.15}, {"mass", 0.9}, {"stiffness", 1000}};
/// Multipliers over time: at one they have what Newton leaves, times 1/h².
const std::vector<Quantity> kTiedEnd{value_at("end_z", 0.2), integral("lambda_1"), integral("kinetic")};
const Matrix3 kPlain = Matrix3::Identity(), kQuarter = rotation_about({1, 0, 0}, M_PI / 2);

TEST(MoreJointGradients, Universal) {
  expect_gradient(tied<UniversalJoint>("universal", Vector3::Zero(), kPlain), kTiedEnd, kTied);
}
TEST(MoreJointGradients, ConstantVelocity) {
  expect_gradient(tied<ConstantVelocityJoint>("constant velocity", Vector3::Zero(), kPlain), kTiedEnd, kTied);
}
TEST(MoreJointGradients, PlanarPin) {
  expect_gradient(tied<PlanarPinJoint>("planar pin", Vector3::Zero(), kPlain), kTiedEnd, kTied);
}
TEST(MoreJointGradients, PerpendicularAxes) {
  expect_gradient(tied<PerpendicularAxesJoint>("perpendicular axes", Vector3::Zero(), kQuarter), kTiedEnd, kTied);
}
TEST(MoreJointGradients, RevoluteSpherical) {
  expect_gradient(tied<RevoluteSphericalJoint>("revolute spherical", Vector3(0.1, 0.15, 0), kPlain,
                                               RevoluteSphericalJoint::Parameters{}),
                  kTiedEnd, kTied);
}

/// A shaft with a gear in mesh with another, which drives a rack on a slide; both are moved by a motor and a spring.
TEST(MoreJointGradients, GearPairAndRack) {
  const ParametricScene scene{
      .name = "gears",
      .duration = 0.3,
      .draw =
          [](SystemGraph& graph, const SweepPoint& p) {
            const double a = p["radius"], b = 0.2;
            auto& pinion = graph.add<RigidBody>("pinion", {.mass = 1, .inertia = {0.01, 0.01, p["inertia"]}});
            auto& wheel =
                graph.add<RigidBody>("wheel", {.mass = 2, .inertia = {0.02, 0.02, 0.04}, .position = {a + b, 0, 0}});
            auto& rack = graph.add<RigidBody>(
                "rack", {.mass = p["mass"], .inertia = {0.1, 0.1, 0.1}, .position = {a + b, -b, 0}});
            auto& shaft = graph.add<RevoluteJoint>("shaft", {graph.ground().marker(), pinion.marker()});
            graph.add<RevoluteJoint>("axle", {graph.ground().marker({a + b, 0, 0}), wheel.marker()});
            graph.add<GearPair>("mesh", {pinion.marker(), wheel.marker()}, {.radius_A = a, .radius_B = b});
            const Matrix3 along_x = rotation_about({0, 1, 0}, M_PI / 2);
            auto& slide = graph.add<PrismaticJoint>(
                "slide", {graph.ground().marker({a + b, -b, 0}, along_x), rack.marker({}, along_x)});
            auto& teeth = graph.add<RackAndPinion>("teeth", {wheel.marker(), rack.marker()}, {.radius = b});
            graph.add<CoordinateSpring>("spring", {slide.displacement()}, {.stiffness = 40, .damping = 2});
            const double torque = p["torque"];
            graph.add<CoordinateMotor>("motor", {shaft.angle()}, {[=](double, double, double speed) {
                                         return torque - 0.1 * speed * speed * speed;
                                       }});
            return std::vector<Sensor>{coordinate(shaft.angle(), "angle"), multipliers(teeth, "teeth"),
                                       position(rack.marker(), "rack")};
          },
      .integrator = exact_alpha(5e-3)};
  expect_gradient(scene, {value_at("angle", 0.3), integral("teeth_1"), integral("rack_x")},
                  {{"radius", 0.1}, {"inertia", 0.01}, {"mass", 1.5}, {"torque", 3}});
}

/// A shaft that a spring turns, on a belt with another.
ParametricScene belt(bool stop) {
  return {.name = "belt",
          .duration = 0.3,
          .draw =
              [=](SystemGraph& graph, const SweepPoint& p) {
                auto& motor = graph.add<RigidBody>("motor", {.mass = 1, .inertia = {0.02, 0.02, 0.01}});
                auto& fan = graph.add<RigidBody>(
                    "fan", {.mass = 1, .inertia = {0.02, 0.02, p["inertia"]}, .position = {1, 0, 0}});
                auto& shaft = graph.add<RevoluteJoint>("shaft", {graph.ground().marker(), motor.marker()});
                auto& axle = graph.add<RevoluteJoint>("axle", {graph.ground().marker({1, 0, 0}), fan.marker()});
                auto& belt =
                    graph.add<CoordinateCoupling>("belt", {shaft.angle(), axle.angle()}, {.factors = {1, -p["ratio"]}});
                graph.add<CoordinateSpring>("spring", {shaft.angle()},
                                            {.stiffness = p["gain"], .damping = 0.2, .free_value = -0.5});
                if (stop)
                  graph.add<CoordinateStop>("stop", {axle.angle()},
                                            {.upper = -0.4, .stiffness = p["stop"], .dissipation = 0.3});
                return std::vector<Sensor>{coordinate(shaft.angle(), "angle"), multipliers(belt, "belt")};
              },
          .integrator = exact_alpha(3e-3)};
}
const std::vector<Quantity> kBelt{value_at("angle", 0.3), integral("belt_1"), integral("angle")};

TEST(MoreJointGradients, Coupling) {
  expect_gradient(belt(false), kBelt, {{"inertia", 0.02}, {"ratio", 2}, {"gain", 20}});
}
TEST(MoreJointGradients, StopThatStaysClosed) {
  expect_gradient(belt(true), kBelt, {{"inertia", 0.02}, {"ratio", 2}, {"gain", 20}, {"stop", 5}});
}

/// A body held by three of its points (nine rows of rank six) on another.
TEST(MoreJointGradients, ThreeNodeFixation) {
  const ParametricScene scene{
      .name = "three nodes",
      .duration = 0.2,
      .draw =
          [](SystemGraph& graph, const SweepPoint& p) {
            auto& first = graph.add<RigidBody>("first", {.mass = 2, .inertia = {0.05, 0.06, 0.07}});
            auto& second = graph.add<RigidBody>(
                "second", {.mass = p["mass"], .inertia = {0.02, 0.03, 0.025}, .position = {0.4, 0, 0}});
            graph.add<Bushing>("bushing", {graph.ground().marker(), first.marker()},
                               {.stiffness = Bushing::diagonal({p["stiffness"], 900, 800}, {60, 50, 40}),
                                .damping = Bushing::diagonal({5, 5, 5}, {0.5, 0.5, 0.5})});
            graph.add<ThreeNodeFixation>("clamp", {first.marker({0.2, 0, 0}), second.marker({-0.1, 0, 0}),
                                                   second.marker({-0.1, 0.1, 0}), second.marker({-0.1, 0, p["arm"]})});
            return std::vector<Sensor>{position(second.marker({0.2, 0, 0}), "end"), kinetic_energy("kinetic")};
          },
      .integrator = exact_alpha(4e-3)};
  expect_gradient(scene, {value_at("end_z", 0.2), integral("kinetic")},
                  {{"mass", 0.9}, {"stiffness", 1000}, {"arm", 0.1}});
}

/// A ball that slides along a bent rail on the ground, between two of its markers: past one the third derivative of
/// the rail jumps, and differences of fourth order see it.
TEST(MoreJointGradients, Sliding) {
  const ParametricScene scene{
      .name = "rail",
      .duration = 0.09,
      .draw =
          [](SystemGraph& graph, const SweepPoint& p) {
            std::vector<Marker> rail;
            for (int i = 0; i < 7; ++i)
              rail.push_back(graph.ground().marker({0.2 * i, 0.02 * i * i, p["slope"] * i - 0.01 * i * i}));
            auto& ball = graph.add<RigidBody>("ball", {.mass = p["mass"],
                                                       .inertia = {0.02, 0.03, 0.025},
                                                       .position = {0.5, 0.125, 2.5 * p["slope"] - 0.0625}});
            add_sliding_joint(graph, "slide", ball.marker({0, 0, 0}), rail);
            graph.add<Bushing>("bushing", {graph.ground().marker({0.5, 0, 0}), ball.marker({0, 0, 0.1})},
                               {.stiffness = Bushing::diagonal({p["stiffness"], 20, 20}, {1, 1, 1}),
                                .damping = Bushing::diagonal({0.5, 0.5, 0.5}, {0.1, 0.1, 0.1})});
            return std::vector<Sensor>{position(ball.marker(), "ball"), kinetic_energy("kinetic")};
          },
      .integrator = exact_alpha(3e-3)};
  expect_gradient(scene, {value_at("ball_x", 0.09), integral("kinetic")},
                  {{"mass", 0.9}, {"slope", 0.05}, {"stiffness", 30}});
}

/// Rows on velocities alone and friction by reactions: forwards; backwards they are refused by name.
ParametricScene coin() {
  return {.name = "coin",
          .duration = 0.3,
          .draw =
              [](SystemGraph& graph, const SweepPoint& p) {
                const double r = p["radius"], tilt = p["tilt"];
                const Matrix3 R = rotation_about({1, 0, 0}, M_PI / 2 - tilt);
                auto& disc = graph.add<RigidBody>("disc", {.mass = p["mass"],
                                                           .inertia = {0.001, 0.001, 0.002},
                                                           .position = {0, 0, r * std::cos(tilt)},
                                                           .orientation = R,
                                                           .velocity = {p["speed"], 0, 0},
                                                           .angular_velocity = {0, 0, -p["speed"] / r}});
                graph.add<RollingDisc>("contact", {graph.ground().marker(), disc.marker()}, {.radius = r});
                return std::vector<Sensor>{position(disc.marker(), "disc")};
              },
          .integrator = exact_alpha(2e-3)};
}
const std::vector<DesignParameter> kCoin{{"radius", 0.1}, {"tilt", 0.15}, {"mass", 0.3}, {"speed", 1.5}};

TEST(MoreJointGradients, RollingDiscForwards) {
  expect_gradient(coin(), {value_at("disc_y", 0.3), integral("disc_z")}, kCoin, 1e-8, false);
}

ParametricScene rubbing() {
  return {
      .name = "rubbing",
      .duration = 0.3,
      .draw =
          [](SystemGraph& graph, const SweepPoint& p) {
            const Matrix3 y = rotation_about({1, 0, 0}, -M_PI / 2);
            auto& rod = graph.add<RigidBody>("rod", {.mass = p["mass"],
                                                     .inertia = {0.05, 0.05, 0.09},
                                                     .position = {0.4, 0, 0},
                                                     .velocity = {0, 0, -0.8},
                                                     .angular_velocity = {0, 2, 0}});
            auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, y), rod.marker({-0.4, 0, 0}, y)});
            graph.add<JointFriction>("rub", {pin.angle()},
                                     {.joint = &pin, .coefficient = p["friction"], .radius = 0.02});
            return std::vector<Sensor>{coordinate(pin.angle(), "angle")};
          },
      .integrator = exact_alpha(3e-3)};
}

TEST(MoreJointGradients, FrictionByReactionsForwards) {
  expect_gradient(rubbing(), {value_at("angle", 0.3)}, {{"mass", 1.1}, {"friction", 0.3}}, 1e-8, false);
}

TEST(MoreJointGradients, WhatHasNoAdjointIsRefusedByName) {
  const auto refusal = [](const ParametricScene& scene, const char* column,
                          const std::vector<DesignParameter>& parameters) -> std::string {
    try {
      gradient(scene, {value_at(column, 0.1)}, parameters, {.mode = GradientOptions::Mode::adjoint});
    } catch (const SceneError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_NE(refusal(coin(), "disc_y", kCoin).find("rolling"), std::string::npos);
  EXPECT_NE(refusal(rubbing(), "angle", {{"mass", 1.1}, {"friction", 0.3}}).find("friction by reactions"),
            std::string::npos);
}

}  // namespace
}  // namespace lithe::test
