// Compliant contacts with the integrators for smooth motion: where surfaces meet and part is an event, and Newton's
// method knows their stiffness.
#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/model/system_graph.h"
#include "engine/observe/contact_sensors.h"
#include "engine/run/simulation.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "integrators/moreau_jean.h"
#include "integrators/radau.h"
#include "joints/contact/contact.h"

namespace lithe::test::contact_events_test {
namespace {

constexpr double kG = 9.81, kStiffness = 1e7, kRadius = 0.1, kDrop = 1.0;

/// A ball 1 m above the ground.
struct Drop {
  SystemGraph graph;
  RigidBody& ball;
  Contact& floor;
  System system;
  explicit Drop(Contact::Parameters parameters, double gravity = kG, double speed = 0)
      : graph({.gravity = {0, 0, -gravity}}),
        ball(
            graph.add<RigidBody>("ball", {.mass = 2, .position = {0, 0, kRadius + kDrop}, .velocity = {0, 0, -speed}})),
        floor(graph.add<Contact>(
            "floor", {{graph.ground().marker(), shape::half_space()}, {ball.marker(), shape::sphere(kRadius)}},
            std::move(parameters))),
        system(assemble(graph)) {}
};

TEST(CompliantContact, MeetsAndPartsWhereEventsSaySo) {
  Drop drop({.law = Compliance{.stiffness = kStiffness}});
  ExplicitRungeKutta rk{{.tolerance = {1e-10, 1e-12}}};
  Radau radau{{.tolerance = {1e-10, 1e-12}}};
  for (Integrator* integrator : std::initializer_list<Integrator*>{&rk, &radau}) {
    Simulation simulation(drop.system, *integrator);
    State state = drop.system.initial_state();
    simulation.run(state, 0.6);
    ASSERT_EQ(simulation.events().size(), 2u) << integrator->name();
    const double met = simulation.events()[0].time, parted = simulation.events()[1].time;
    EXPECT_EQ(simulation.events()[0].name, "floor");
    EXPECT_NEAR(met, std::sqrt(2 * kDrop / kG), 1e-9) << integrator->name();
    // Hertz: 3.218 (m²/(k² v))^(1/5); the weight beside the force of impact is some 1e-4 of it.
    const double v = std::sqrt(2 * kG * kDrop);
    EXPECT_NEAR((parted - met) / (3.2180 * std::pow(4 / (kStiffness * kStiffness * v), 0.2)), 1, 3e-3);
    // No energy is lost: up it goes.
    EXPECT_NEAR(0.5 * state.v[2] * state.v[2] + kG * (state.q[2] - kRadius - kDrop), 0, 1e-7) << integrator->name();
  }
}

TEST(CompliantContact, ReachesItsRestitutionWhateverTheIntegrator) {
  Drop drop({.law = Compliance{.stiffness = kStiffness, .restitution = 0.6}}, /*gravity=*/0, /*speed=*/4);
  ExplicitRungeKutta rk{{.tolerance = {1e-9, 1e-11}}};
  Radau radau{{.tolerance = {1e-9, 1e-11}}};
  GeneralizedAlpha alpha{{.tolerance = {1e-8, 1e-10}}};
  for (Integrator* integrator : std::initializer_list<Integrator*>{&rk, &radau, &alpha}) {
    Simulation simulation(drop.system, *integrator);
    State state = drop.system.initial_state();
    simulation.run(state, 0.5);
    EXPECT_NEAR(state.v[2], 0.6 * 4, integrator == &alpha ? 1e-3 : 1e-6) << integrator->name();
  }
}

TEST(CompliantContact, NewtonKnowsItsStiffness) {
  // A block that slides on four corners and turns: contact and friction are far stiffer than its inertia over a step,
  // so that with a wrong tangent Newton would not converge.
  SystemGraph graph{{.gravity = {0, 0, -kG}}};
  auto& block =
      graph.add<RigidBody>("block", {.mass = 1, .inertia = {0.02, 0.03, 0.04}, .position = {0, 0, 0.05 - kG / 4e8}});
  graph.add<Contact>("floor",
                     {{graph.ground().marker(), shape::half_space()}, {block.marker(), shape::box({0.4, 0.3, 0.1})}},
                     {.law = Compliance{.stiffness = 1e8, .exponent = 1}, .friction = {.coefficient = 0.4}});
  const System system = assemble(graph);
  GeneralizedAlpha alpha{{.step = 2e-3, .spectral_radius = 0.5}};
  Simulation simulation(system, alpha);
  State state = system.initial_state();
  state.v << 0.1, 0.05, 0, 0, 0, 0.1;
  simulation.run(state, 1);
  EXPECT_LE(alpha.statistics().newton_iterations, 4 * alpha.statistics().steps);
  EXPECT_EQ(alpha.statistics().newton_failures, 0);
  EXPECT_NEAR(state.q[2], 0.05 - kG / 4e8, 1e-9);
}

TEST(RigidContact, LoadsAreThoseThatTheSensorsTell) {
  Drop drop({.law = RigidSurfaces{.restitution = 0.5}});
  MoreauJean integrator{{.step = 1e-3}};
  Simulation simulation(drop.system, integrator);
  State state = drop.system.initial_state();
  simulation.run(state, 4);
  Snapshot now(drop.system, state);
  EXPECT_NEAR(contact_force(drop.floor, 1).value(now, 2), 2 * kG, 1e-9);
  EXPECT_NEAR(contact_force(drop.floor, 0).value(now, 2), -2 * kG, 1e-9);
  EXPECT_EQ(contact_force(drop.floor, 0, 1).value(now, 2), contact_force(drop.floor, 1).value(now, 2));
  EXPECT_LT(penetration(drop.floor).value(now), 1e-12);
  EXPECT_NEAR(gap(drop.floor, 0, 1, 1.0).value(now), 0, 1e-12);
  EXPECT_NEAR(state.v_dot.norm(), 0, 1e-9);
}

TEST(RigidContact, IsRefusedByMethodsThatDoNotKnowIt) {
  Drop drop({.law = RigidSurfaces{}});
  ExplicitRungeKutta rk{{}};
  Simulation simulation(drop.system, rk);
  State state = drop.system.initial_state();
  try {
    simulation.run(state, 1);
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("MoreauJean"), std::string::npos);
  }
}

}  // namespace
}  // namespace lithe::test::contact_events_test
