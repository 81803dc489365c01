#include "engine/observe/event.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "bodies/rigid_body.h"
#include "engine/run/simulation.h"
#include "joints/forces/coordinate_stop.h"
#include "joints/prismatic_joint.h"
#include "tests/support/methods.h"
#include "tests/support/scenes.h"

namespace lithe::test::event_test {

using testing::HasSubstr;

namespace {

constexpr double kGravity = 9.81;

/// Balls above the plane z = 0, at rest.
Scene balls(std::vector<double> heights) {
  return Scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
    for (std::size_t i = 0; i < heights.size(); ++i)
      graph.add<RigidBody>("ball " + std::to_string(i + 1),
                           {.mass = 1, .inertia = {1, 1, 1}, .position = {0, 0, heights[i]}});
  });
}

/// Ball `body` meets the plane and keeps `restitution` of its speed.
Event impact(const Scene& scene, int body, double restitution) {
  const Layout::BodySlice slice = scene.system.layout().bodies()[body];
  return {.name = "impact of " + slice.name,
          .function = [slice](Snapshot& now) { return now.state().q[slice.q + 2]; },
          .direction = Event::Direction::falling,
          .action = Event::Action::restart,
          .change = [slice, restitution](State& state) { state.v[slice.v + 2] *= -restitution; }};
}

/// A pendulum of 1 m, a point mass on a rod, released at rest 90 degrees from below; its height above the pivot is p_y.
EventFunction swing() {
  return [](Snapshot& now) { return now.state().q[0]; };
}

/// Quarter period of a pendulum released at 90 degrees, 1 m: K(1/2) sqrt(L/g).
double quarter_period() { return std::comp_ellint_1(std::sqrt(0.5)) * std::sqrt(1 / kGravity); }

class Times : public Observer {
 public:
  std::vector<double> times;
  void observe(Snapshot& snapshot) override { times.push_back(snapshot.time()); }
};

std::vector<std::pair<std::string, Method>> every_method(double tolerance, double step) {
  std::vector<std::pair<std::string, Method>> all;
  all.emplace_back("explicit Runge-Kutta", runge_kutta(tolerance));
  all.emplace_back("IDA", ida(tolerance));
  all.emplace_back("generalized-alpha, index 3", index3(step));
  all.emplace_back("generalized-alpha, index 2", index2(step));
  return all;
}

}  // namespace

/// Benchmark C01: flights last 2 eⁿ sqrt(2 g h)/g.
TEST(event, a_bouncing_ball_meets_the_plane_at_the_times_of_the_closed_form) {
  Scene scene = balls({1});
  const Method method = runge_kutta(1e-9);
  Simulation simulation{scene.system, *method};
  simulation.on(impact(scene, 0, 0.8));
  simulation.run(scene.state, 3.35);
  ASSERT_EQ(simulation.events().size(), 8u);
  double time = std::sqrt(2 / kGravity), flight = 2 * 0.8 * time, worst = 0;
  for (const EventRecord& e : simulation.events()) {
    EXPECT_EQ(e.name, "impact of ball 1");
    EXPECT_EQ(e.index, 0);
    worst = std::max(worst, std::abs(e.time - time));
    time += flight;
    flight *= 0.8;
  }
  expect_below("impact times of eight bounces, s", worst, 1e-12);
}

TEST(event, a_ball_that_bounces_for_ever_is_told_instead_of_hanging) {
  for (auto& [name, method] : every_method(1e-8, 5e-3)) {
    SCOPED_TRACE(name);
    Scene scene = balls({1});
    Simulation simulation{scene.system, *method};
    simulation.on(impact(scene, 0, 0.8));
    try {
      simulation.run(scene.state, 5);
      FAIL() << "passed the end of all bounces";
    } catch (const SimulationError& error) {
      EXPECT_THAT(error.what(), HasSubstr("events accumulate: 'impact of ball 1'"));
    }
    // All impacts end at sqrt(2 h/g) (1 + e)/(1 - e).
    const double end = std::sqrt(2 / kGravity) * 9;
    expect_below(name + ": accumulation at, s", std::abs(scene.state.time - end), 1e-3);
    EXPECT_GT(scene.state.q[2], -1e-9);
    EXPECT_LT(simulation.events().size(), 100u);
  }
}

TEST(event, two_balls_that_land_at_one_time_both_bounce) {
  Scene scene = balls({1, 1, 1});
  const Method method = runge_kutta(1e-9);
  Simulation simulation{scene.system, *method};
  for (int i : {0, 1, 2}) simulation.on(impact(scene, i, 1));
  simulation.run(scene.state, 2);
  EXPECT_EQ(simulation.events().size(), 6u);  // at 0.45 and 1.35 s
  for (int i : {0, 1, 2})
    EXPECT_NEAR(scene.position(i).z(), 1 - kGravity / 2 * std::pow(2 - 4 * std::sqrt(2 / kGravity), 2), 1e-9);
}

TEST(event, a_pendulum_passes_its_lowest_point_at_the_times_of_the_elliptic_integral) {
  for (auto& [name, method] : every_method(1e-10, 1e-3)) {
    Scene scene = mass_chain({M_PI / 2});
    Simulation simulation{scene.system, *method};
    simulation.on({.name = "lowest", .function = swing()});
    simulation.run(scene.state, 6);
    const double quarter = quarter_period();
    ASSERT_EQ(simulation.events().size(), 5u) << name;
    double worst = 0;
    for (int k = 0; k < 5; ++k) worst = std::max(worst, std::abs(simulation.events()[k].time - (2 * k + 1) * quarter));
    expect_below(name + ": lowest point, s", worst, name.starts_with("gen") ? 3e-5 : 1e-7);
  }
}

/// Order 2 of the method, not of the step that the passage lies in.
TEST(event, times_of_events_converge_with_the_order_of_the_method) {
  const auto error = [](double step) {
    Scene scene = mass_chain({M_PI / 2});
    const Method method = index2(step);
    Simulation simulation{scene.system, *method};
    simulation.on({.name = "lowest", .function = swing()});
    simulation.run(scene.state, 6);
    return std::abs(simulation.events().at(4).time - 9 * quarter_period());
  };
  const double order = std::log2(error(8e-3) / error(4e-3));
  EXPECT_NEAR(order, 2, 0.05);
}

TEST(event, a_recorded_event_leaves_the_integrator_undisturbed) {
  const auto run = [](bool watched) {
    Scene scene = mass_chain({M_PI / 2, M_PI / 3});
    const Method method = runge_kutta(1e-7);
    Simulation simulation{scene.system, *method};
    if (watched) simulation.on({.name = "below", .function = swing()});
    simulation.run(scene.state, 5);
    return scene.state.q;
  };
  EXPECT_EQ(run(true), run(false));
}

TEST(event, each_direction_counts_its_own_passages) {
  Scene scene = mass_chain({M_PI / 2});
  const Method method = runge_kutta(1e-8);
  Simulation simulation{scene.system, *method};
  simulation.on({.name = "leftward", .function = swing(), .direction = Event::Direction::falling});
  simulation.on({.name = "rightward", .function = swing(), .direction = Event::Direction::rising});
  simulation.on({.name = "either", .function = swing()});
  simulation.run(scene.state, 6);
  int count[3] = {0, 0, 0};
  for (const EventRecord& e : simulation.events()) ++count[e.index];
  EXPECT_EQ(count[0], 3);
  EXPECT_EQ(count[1], 2);
  EXPECT_EQ(count[2], 5);
}

/// The ball passes 0.95 of its height on the way up and down, half of a long step.
TEST(event, a_level_passed_there_and_back_within_one_step_is_found_twice) {
  Scene scene(Vector3{0, 0, -kGravity}, [](SystemGraph& graph) {
    graph.add<RigidBody>("ball", {.mass = 1, .inertia = {1, 1, 1}, .velocity = {0, 0, kGravity}});
  });
  const Method method = runge_kutta_fixed(0.4);  // a parabola is exact at any step
  Simulation simulation{scene.system, *method};
  const double top = kGravity / 2, level = top - 0.01;  // passed within 0.09 s
  simulation.on({.name = "near the top", .function = [](Snapshot& now) { return now.state().q[2]; }, .level = level});
  simulation.run(scene.state, 2);
  ASSERT_EQ(simulation.events().size(), 2u);
  const double half = std::sqrt(2 * 0.01 / kGravity);
  EXPECT_NEAR(simulation.events()[0].time, 1 - half, 1e-10);
  EXPECT_NEAR(simulation.events()[1].time, 1 + half, 1e-10);
}

TEST(event, a_stopping_event_ends_the_run_on_the_constraints_and_the_next_run_goes_on) {
  for (auto& [name, method] : every_method(1e-9, 1e-3)) {
    SCOPED_TRACE(name);
    Scene scene = mass_chain({M_PI / 2});
    Simulation simulation{scene.system, *method};
    simulation.on({.name = "lowest", .function = swing(), .action = Event::Action::stop});
    simulation.run(scene.state, 6);
    EXPECT_EQ(simulation.stopped_by(), "lowest");
    EXPECT_NEAR(scene.state.time, quarter_period(), 1e-5);
    EXPECT_LT(std::abs(scene.state.q[0]), 1e-11);
    EXPECT_LT(scene.violation(Level::position), 1e-12);
    EXPECT_LT(scene.violation(Level::velocity), 1e-5);  // index 3 sits h² beside it
    simulation.run(scene.state, 6);
    EXPECT_EQ(simulation.stopped_by(), "lowest");
    EXPECT_NEAR(scene.state.time, 3 * quarter_period(), 2e-5);
    simulation.run(scene.state, scene.state.time + 0.5);
    EXPECT_EQ(simulation.stopped_by(), "");
    EXPECT_EQ(simulation.events().size(), 2u);
  }
}

/// The string is struck: the velocity after the change, -v along the string too, is brought back to the circle.
TEST(event, a_changed_velocity_is_moved_onto_the_constraints) {
  Scene scene = mass_chain({M_PI / 2});
  const Method method = runge_kutta(1e-9);
  Simulation simulation{scene.system, *method};
  simulation.on({.name = "struck", .function = swing(), .action = Event::Action::restart, .change = [](State& state) {
                   state.v.head<3>() = Vector3(1, 5, 0);
                 }});
  simulation.run(scene.state, quarter_period() + 1e-6);
  EXPECT_NEAR(scene.state.v[0], 1, 1e-4);
  EXPECT_NEAR(scene.state.v[1], 0, 1e-4);
  EXPECT_LT(scene.violation(Level::velocity), 1e-12);
}

/// A shuttle at 1 m/s that is set back by 1 m whenever it has come to 1 m: towards the level from far below, its trend
/// is no passage.
TEST(event, a_change_that_moves_its_function_away_from_the_level_happens_once) {
  for (const auto direction : {Event::Direction::both, Event::Direction::rising})
    for (const double back : {1.0, 3e-3}) {  // also within the first half of a step
      Scene scene({0, 0, 0}, [](SystemGraph& graph) {
        graph.add<RigidBody>("shuttle", {.mass = 1, .inertia = {1, 1, 1}, .velocity = {1, 0, 0}});
      });
      const Method method = runge_kutta_fixed(1e-2);
      Simulation simulation{scene.system, *method};
      simulation.on({.name = "set back",
                     .function = [](Snapshot& now) { return now.state().q[0]; },
                     .level = 1,
                     .direction = direction,
                     .action = Event::Action::restart,
                     .change = [back](State& state) { state.q[0] -= back; }});
      const double end = 1 + 3.5 * back;
      simulation.run(scene.state, end);
      ASSERT_EQ(simulation.events().size(), 4u);
      for (int k = 0; k < 4; ++k) EXPECT_NEAR(simulation.events()[k].time, 1 + k * back, 1e-12);
      EXPECT_NEAR(scene.state.q[0], end - 4 * back, 1e-12);
    }
}

TEST(event, observed_times_stay_exact_and_observers_of_every_step_see_the_event) {
  Scene scene = balls({1});
  const Method method = runge_kutta(1e-6);
  Simulation simulation{scene.system, *method};
  simulation.on(impact(scene, 0, 0.8));
  Times hundredths, steps;
  simulation.observe(hundredths, every(0.01));
  simulation.observe(steps, every_step());
  simulation.run(scene.state, 1);
  ASSERT_EQ(hundredths.times.size(), 101u);
  for (int k = 0; k <= 100; ++k) EXPECT_EQ(hundredths.times[k], k * 0.01);
  ASSERT_EQ(simulation.events().size(), 1u);
  EXPECT_THAT(steps.times, testing::Contains(simulation.events()[0].time));
  EXPECT_TRUE(std::is_sorted(steps.times.begin(), steps.times.end()));
  EXPECT_GT(simulation.statistics().steps, 50);  // of both starts
}

TEST(event, what_watches_no_number_or_has_no_name_is_refused) {
  Scene scene = balls({1});
  const Method method = runge_kutta(1e-6);
  Simulation simulation{scene.system, *method};
  EXPECT_THROW(simulation.on({.name = "", .function = swing()}), SceneError);
  EXPECT_THROW(simulation.on({.name = "nothing", .function = nullptr}), SceneError);
  simulation.on({.name = "hole", .function = [](Snapshot& now) {
                   return now.time() > 0.3 ? std::numeric_limits<double>::quiet_NaN() : 1.0;
                 }});
  try {
    simulation.run(scene.state, 1);
    FAIL();
  } catch (const SimulationError& error) {
    EXPECT_THAT(error.what(), HasSubstr("'hole' watches a value that is not finite"));
  }
  EXPECT_LT(scene.state.time, 0.31);  // the last good state
}

namespace {

/// A block of 1 kg falls 0.2 m onto a linear stop: afterwards a sine about its static depth, until it leaves again.
struct Landing {
  static constexpr double kDrop = 0.2, kStiffness = 2e3;
  Landing()
      : scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
          auto& block = graph.add<RigidBody>("block", {.mass = 1, .inertia = {1, 1, 1}});
          auto& slide = graph.add<PrismaticJoint>("slide", {graph.ground().marker(), block.marker()});
          graph.add<CoordinateStop>("stop", {slide.displacement()},
                                    {.lower = -kDrop, .stiffness = kStiffness, .exponent = 1});
        }) {}
  /// Height at time t, before the third contact.
  static double exact(double t) {
    const double impact = std::sqrt(2 * kDrop / kGravity), speed = kGravity * impact;
    const double omega = std::sqrt(kStiffness), depth = kGravity / kStiffness;
    const double contact = 2 * (M_PI / 2 + std::atan2(depth * omega, speed)) / omega;
    const double period = 2 * impact + contact;
    t -= impact;
    while (t > period) t -= period;
    if (t < 0) return -kGravity / 2 * (t + impact) * (t + impact);
    if (t > contact) {
      t -= contact;
      return -kDrop + speed * t - kGravity / 2 * t * t;
    }
    return -kDrop - depth + depth * std::cos(omega * t) - speed / omega * std::sin(omega * t);
  }
  Scene scene;
};

}  // namespace

/// Stability laboratory S31: a kink passed within a step costs the order; a step that ends there keeps it.
TEST(event, a_stop_is_met_at_the_end_of_a_step_so_that_the_order_is_kept) {
  const double end = 0.8;
  const auto located = [&](const Method& method) {
    Landing landing;
    Simulation simulation{landing.scene.system, *method};
    simulation.run(landing.scene.state, end);
    return std::abs(landing.scene.state.q[2] - Landing::exact(end));
  };
  const auto passed = [&](const Method& method) {
    Landing landing;
    landing.scene.run(*method, end);
    return std::abs(landing.scene.state.q[2] - Landing::exact(end));
  };
  const double coarse = located(runge_kutta_fixed(4e-3)), fine = located(runge_kutta_fixed(1e-3));
  expect_below("RK5, h = 4 ms, switches located, m", coarse, 2e-7);
  expect_below("  its order, less than 4.5 by", 4.5 - std::log2(coarse / fine) / 2, 0);
  expect_below("  beside steps that pass over the kink", coarse / passed(runge_kutta_fixed(4e-3)), 1e-3);
  expect_below("RK5(4) at 1e-9, switches located, m", located(runge_kutta(1e-9)), 1e-8);
}

}  // namespace lithe::test::event_test
