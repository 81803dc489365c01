// Impacts of rigid surfaces as events of a simulation, and the energy of impacts at gaps of a micrometre.
#include <gtest/gtest.h>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/surface_mesh.h"
#include "joints/forces/user_force.h"
#include "tests/reference/contact_scene.h"

namespace lithe::test::impact_events_test {
namespace {

constexpr double g = 9.81;

class EventsBy : public testing::TestWithParam<Stepper> {};
INSTANTIATE_TEST_SUITE_P(Steppers, EventsBy, testing::Values(Stepper::moreau_jean, Stepper::generalized_alpha),
                         [](const auto& tested) {
                           return tested.param == Stepper::moreau_jean ? "MoreauJean" : "NonsmoothGeneralizedAlpha";
                         });

std::vector<EventRecord> of(const ContactScene& scene, ContactChange change) {
  std::vector<EventRecord> found;
  for (const EventRecord& e : scene.events())
    if (e.contact.change == change) found.push_back(e);
  return found;
}

/// Impact n of a ball dropped from `height` with restitution e.
double time_of(int n, double height, double e) {
  double time = std::sqrt(2 * height / g);
  for (int i = 1; i <= n; ++i) time += 2 * std::pow(e, i) * std::sqrt(2 * height / g);
  return time;
}

TEST_P(EventsBy, a_bouncing_balls_impacts_are_told_with_time_speed_and_impulse) {
  constexpr double mass = 2, height = 1, e = 0.8;
  ContactScene scene;
  auto& ball = scene.sphere("ball", 0.1, mass, {0, 0, 0.1 + height});
  scene.contact({scene.plane(), {ball.marker(), shape::sphere(0.1)}}, 0, e);
  scene.start(GetParam(), 1e-3);
  scene.run(3.35);
  const auto impacts = of(scene, ContactChange::impact);
  ASSERT_EQ(impacts.size(), 8u);
  EXPECT_EQ(scene.events().size(), impacts.size()) << "nothing else happens";
  for (int n = 0; n < 8; ++n) {
    const double speed = std::pow(e, n) * std::sqrt(2 * g * height);
    EXPECT_NEAR(impacts[n].time, time_of(n, height, e), 1e-10);
    EXPECT_NEAR(impacts[n].contact.speed, speed, 1e-9);
    EXPECT_NEAR(impacts[n].contact.impulse, mass * (1 + e) * speed, 1e-9);
    EXPECT_EQ(impacts[n].name, "contact");
    EXPECT_EQ(impacts[n].index, -1);
    EXPECT_EQ(impacts[n].contact.a, 0);
    EXPECT_EQ(impacts[n].contact.b, 1);
  }
}

/// Ten bounces, from heights at which the ball is a micrometre or less above or below the floor as a step ends.
TEST_P(EventsBy, an_elastic_ball_keeps_its_energy_however_small_its_gap_at_a_steps_end) {
  for (const double step : {1e-3, 1e-2})
    for (const double gap : {0.0, 1e-9, -1e-9, 1e-7, 1e-6, -1e-6, 3e-6}) {
      const double height = 0.5 * g * 0.4 * 0.4 + gap;
      ContactScene scene;
      auto& ball = scene.sphere("ball", 0.1, 1, {0, 0, 0.1 + height});
      scene.contact({scene.plane(), {ball.marker(), shape::sphere(0.1)}}, 0, 1);
      scene.start(GetParam(), step);
      while (scene.state().time < 7.9) {
        scene.step();
        const double energy = 0.5 * scene.state().v.head<3>().squaredNorm() + g * (scene.state().q[2] - 0.1);
        ASSERT_NEAR(energy / (g * height), 1, 1e-12) << "gap " << gap << ", step " << step;
      }
      const auto impacts = of(scene, ContactChange::impact);
      ASSERT_EQ(impacts.size(), 10u);
      for (int n = 0; n < 10; ++n) EXPECT_NEAR(impacts[n].time, time_of(n, height, 1), 1e-10);
    }
}

/// Ball on ball in a row: the gap beyond the first impact closes within the step, by that impact alone.
TEST_P(EventsBy, elastic_balls_in_a_row_keep_their_energy_however_near_they_are) {
  for (const Impacts impacts : {Impacts::simultaneous, Impacts::sequential})
    for (const int n : {3, 5})
      for (const double gap : {0.0, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4}) {
        ContactScene scene{{0, 0, 0}};
        std::vector<Collider> colliders;
        double x = 0;
        for (int i = 0; i < n; ++i) {
          auto& ball = scene.sphere("ball" + std::to_string(i), 0.1, 1, {x, 0, 0}, {i == 0 ? 1.0 : 0.0, 0, 0});
          colliders.push_back({ball.marker(), shape::sphere(0.1)});
          x += 0.2 + (i == 0 ? 0.0102 : gap);
        }
        scene.contact(colliders, 0, 1, /*rest_speed=*/0);
        scene.start(GetParam(), 1e-3, {.impacts = impacts, .tolerance = 1e-10});
        scene.run(0.05);
        double energy = 0, momentum = 0;
        for (int i = 0; i < n; ++i) energy += std::pow(scene.state().v[6 * i], 2), momentum += scene.state().v[6 * i];
        EXPECT_NEAR(energy, 1, 1e-8) << n << " balls, gap " << gap;
        EXPECT_NEAR(momentum, 1, 1e-12);
        const auto met = of(scene, ContactChange::impact);
        ASSERT_FALSE(met.empty());
        EXPECT_NEAR(met[0].time, 0.0102, 1e-10);
        EXPECT_NEAR(met[0].contact.speed, 1, 1e-10);
      }
}

/// In a column under gravity too, where the ball below rests, hops or falls as another one meets it, and is thrown to
/// the floor and back. What is left is what a step does after an impact that it ends with, m v g h 1e-5, and where the
/// ball hops by less than what counts as touching (1e-9 m), its speed: together below 2e-5 J of 0.5 J. Were a ball at
/// rest taken to fall as it is met, as it was, 5e-3 J and more would be gained.
TEST_P(EventsBy, a_ball_that_meets_one_at_any_gap_above_the_floor_keeps_the_energy) {
  for (const double gap : {0.0, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3})
    for (const double step : {1e-3, 5e-3}) {
      ContactScene scene;
      auto& lower = scene.sphere("lower", 0.1, 1, {0, 0, 0.1 + gap});
      auto& upper = scene.sphere("upper", 0.1, 1, {0, 0, 0.3 + gap + 2e-4}, {0, 0, -1});
      scene.contact({scene.plane(), {lower.marker(), shape::sphere(0.1)}, {upper.marker(), shape::sphere(0.1)}}, 0, 1,
                    0);
      scene.start(GetParam(), step);
      const double energy = scene.read(total_energy());
      scene.run(0.02);
      EXPECT_NEAR(scene.read(total_energy()) - energy, 0, 5e-5) << gap << ", step " << step;
      // The upper ball leaves as from a wall at the height where they met: sqrt(1 + 2 g 2e-4) up, then g t.
      EXPECT_NEAR(scene.state().v[8], 1 - g * (0.02 - 4e-4), gap < 1e-4 ? 1e-3 : 0.05) << "thrown back";
    }
}

/// Flights far shorter than a step: several bounces within each.
TEST_P(EventsBy, an_elastic_ball_hops_on_however_low) {
  for (const double step : {1e-3, 1e-2})
    for (const double height : {1e-6, 1e-5, 1e-4}) {
      ContactScene scene;
      auto& ball = scene.sphere("ball", 0.1, 1, {0, 0, 0.1 + height});
      scene.contact({scene.plane(), {ball.marker(), shape::sphere(0.1)}}, 0, 1);
      scene.start(GetParam(), step);
      while (scene.state().time < 0.3) {
        scene.step();
        const double energy = 0.5 * scene.state().v.head<3>().squaredNorm() + g * (scene.state().q[2] - 0.1);
        ASSERT_NEAR(energy / (g * height), 1, 1e-6) << "height " << height << ", step " << step;
      }
      // A triangle of flights: height - g t²/2 in the time t since the last apex.
      const double fall = std::sqrt(2 * height / g), since = std::remainder(scene.state().time, 2 * fall);
      EXPECT_NEAR(scene.state().q[2] - 0.1, height - 0.5 * g * since * since, 1e-6 * height);
    }
}

TEST_P(EventsBy, what_lands_rests_and_is_lifted_tells_of_an_impact_and_a_parting) {
  // A plastic ball on a spring whose end is lifted: N = 0 where the spring bears the weight, k s = m g.
  ContactScene scene;
  auto& ball = scene.sphere("ball", 0.1, 1, {0, 0, 0.15});
  scene.contact({scene.plane(), {ball.marker(), shape::sphere(0.1)}}, 0);
  scene.graph.add<UserForce>("lift", {ball.marker()}, {[](double time, const MarkerView&) -> Wrench {
                               return force({0, 0, std::max(0.0, 20 * (time - 0.2))});
                             }});
  scene.start(GetParam(), 1e-3);
  scene.run(0.8);
  ASSERT_EQ(scene.events().size(), 2u);
  const EventRecord &landed = scene.events()[0], &parted = scene.events()[1];
  EXPECT_EQ(landed.contact.change, ContactChange::impact);
  EXPECT_NEAR(landed.time, std::sqrt(2 * 0.05 / g), 1e-10);
  EXPECT_NEAR(landed.contact.speed, std::sqrt(2 * g * 0.05), 1e-9);
  EXPECT_NEAR(landed.contact.impulse, std::sqrt(2 * g * 0.05), 1e-9) << "without what holds it afterwards";
  EXPECT_EQ(parted.contact.change, ContactChange::parting);
  EXPECT_NEAR(parted.time, 0.2 + g / 20, 1e-3) << "to a step";
}

TEST_P(EventsBy, a_flexible_rods_impact_is_told_at_its_time) {
  const FiniteElementModel model =
      brick_mesh({.size = {0.4, 0.04, 0.04}, .divisions = {8, 1, 1}, .type = "C3D20", .material = {2e9, 0.3, 1000}});
  ContactScene scene;
  auto& rod = scene.graph.add<FlexibleBody>(
      "rod",
      {.basis = make_basis(model, MeanAxisFrame{}, 6), .damping = {.modal_ratios = {0.02}}, .position = {0, 0, 0.5}});
  const SurfaceMesh skin = surface(rod);
  scene.contact({scene.plane(), {skin.frame, shape::surface(skin.nodes, skin.points, skin.triangles, skin.reach)}}, 0,
                0.5);
  scene.start(GetParam(), 1e-3);
  scene.run(0.4);
  const auto impacts = of(scene, ContactChange::impact);
  ASSERT_FALSE(impacts.empty());
  EXPECT_NEAR(impacts[0].time, std::sqrt(2 * 0.5 / g), 1e-8);
  EXPECT_NEAR(impacts[0].contact.speed, std::sqrt(2 * g * 0.5), 1e-6);
}

TEST(ImpactEvents, compliant_surfaces_say_whether_they_met_or_parted) {
  ContactScene scene;
  auto& ball = scene.sphere("ball", 0.1, 1, {0, 0, 0.2});
  scene.graph.add<Contact>("floor", std::vector<Collider>{scene.plane(), {ball.marker(), shape::sphere(0.1)}},
                           Contact::Parameters{.law = Compliance{.stiffness = 1e7}});
  const System system = assemble(scene.graph);
  Automatic integrator{{.tolerance = {1e-9, 1e-11}}};
  Simulation simulation(system, integrator);
  State state = system.initial_state();
  simulation.run(state, 0.25);
  ASSERT_EQ(simulation.events().size(), 2u);
  EXPECT_EQ(simulation.events()[0].contact.change, ContactChange::meeting);
  EXPECT_EQ(simulation.events()[1].contact.change, ContactChange::parting);
  EXPECT_EQ(simulation.events()[0].contact.b, 1);
}

}  // namespace
}  // namespace lithe::test::impact_events_test
