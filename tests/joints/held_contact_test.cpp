// Rigid surfaces that meet although a drive leaves their bodies no freedom.
#include <gtest/gtest.h>

#include "bodies/cable/cable.h"
#include "bodies/rigid_body.h"
#include "engine/base/error.h"
#include "engine/run/simulation.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/contact/contact.h"
#include "joints/coordinate_drive.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"

namespace lithe::test::held_contact_test {
namespace {

constexpr double kRadius = 0.1, kRate = 2, kArm = 0.5;
const Matrix3 kAxisY = rotation_about({1, 0, 0}, -M_PI / 2);

/// An arm that a motor turns downwards, 0.2 rad above the floor at first, a ball at its end.
void draw_driven_arm(SystemGraph& graph, bool with_stone) {
  const double height = kArm * std::sin(0.2) + kRadius;
  auto& arm = graph.add<RigidBody>("arm", {.mass = 1, .inertia = {0.01, 0.02, 0.02}, .position = {kArm, 0, height}});
  auto& pin = graph.add<RevoluteJoint>(
      "pin", {graph.ground().marker({0, 0, height}, kAxisY), arm.marker({-kArm, 0, 0}, kAxisY)});
  graph.add<CoordinateDrive>("motor", {pin.angle()}, {.motion = ramp(0, kRate)});
  std::vector<Collider> colliders{{graph.ground().marker(), shape::half_space()},
                                  {arm.marker(), shape::sphere(kRadius)}};
  if (with_stone) {
    auto& stone = graph.add<RigidBody>(
        "stone", {.mass = 1, .inertia = {0.01, 0.01, 0.01}, .position = {kArm + 0.19, 0, kRadius}});
    colliders = {{stone.marker(), shape::sphere(kRadius)}, {arm.marker(), shape::sphere(kRadius)}};
  }
  graph.add<Contact>("touch", colliders, Contact::Parameters{.law = RigidSurfaces{}});
}

template <class Method>
void expect_named() {
  SystemGraph graph;
  draw_driven_arm(graph, false);
  const System system = assemble(graph);
  State state = system.initial_state();
  Method method({.step = 1e-3});
  Simulation simulation(system, method);
  try {
    simulation.run(state, 1);
    FAIL() << "it ran into the floor";
  } catch (const SimulationError& error) {
    const std::string what = error.what();
    for (const char* named : {"'touch'", "'arm'", "'motor'", "m/s", "held_contact_test.cpp"})
      EXPECT_NE(what.find(named), std::string::npos) << named << "\n" << what;
    EXPECT_EQ(what.find("'pin'"), std::string::npos) << what;  // it does not prescribe anything
  }
  EXPECT_NEAR(state.time, 0.1, 2e-3);  // 0.2 rad at 2 rad/s
  EXPECT_TRUE(state.q.allFinite());
  EXPECT_NEAR(state.v[4], kRate, 1e-9);
}

TEST(HeldContact, time_stepping_names_the_drive_that_pushes_a_body_into_the_floor) { expect_named<MoreauJean>(); }

TEST(HeldContact, nonsmooth_generalized_alpha_names_it_too) { expect_named<NonsmoothGeneralizedAlpha>(); }

/// A cable's end that a carriage takes down onto the floor at 2 m/s, 0.2 m below: of bodies in nodal coordinates it was
/// not seen that no impulse moves what is driven, and steps went on through the floor with impulses of any size.
template <class Method>
void expect_named_of_a_cable() {
  constexpr double kGap = 0.2;
  SystemGraph graph;
  auto& carriage = graph.add<RigidBody>("carriage", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = {0, 0, 1}});
  auto& cable = graph.add<Cable>("cable", {.from = {0, 0, 1},
                                           .to = {1, 0, 1},
                                           .elements = 4,
                                           .mass_per_length = 1,
                                           .axial_stiffness = 1e4,
                                           .bending_stiffness = 10});
  auto& post = graph.add<PrismaticJoint>("post", {graph.ground().marker({0, 0, 1}), carriage.marker()});
  graph.add<SphericalJoint>("eye", {carriage.marker(), cable.start()});
  graph.add<CoordinateDrive>("motor", {post.displacement()}, {.motion = ramp(0, -kRate)});
  graph.add<Contact>("touch",
                     std::vector<Collider>{{graph.ground().marker({0, 0, 1 - kRadius - kGap}), shape::half_space()},
                                           {cable.start(), shape::sphere(kRadius)}},
                     Contact::Parameters{.law = RigidSurfaces{}});
  const System system = assemble(graph);
  State state = system.initial_state();
  Method method({.step = 1e-3});
  Simulation simulation(system, method);
  try {
    simulation.run(state, 1);
    FAIL() << "it ran into the floor";
  } catch (const SimulationError& error) {
    const std::string what = error.what();
    for (const char* named : {"'touch'", "'cable'", "'motor'", "no impulse can stop", "held_contact_test.cpp"})
      EXPECT_NE(what.find(named), std::string::npos) << named << "\n" << what;
  }
  EXPECT_NEAR(state.time, kGap / kRate, 2e-3);
}

TEST(HeldContact, a_driven_end_of_a_cable_is_named) {
  expect_named_of_a_cable<MoreauJean>();
  expect_named_of_a_cable<NonsmoothGeneralizedAlpha>();
}

TEST(HeldContact, a_driven_body_pushes_one_that_is_free) {
  SystemGraph graph({.gravity = {0, 0, 0}});
  draw_driven_arm(graph, true);
  const System system = assemble(graph);
  State state = system.initial_state();
  MoreauJean method({.step = 1e-3});
  Simulation(system, method).run(state, 0.3);
  EXPECT_GT(state.v.tail<6>().head<3>().norm(), 0.1);
}

}  // namespace
}  // namespace lithe::test::held_contact_test
