// Impacts against closed forms and figures computed to many digits elsewhere: the reference problems C01 (bouncing
// ball), C04 (rocking block) and C05 (cradle).
#include <gtest/gtest.h>

#include "tests/reference/contact_scene.h"

namespace lithe::test::contact_impacts_test {
namespace {

constexpr double g = 9.81;

class ImpactsBy : public testing::TestWithParam<Stepper> {};
INSTANTIATE_TEST_SUITE_P(Steppers, ImpactsBy, testing::Values(Stepper::moreau_jean, Stepper::generalized_alpha),
                         [](const auto& tested) {
                           return tested.param == Stepper::moreau_jean ? "MoreauJean" : "NonsmoothGeneralizedAlpha";
                         });

// ---- C01: a ball dropped from 1 m, restitution 0.8 ----

/// Times at which the ball meets the plane: first flight, then flights shorter by the restitution each time.
double impact_time(int n) {
  double time = std::sqrt(2 / g);
  for (int i = 1; i <= n; ++i) time += 2 * std::pow(0.8, i) * std::sqrt(2 / g);
  return time;
}

struct Bounces {
  std::vector<double> times, apexes;
  double deepest = 0;
  State end;
};

/// From the states at the steps' ends: where the flight before a bounce meets the plane, how high the one after it
/// goes.
Bounces bounce(Stepper stepper, double step, double end) {
  ContactScene scene;
  auto& ball = scene.sphere("ball", 0.1, 1, {0, 0, 1.1});
  const auto& contact = scene.contact({scene.plane(), {ball.marker(), shape::sphere(0.1)}}, 0, 0.8);
  scene.start(stepper, step);
  const Sensor overlap = penetration(contact);
  Bounces found;
  double t = 0, z = 1, w = 0;
  while (t < end - step / 2) {
    scene.step();
    const double z_now = scene.state().q[2] - 0.1, w_now = scene.state().v[2];
    if (w_now > w && w_now > 0 && found.times.size() < 20) {
      found.times.push_back(t + (w + std::sqrt(w * w + 2 * g * z)) / g);
      found.apexes.push_back(z_now + w_now * w_now / (2 * g));
    }
    found.deepest = std::max(found.deepest, scene.read(overlap));
    t = scene.state().time, z = z_now, w = w_now;
  }
  found.end = scene.state();
  return found;
}

TEST_P(ImpactsBy, bounces_at_the_exact_times_whatever_the_step) {
  for (const double step : {1e-2, 1e-3, 1e-4}) {
    const Bounces found = bounce(GetParam(), step, step > 1e-4 ? 5 : 3.6);
    ASSERT_GE(found.times.size(), 10u);
    for (int n = 0; n < 10; ++n) {
      EXPECT_NEAR(found.times[n], impact_time(n), 1e-10) << "impact " << n << " at steps of " << step;
      EXPECT_NEAR(found.apexes[n], std::pow(0.64, n + 1), 1e-10);
    }
    EXPECT_LE(found.deepest, 1e-12);
    if (step == 1e-4) continue;
    EXPECT_EQ(found.end.v.norm(), 0) << "at rest after infinitely many impacts";
    EXPECT_NEAR(found.end.q[2], 0.1, 1e-12);
  }
}

TEST(ContactImpacts, a_ball_meets_the_plane_by_events_at_the_exact_times) {
  ContactScene scene;
  auto& ball = scene.sphere("ball", 0.1, 1, {0, 0, 1.1});
  const auto& contact =
      scene.graph.add<Contact>("floor", {scene.plane(), {ball.marker(), shape::sphere(0.1)}}, {.law = Sensing{}});
  const System system = assemble(scene.graph);
  Automatic integrator{{.tolerance = {.relative = 1e-10, .absolute = 1e-12}}};
  Simulation simulation(system, integrator);
  simulation.on({.name = "impact",
                 .function = watch(gap(contact, 0, 1, 10)),
                 .direction = Event::Direction::falling,
                 .action = Event::Action::restart,
                 .change = [](State& state) { state.v[2] *= -0.8; }});
  State state = system.initial_state();
  simulation.run(state, 3.6);
  ASSERT_EQ(simulation.events().size(), 10u);
  for (int n = 0; n < 10; ++n) EXPECT_NEAR(simulation.events()[n].time, impact_time(n), 1e-9);
}

TEST(ContactImpacts, a_compliant_ball_leaves_with_the_speed_that_its_dissipation_follows_from) {
  ContactScene scene{{0, 0, 0}};
  auto& ball = scene.sphere("ball", 0.1, 1, {0, 0, 0.101}, {0, 0, -2});
  scene.graph.add<Contact>(
      "floor", {scene.plane(), {ball.marker(), shape::sphere(0.1)}},
      {.law = Compliance{.stiffness = 1e7, .restitution = 0.8, .dissipation = Dissipation::flores}});
  const System system = assemble(scene.graph);
  Automatic integrator{{.tolerance = {.relative = 1e-9, .absolute = 1e-11}}};
  Simulation simulation(system, integrator);
  State state = system.initial_state();
  simulation.run(state, 0.02);
  // Flores: D v = 8/5 (1 - e)/e = 0.4, and (1 + r) D v = ln((1 + D v)/(1 - r D v)).
  double r = 0.8;
  for (int i = 0; i < 50; ++i) r -= (0.4 * (1 + r) - std::log(1.4 / (1 - 0.4 * r))) / (0.4 - 0.4 / (1 - 0.4 * r));
  EXPECT_NEAR(r, 0.8, 0.03);
  EXPECT_NEAR(state.v[2], 2 * r, 1e-6);
}

// ---- C04: a block that rocks from corner to corner ----

TEST_P(ImpactsBy, a_rocking_block_meets_the_floor_as_housner_says) {
  const double slenderness = std::atan(1.0 / 3), tilt = slenderness / 2, radius = std::hypot(0.1, 0.3);
  ContactScene scene;
  // On its right lower corner, which is at the origin, tilted clockwise about y.
  const Matrix3 tilted = Eigen::AngleAxisd(tilt, Vector3::UnitY()).matrix();
  auto& block = scene.box("block", {0.2, 0.4, 0.6}, 1, tilted * Vector3(-0.1, 0, 0.3), tilted);
  scene.contact({scene.plane(), {block.marker(), shape::box({0.2, 0.4, 0.6})}}, 1);
  scene.start(GetParam(), 2e-4);
  ASSERT_NEAR(scene.state().q[2], radius * std::cos(slenderness - tilt), 1e-12);

  const double times[] = {0.27385897478235164, 0.66685096503369134, 0.97375719445625835, 1.2217689191048935,
                          1.4258341729354329};
  int impacts = 0;
  double angle = tilt, rate = 0;
  while (impacts < 5 && scene.state().time < 1.6) {
    const double before = scene.state().time;
    scene.step();
    const double angle_now = 2 * scene.state().q[5], rate_now = scene.state().v[4];
    if (angle * angle_now < 0) {
      const double t = before + 2e-4 * angle / (angle - angle_now);
      EXPECT_NEAR(t, times[impacts], 1e-3);
      EXPECT_NEAR(rate_now / rate, 0.85, 0.0085) << "at impact " << impacts;
      ++impacts;
    }
    if (angle_now != 0) angle = angle_now, rate = rate_now;
  }
  EXPECT_EQ(impacts, 5);
}

// ---- C05: Newton's cradle ----

struct Cradle {
  std::vector<double> speeds, masses;
  double gap = 0;
};

VectorX collide(const Cradle& cradle, Impacts impacts) {
  ContactScene scene{{0, 0, 0}};
  std::vector<Collider> colliders;
  const int n = static_cast<int>(cradle.speeds.size());
  double x = 0;
  for (int i = 0; i < n; ++i) {
    // Those that move come from 10 mm before the first at rest.
    auto& ball = scene.sphere("ball" + std::to_string(i), 0.1, cradle.masses[i], {x, 0, 0}, {cradle.speeds[i], 0, 0});
    colliders.push_back({ball.marker(), shape::sphere(0.1)});
    x += 0.2 + (cradle.speeds[i] > 0 && i + 1 < n && cradle.speeds[i + 1] == 0 ? 0.0102 : cradle.gap);
  }
  scene.contact(colliders, 0, 1, /*rest_speed=*/0);
  scene.start(Stepper::moreau_jean, 1e-3, {.impacts = impacts, .tolerance = 1e-10});
  scene.run(0.05);
  VectorX speeds(n);
  for (int i = 0; i < n; ++i) speeds[i] = scene.state().v[6 * i];
  return speeds;
}

TEST(ContactImpacts, balls_in_a_row_share_an_impact_by_the_law_that_is_asked_for) {
  const auto near = [](const VectorX& found, std::initializer_list<double> expected, double bound) {
    int i = 0;
    for (const double x : expected) EXPECT_NEAR(found[i++], x, bound) << "ball " << i;
  };
  const Cradle three{{1, 0, 0}, {1, 1, 1}}, five{{1, 0, 0, 0, 0}, {1, 1, 1, 1, 1}};
  const Cradle two_arrive{{1, 1, 0, 0, 0}, {1, 1, 1, 1, 1}}, heavy{{1, 0, 0}, {1, 2, 1}};
  near(collide(three, Impacts::simultaneous), {-1.0 / 3, 2.0 / 3, 2.0 / 3}, 1e-9);
  near(collide(five, Impacts::simultaneous), {-0.6, 0.4, 0.4, 0.4, 0.4}, 1e-9);
  near(collide(two_arrive, Impacts::simultaneous), {-0.2, -0.2, 0.8, 0.8, 0.8}, 1e-9);
  near(collide(heavy, Impacts::simultaneous), {-0.5, 0.5, 0.5}, 1e-9);
  near(collide(three, Impacts::sequential), {0, 0, 1}, 1e-12);
  near(collide(five, Impacts::sequential), {0, 0, 0, 0, 1}, 1e-12);
  near(collide(two_arrive, Impacts::sequential), {0, 0, 0, 1, 1}, 1e-12);
  near(collide(heavy, Impacts::sequential), {-1.0 / 3, 2.0 / 9, 8.0 / 9}, 1e-12);
  near(collide({{1, 0, 0, 0, 0}, {1, 1, 1, 1, 1}, 1e-6}, Impacts::sequential), {0, 0, 0, 0, 1}, 1e-12);
}

TEST(ContactImpacts, elastic_balls_in_touch_leave_as_hertz_has_it) {
  for (const auto& [n, first, last] : {std::tuple(3, -0.07095235362800865, 0.9945493143924421),
                                       std::tuple(5, -0.0710850136977438, 0.9887774230395607)}) {
    ContactScene scene{{0, 0, 0}};
    std::vector<Collider> colliders;
    for (int i = 0; i < n; ++i) {
      auto& ball = scene.sphere("ball" + std::to_string(i), 0.1, 1, {0.2 * i, 0, 0}, {i == 0 ? 1.0 : 0.0, 0, 0});
      colliders.push_back({ball.marker(), shape::sphere(0.1)});
    }
    scene.graph.add<Contact>("balls", colliders, {.law = Compliance{.stiffness = 1e8}});
    const System system = assemble(scene.graph);
    Automatic integrator{{.tolerance = {.relative = 1e-9, .absolute = 1e-11}}};
    Simulation simulation(system, integrator);
    State state = system.initial_state();
    simulation.run(state, 0.05);
    EXPECT_NEAR(state.v[0], first, 1e-6);
    EXPECT_NEAR(state.v[6 * (n - 1)], last, 1e-6);
    // From the start on they press or part: gaps that are 0 but for round-off are no meetings.
    EXPECT_EQ(std::count_if(simulation.events().begin(), simulation.events().end(),
                            [](const EventRecord& e) { return e.contact.change == ContactChange::parting; }),
              n - 1);
    EXPECT_EQ(simulation.events().size(), n - 1u);
    EXPECT_LT(simulation.statistics().steps, 500);
  }
}

}  // namespace
}  // namespace lithe::test::contact_impacts_test
