// Bodies that rest on each other (reference problem C03), and a top that spins on a plane.
#include <gtest/gtest.h>

#include <cmath>

#include "bodies/rigid_body.h"
#include "engine/model/system_graph.h"
#include "engine/observe/contact_sensors.h"
#include "engine/run/simulation.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/contact/contact.h"

namespace lithe::test::contact_stack_test {
namespace {

constexpr double g = 9.81;

/// Ten cubes above one another on a plane.
struct Stack {
  SystemGraph graph;
  std::vector<RigidBody*> cubes;
  const Contact* contact;
  double edge;
  Stack(double edge_length, double top_mass, double gap, double slope = 0, int count = 10)
      : graph({.gravity = {g * std::sin(slope), 0, -g * std::cos(slope)}}), edge(edge_length) {
    std::vector<Collider> colliders{{graph.ground().marker(), shape::half_space()}};
    for (int i = 0; i < count; ++i) {
      const double mass = i == count - 1 ? top_mass : 1, J = mass * edge * edge / 6;
      cubes.push_back(&graph.add<RigidBody>(
          "cube " + std::to_string(i),
          {.mass = mass, .inertia = {J, J, J}, .position = {0, 0, gap + edge / 2 + i * (edge + gap)}}));
      colliders.push_back({cubes.back()->marker(), shape::box({edge, edge, edge})});
    }
    contact = &graph.add<Contact>("stack", std::move(colliders), {.friction = {.coefficient = 0.5}});
  }
};

TEST(Stack, OfTenCubesStandsForHalfAMinuteAndBearsItsWeight) {
  Stack stack(0.1, 1, 0);
  const System system = assemble(stack.graph);
  MoreauJean integrator{{.step = 1.0 / 240}};
  Simulation simulation(system, integrator);
  State state = system.initial_state();
  simulation.run(state, 30);
  for (int i = 0; i < 10; ++i) {
    const Vector3 moved = state.q.segment<3>(7 * i) - Vector3(0, 0, 0.05 + 0.1 * i);
    EXPECT_LT(moved.norm(), 1e-6) << "cube " << i;
  }
  EXPECT_LT(state.v.norm(), 1e-7);
  Snapshot now(system, state);
  for (int i = 0; i < 10; ++i)
    EXPECT_NEAR(contact_force(*stack.contact, i, i + 1).value(now, 2), (10 - i) * g, 1e-5) << "interface " << i;
}

TEST(Stack, WithATopAHundredTimesHeavierFallsWithoutGainOfEnergy) {
  for (double top : {1.0, 100.0}) {
    Stack stack(1, top, 0.05);
    const System system = assemble(stack.graph);
    MoreauJean integrator{{.step = 1.0 / 240}};
    Simulation simulation(system, integrator);
    State state = system.initial_state();
    Snapshot now(system, state);
    const Sensor energy = total_energy(), overlap = penetration(*stack.contact);
    const double start = energy.value(now);
    double lowest = start, gain = 0, deepest = 0;
    for (int k = 1; k <= 200; ++k) {
      simulation.run(state, 0.02 * k);
      now.evaluate(state);
      const double e = energy.value(now);
      gain = std::max(gain, e - lowest);
      lowest = std::min(lowest, e);
      deepest = std::max(deepest, overlap.value(now));
    }
    EXPECT_LT(gain / (start - lowest), 1e-6) << "top " << top;
    EXPECT_LT(deepest, 1e-8) << "top " << top;
    for (int i = 0; i < 10; ++i)
      EXPECT_LT((state.q.segment<3>(7 * i) - Vector3(0, 0, 0.5 + i)).norm(), 1e-6) << "cube " << i << ", top " << top;
  }
}

TEST(Stack, SlidesAsAWholeBeyondTheFrictionAngleAndStandsBelow) {
  // Two low slabs: ten cubes would topple.
  for (const auto& [slope, slides] : {std::pair(20.0, false), std::pair(26.6, true)}) {
    const double angle = slope * M_PI / 180;
    SystemGraph graph{{.gravity = {g * std::sin(angle), 0, -g * std::cos(angle)}}};
    std::vector<Collider> colliders{{graph.ground().marker(), shape::half_space()}};
    for (int i = 0; i < 2; ++i) {
      auto& slab = graph.add<RigidBody>(
          "slab " + std::to_string(i), {.mass = 1, .inertia = {0.01, 0.01, 0.02}, .position = {0, 0, 0.02 + 0.04 * i}});
      colliders.push_back({slab.marker(), shape::box({0.3, 0.3, 0.04})});
    }
    graph.add<Contact>("slabs", std::move(colliders), {.friction = {.coefficient = 0.5}});
    const System system = assemble(graph);
    MoreauJean integrator{{.step = 1e-2}};
    Simulation simulation(system, integrator);
    State state = system.initial_state();
    simulation.run(state, 2);
    const double expected = slides ? 0.5 * g * (std::sin(angle) - 0.5 * std::cos(angle)) * 4 : 0;
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(state.q[7 * i], expected, 1e-9) << slope << " degrees, slab " << i;
  }
}

TEST(Top, OnASmoothPlanePrecessesSteadily) {
  // About its centre of mass, which stays: C ω₃ Ω - A Ω² cos θ = m g l.
  const double mass = 0.5, l = 0.04, A = 4e-4, C = 6e-4, lean = 0.5, spin = 200, r = 0.002;
  const double b = C * spin, a = A * std::cos(lean);
  const double turn = (b - std::sqrt(b * b - 4 * a * mass * g * l)) / (2 * a);  // Ω, the slow one
  SystemGraph graph;
  const Matrix3 axes = rotation_about({0, 1, 0}, lean);
  auto& top = graph.add<RigidBody>("top", {.mass = mass,
                                           .inertia = {A, A, C},
                                           .position = {0, 0, r + l * std::cos(lean)},
                                           .orientation = axes,
                                           .angular_velocity = {-turn * std::sin(lean), 0, spin}});
  graph.add<Contact>("tip",
                     {{graph.ground().marker(), shape::half_space()}, {top.marker({0, 0, -l}), shape::sphere(r)}}, {});
  const System system = assemble(graph);
  MoreauJean moreau{{.step = 1e-4}};
  NonsmoothGeneralizedAlpha alpha{{.step = 1e-4}};
  for (Integrator* integrator : std::initializer_list<Integrator*>{&moreau, &alpha}) {
    Simulation simulation(system, *integrator);
    State state = system.initial_state();
    Snapshot now(system, state);
    const Sensor energy = total_energy();
    const double start = energy.value(now);
    simulation.run(state, 0.5);
    now.evaluate(state);
    const Vector3 axis = rotation_matrix(state.q.segment<4>(3)).col(2);
    EXPECT_NEAR(std::acos(axis[2]), lean, 5e-5) << integrator->name();
    EXPECT_NEAR(std::remainder(std::atan2(axis[1], axis[0]) - turn / 2, 2 * M_PI), 0, 1e-4) << integrator->name();
    EXPECT_NEAR(energy.value(now) / start, 1, 1e-6) << integrator->name();
    EXPECT_LT(state.q.head<2>().norm(), 1e-6) << integrator->name();
  }
}

}  // namespace
}  // namespace lithe::test::contact_stack_test
