#include "engine/run/simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bodies/rigid_body.h"
#include "engine/assembly/system.h"
#include "engine/model/system_graph.h"
#include "engine/observe/recorder.h"
#include "engine/observe/stop_run.h"
#include "integrators/generalized_alpha.h"
#include "joints/fixed_joint.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/revolute_joint.h"
#include "tests/engine/output/output_scratch_folder.h"

namespace lithe::test::simulation_test {

using lithe::test::message_of;
using testing::DoubleEq;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pointwise;

namespace {

/// A slender rod of 1 m and 2 kg, pinned at one end, horizontal, free to swing about y.
struct Pendulum {
  Pendulum() {
    const Matrix3 y_axis = rotation_about({1, 0, 0}, -M_PI / 2);  // marker z along world y
    rod = &graph.add<RigidBody>("rod",
                                {.mass = 2, .inertia = {1e-4, 2.0 / 12, 2.0 / 12}, .position = Vector3(0.5, 0, 0)});
    graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, y_axis), rod->marker({-0.5, 0, 0}, y_axis)});
    tip = rod->marker({0.5, 0, 0});
  }
  SystemGraph graph;
  RigidBody* rod;
  Marker tip;
};

/// Moves time alone, in steps of at most 1/32 s; goes wrong after `end`.
class Clock : public Integrator {
 public:
  enum class Trouble { none, fails, not_a_number, stuck, throws } trouble = Trouble::none;
  double step_size = 1.0 / 32, end = 0.5;
  int starts = 0;

  std::string name() const override { return "clock"; }
  void prepare(EquationsOfMotion& equations, State& state) override {
    ++starts;
    state.v_dot.setZero(equations.layout().v_count());
    state.lambda.setZero(equations.layout().row_count());
  }
  StepResult advance(EquationsOfMotion&, State& state, double t_stop) override {
    if (trouble != Trouble::none && state.time + step_size > end) {
      state.v[0] = 7;  // spoilt on the way
      if (trouble == Trouble::fails) return {StepResult::Outcome::failed, "it strikes thirteen"};
      if (trouble == Trouble::throws) throw std::domain_error("broken spring");
      if (trouble == Trouble::stuck) return {};
      state.v[4] = std::numeric_limits<double>::quiet_NaN();
    }
    state.time = std::min(state.time + step_size, t_stop);
    ++statistics_.steps;
    return {};
  }
  const IntegratorStatistics& statistics() const override { return statistics_; }

 private:
  IntegratorStatistics statistics_;
};

/// Remembers the times it was told of.
class Witness : public Observer {
 public:
  std::vector<double> times;
  void observe(Snapshot& snapshot) override { times.push_back(snapshot.time()); }
};

struct Clockwork : Pendulum {
  const System system = assemble(graph);
  State state = system.initial_state();
  Clock clock;
  Simulation simulation{system, clock};
};

}  // namespace

TEST(simulation, observed_times_are_exact_multiples_of_the_interval) {
  Clockwork c;
  Witness witness;
  c.simulation.observe(witness, every(0.01));
  c.simulation.run(c.state, 3.0);
  ASSERT_EQ(witness.times.size(), 301u);
  for (int k = 0; k < 300; ++k) EXPECT_EQ(witness.times[k], k * 0.01);  // not a sum of steps
  EXPECT_EQ(witness.times.back(), 3.0);
  EXPECT_EQ(c.state.time, 3.0);
}

TEST(simulation, an_end_off_the_schedule_is_reached_and_not_observed) {
  Clockwork c;
  Witness witness;
  c.simulation.observe(witness, every(0.1));
  c.simulation.run(c.state, 0.25);
  EXPECT_EQ(c.state.time, 0.25);
  EXPECT_THAT(witness.times, ElementsAre(0, 0.1, 0.2));
}

TEST(simulation, observers_with_different_schedules_each_get_their_own_times) {
  Clockwork c;
  c.clock.step_size = 0.04;
  Witness tenths, fifteenths, steps;
  c.simulation.observe(tenths, every(0.1));
  c.simulation.observe(fifteenths, every(0.15));
  c.simulation.observe(steps, every_step());
  c.simulation.run(c.state, 0.3);
  EXPECT_THAT(tenths.times, ElementsAre(0, 0.1, 0.2, 0.3));
  EXPECT_THAT(fifteenths.times, ElementsAre(0, 0.15, 0.3));
  // Steps cut at observed times; 3 · 0.1 and 2 · 0.15 differ by round-off and are one.
  const std::vector<double> all = {0, 0.04, 0.08, 0.1, 0.14, 0.15, 0.19, 0.2, 0.24, 0.28, 0.3};
  EXPECT_THAT(steps.times, Pointwise(DoubleEq(), all));
}

TEST(simulation, schedules_that_differ_by_round_off_make_no_tiny_steps) {
  Clockwork c;
  c.clock.step_size = 0.06;
  c.state.time = -0.9;  // 9 · 0.1 - 0.9 = 0, 3 · 0.3 - 0.9 = -1.1e-16
  Witness tenths, thirds, steps;
  c.simulation.observe(tenths, every(0.1));
  c.simulation.observe(thirds, every(0.3));
  c.simulation.observe(steps, every_step());
  c.simulation.run(c.state, 0.9);
  EXPECT_EQ(tenths.times.size(), 19u);
  EXPECT_EQ(thirds.times.size(), 7u);
  for (std::size_t i = 1; i < steps.times.size(); ++i) EXPECT_GT(steps.times[i] - steps.times[i - 1], 0.03);
}

TEST(simulation, two_runs_are_one) {
  Pendulum p;
  const System system = assemble(p.graph);
  const auto run = [&](std::vector<double> ends, Recorder& recorder) {
    State state = system.initial_state();
    GeneralizedAlpha integrator{{.step = 1e-3}};
    Simulation simulation{system, integrator};
    simulation.observe(recorder, every(0.05));
    for (double end : ends) simulation.run(state, end);
    EXPECT_EQ(simulation.statistics().steps, 2000);
    return state;
  };
  Recorder once{{position(p.tip, "tip")}}, twice{{position(p.tip, "tip")}};
  const State a = run({2.0}, once), b = run({1.0, 2.0}, twice);
  EXPECT_EQ(once.table().row_count(), 41);
  EXPECT_EQ(once.table().values, twice.table().values);
  EXPECT_EQ(a.q, b.q);
  EXPECT_EQ(a.v, b.v);
}

TEST(simulation, a_changed_state_starts_anew) {
  Clockwork c;
  Witness witness, late;
  c.simulation.observe(witness, every(0.1));
  c.simulation.run(c.state, 0.15);
  c.simulation.run(c.state, 0.2);
  EXPECT_EQ(c.clock.starts, 1);
  c.state.v[4] = 1;  // struck
  c.simulation.observe(late, every(0.1));
  c.simulation.run(c.state, 0.35);
  EXPECT_EQ(c.clock.starts, 2);
  EXPECT_THAT(witness.times, ElementsAre(0, 0.1, 0.2, 0.2, DoubleEq(0.3)));  // before and after the blow
  EXPECT_THAT(late.times, ElementsAre(0.2, DoubleEq(0.3)));

  // The same integrator at work elsewhere: its history is lost.
  Simulation other{c.system, c.clock};
  State another = c.system.initial_state();
  other.run(another, 0.1);
  c.simulation.run(c.state, 0.5);
  EXPECT_EQ(c.clock.starts, 4);
}

TEST(simulation, a_failure_is_named_and_loses_nothing) {
  Clockwork c;
  c.clock.trouble = Clock::Trouble::fails;
  Recorder recorder{{position(c.tip, "tip")}};
  c.simulation.observe(recorder, every(0.375));
  const std::string message = message_of<SimulationError>([&] { c.simulation.run(c.state, 2.0); });
  EXPECT_THAT(message, HasSubstr("the step from t = 0.5 s failed: it strikes thirteen"));
  EXPECT_THAT(message, HasSubstr("at:   t = 0.5 s, clock"));
  EXPECT_THAT(message, HasSubstr("fix:  give a smaller step"));
  EXPECT_THAT(recorder.table().column("t"), ElementsAre(0, 0.375, 0.5));  // the last good state too
  EXPECT_EQ(c.state.time, 0.5);
  EXPECT_EQ(c.state.v[0], 0);  // what the failed step spoilt

  c.clock.trouble = Clock::Trouble::none;  // fixed: goes on, on the old schedule
  c.simulation.run(c.state, 1.0);
  EXPECT_THAT(recorder.table().column("t"), ElementsAre(0, 0.375, 0.5, 0.75));
}

TEST(simulation, a_coordinate_that_is_no_number_ends_the_run_by_name) {
  Clockwork c;
  c.clock.trouble = Clock::Trouble::not_a_number;
  Witness witness;
  c.simulation.observe(witness, every_step());
  EXPECT_THAT(message_of<SimulationError>([&] { c.simulation.run(c.state, 2.0); }),
              HasSubstr("not finite: velocity of rod: omega_y"));
  EXPECT_EQ(c.state.time, 0.5);
  EXPECT_TRUE(c.state.v.allFinite());
  EXPECT_EQ(witness.times.size(), 17u);
}

TEST(simulation, an_integrator_that_stands_still_or_throws_ends_the_run) {
  Clockwork c;
  c.clock.trouble = Clock::Trouble::stuck;
  EXPECT_THAT(message_of<SimulationError>([&] { c.simulation.run(c.state, 2.0); }),
              HasSubstr("to t = 2 s ended at t = 0.5 s"));
  c.clock.trouble = Clock::Trouble::throws;
  EXPECT_THAT(message_of<SimulationError>([&] { c.simulation.run(c.state, 2.0); }),
              HasSubstr("clock threw: broken spring\n  at:   t = 0.5 s"));
  EXPECT_EQ(c.state.v[0], 0);
}

/// x of the link is 1e-3 off the axis that the angle turns about: it is lost there, and steps that turn with it end
/// where they began.
TEST(simulation, steps_that_vanish_or_fail_where_an_angle_is_lost_name_its_joint) {
  SystemGraph graph;
  auto& link = graph.add<RigidBody>("link", {.orientation = rotation_about({0, 1, 0}, M_PI / 2 - 1e-3)});
  graph.add<CoordinateSpring>("closer",
                              {JointCoordinate{JointCoordinate::Kind::angle, graph.ground().marker(), link.marker()}},
                              {.stiffness = 1});
  const System system = assemble(graph);
  State state = system.initial_state();
  Clock clock;
  clock.trouble = Clock::Trouble::stuck;
  Simulation simulation(system, clock);
  const std::string message = message_of<SimulationError>([&] { simulation.run(state, 2.0); });
  EXPECT_THAT(message,
              HasSubstr("the step from t = 0.5 s became shorter than time can tell: the angle that 'closer' ("));
  EXPECT_THAT(message, HasSubstr("measures jumps by half a turn"));
  EXPECT_THAT(message, HasSubstr("is 0.057 degrees from the axis that it turns about"));
  EXPECT_THAT(message, HasSubstr("fix:  keep the two apart"));

  clock.trouble = Clock::Trouble::fails;
  state = system.initial_state();
  const std::string failed = message_of<SimulationError>([&] { simulation.run(state, 2.0); });
  EXPECT_THAT(failed, HasSubstr("failed: it strikes thirteen; the angle that 'closer' ("));
  EXPECT_THAT(failed, HasSubstr("fix:  keep the two apart"));
}

/// A joint is as drawn, but the base that it is on has become a part of the ground.
TEST(simulation, an_angle_that_is_lost_is_found_in_a_simpler_scene_too) {
  SystemGraph graph;
  auto& base = graph.add<RigidBody>("base");
  auto& link = graph.add<RigidBody>("link", {.orientation = rotation_about({0, 1, 0}, M_PI / 2 - 1e-3)});
  graph.add<FixedJoint>("mount", {graph.ground().marker(), base.marker()});
  graph.add<CoordinateSpring>("closer", {JointCoordinate{JointCoordinate::Kind::angle, base.marker(), link.marker()}},
                              {.stiffness = 1});
  const auto make = [] {
    auto clock = std::make_unique<Clock>();
    clock->trouble = Clock::Trouble::stuck;
    return clock;
  };
  Simulation simulation(graph, make, {.simplify = true, .sleep = false});
  State state = simulation.start();
  EXPECT_THAT(message_of<SimulationError>([&] { simulation.run(state, 2.0); }), HasSubstr("the angle that 'closer' ("));
}

TEST(simulation, a_run_that_makes_no_sense_is_refused) {
  Clockwork c;
  EXPECT_THAT(message_of<SceneError>([&] { c.simulation.run(c.state, -1); }), HasSubstr("from t = 0 s to t = -1 s"));
  EXPECT_THROW(c.simulation.run(c.state, std::nan("")), SceneError);
  State empty;
  EXPECT_THAT(message_of<SceneError>([&] { c.simulation.run(empty, 1); }), HasSubstr("system.initial_state()"));
  c.state.q[5] = std::nan("");  // e_y
  EXPECT_THAT(message_of<SceneError>([&] { c.simulation.run(c.state, 1); }), HasSubstr("rod: omega_y"));
  EXPECT_THROW(every(0), SceneError);
  EXPECT_THROW(every(std::nan("")), SceneError);
  EXPECT_EQ(c.clock.starts, 0);
}

/// It asks at each state; whoever is observed after it is told too.
TEST(simulation, an_observer_that_always_asks_for_the_end_ends_the_run) {
  Clockwork c;
  struct Impatient final : Observer {
    int calls = 0;
    void observe(Snapshot& /*now*/) override {
      if (++calls > 100) throw std::logic_error("it is told without end");
      throw StopRun{""};
    }
  } impatient;
  Witness witness;
  c.simulation.observe(impatient, every(0.25));
  c.simulation.observe(witness, every_step());
  c.simulation.run(c.state, 2.0);
  EXPECT_EQ(c.state.time, 0);
  EXPECT_EQ(c.simulation.stopped_by(), "an observer");
  c.simulation.run(c.state, 2.0);  // told of the start already
  EXPECT_EQ(c.state.time, 0.25);
  EXPECT_EQ(impatient.calls, 2);
  EXPECT_EQ(witness.times.size(), 9u);

  c.clock.trouble = Clock::Trouble::fails;
  impatient.calls = 0;
  c.clock.end = 0.3;
  EXPECT_THROW(c.simulation.run(c.state, 2.0), SimulationError);
  EXPECT_EQ(impatient.calls, 1);
}

TEST(simulation, looking_does_not_change_the_motion) {
  Pendulum p;
  const System system = assemble(p.graph);
  const auto end_of_run = [&](bool watched) {
    State state = system.initial_state();
    GeneralizedAlpha integrator{{.step = 1e-3}};
    Simulation simulation{system, integrator};
    Recorder recorder{{total_energy(), constraint_residual()}};
    if (watched) simulation.observe(recorder, every_step());
    simulation.run(state, 0.5);
    return state;
  };
  EXPECT_EQ(end_of_run(true).q, end_of_run(false).q);
}

}  // namespace lithe::test::simulation_test
