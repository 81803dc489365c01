// Inputs: quantities given from outside while a run goes on.
#include "engine/model/input.h"

#include <gtest/gtest.h>

#include "bodies/flexible/flexible_body.h"
#include "bodies/integral_state.h"
#include "bodies/rigid_body.h"
#include "engine/observe/recorder.h"
#include "integrators/generalized_alpha.h"
#include "joints/coordinate_drive.h"
#include "joints/distance_joint.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/distributed_load.h"
#include "joints/forces/pid_controller.h"
#include "joints/forces/point_force.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "joints/revolute_joint.h"
#include "tests/engine/output/output_scratch_folder.h"
#include "tests/integrators/restart_scenes.h"
#include "tests/support/message_of.h"
#include "tests/support/motion.h"

namespace lithe::test::input_test {
namespace {

using namespace restart;
using Between = Input::Between;

// ---- as a function of time ----

TEST(Input, goes_from_sample_to_sample_as_it_was_drawn) {
  SystemGraph graph;
  for (const Between between : {Between::held, Between::linear, Between::smooth}) {
    const auto kind = static_cast<int>(between);
    auto& u = graph.add<Input>("u" + std::to_string(kind), {.unit = "N", .value = 2, .between = between});
    EXPECT_EQ(u.value(-3), 2);
    EXPECT_EQ(u.value(9), 2);
    u.set(1, 2), u.set(3, 6), u.set(4, 5);
    EXPECT_EQ(u.value(0.5), 2);
    EXPECT_EQ(u.value(7), 5);
    EXPECT_NEAR(u.value(2), between == Between::held ? 2 : 4, 1e-15);
    EXPECT_NEAR(u.value(1.5),
                between == Between::held     ? 2
                : between == Between::linear ? 3
                                             : 2 + 4 * 0.103515625,
                1e-15);
    EXPECT_EQ(u.value(3), 6);
    u.end_at(3);  // what ends there sees what is before
    EXPECT_EQ(u.value(3), between == Between::held ? 2 : 6);
    EXPECT_EQ(u.at(3).rate, between == Between::linear ? 2 : 0);
    u.end_at(INFINITY);
    EXPECT_EQ(u.at(3).rate, between == Between::linear ? -1 : 0);
    const MotionLaw law = u;
    EXPECT_EQ(Input::of(law), &u);
    for (double t : {0.7, 1.3, 2.2, 3.6, 4.5}) {
      EXPECT_NEAR(law(t).rate, derivative([&](double h) { return law(t + h).value; }, 1e-4), 1e-9);
      EXPECT_NEAR(law(t).acceleration, derivative([&](double h) { return law(t + h).rate; }, 1e-4), 1e-9);
    }
  }
  EXPECT_EQ(Input::of(ramp(0, 1)), nullptr);
}

TEST(Input, refuses_what_it_cannot_be) {
  SystemGraph graph;
  auto& torque = graph.add<Input>("torque", {.unit = "N m", .value = 1, .lower = -2, .upper = 3});
  expect_says(message_of<Error>([&] { torque.set(1, 4); }), {"'torque'", "4 N m", "-2 to 3", "input_test.cpp"});
  expect_says(message_of<Error>([&] { torque.set(1, NAN); }), {"'torque'", "nan", "not finite"});
  expect_says(message_of<Error>([&] { torque.set(INFINITY, 1); }), {"'torque'", "not finite"});
  expect_says(message_of<Error>([&] { torque.reset(0, -2.5); }), {"'torque'", "-2.5"});
  torque.set(1, 2);
  expect_says(message_of<Error>([&] { torque.set(0.5, 2); }),
              {"'torque'", "t = 0.5 s", "before its last sample at t = 1 s"});
  EXPECT_EQ(torque.samples().size(), 2u);
  expect_says(message_of<Error>([&] { graph.add<Input>("torque"); }), {"'torque' is in use"});
  expect_says(message_of<Error>([&] { graph.add<Input>("ground"); }), {"'ground'"});
  expect_says(message_of<Error>([&] { graph.add<Input>("a", {.lower = 2, .upper = 1}); }), {"'a'", "bounds 2 and 1"});
  expect_says(message_of<Error>([&] { graph.add<Input>("b", {.value = 5, .upper = 1}); }), {"'b'", "5"});
  expect_says(message_of<Error>([&] { graph.add<Input>("c", {.value = NAN}); }), {"'c'", "not finite"});
  graph.add<Input>("length", {.unit = "m"});
  EXPECT_EQ(&graph.input("torque"), &torque);
  EXPECT_EQ(graph.find<Input>("torque"), &torque);
  expect_says(message_of<Error>([&] { graph.input("torqe"); }),
              {"no input 'torqe'", "'torque', 'length'", "input_test.cpp"});
  // A motion must not jump; a stiffness not become negative.
  auto& rod = graph.add<RigidBody>("rod", {.mass = 1, .inertia = {1, 1, 1}, .position = {1, 0, 0}});
  auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker(), rod.marker({-1, 0, 0})});
  expect_says(message_of<Error>([&] { graph.add<CoordinateDrive>("drive", {pin.angle()}, {.motion = torque}); }),
              {"'drive'", "'torque'", "jumps", "smooth"});
  expect_says(message_of<Error>([&] {
                graph.add<DistanceJoint>("bar", {graph.ground().marker(), rod.marker()}, {.length_law = torque});
              }),
              {"'bar'", "'torque'", "jumps"});
  expect_says(message_of<Error>([&] {
                graph.add<SpringDamper>("spring", {graph.ground().marker(), rod.marker()}, {.stiffness = torque});
              }),
              {"'spring'", "stiffness (input 'torque')", "-2"});
}

// ---- bit for bit the run with a function ----

/// Each place that takes an input, once with it and once with what it replaces: smooth from 0.3 to 0.5 within the
/// second tenth, or constant 0.5 where an element takes a number. On a rigid or a flexible rod.
struct Use {
  const char* name;
  std::function<void(SystemGraph& graph, const Input* input, RevoluteJoint& pin, Marker tip)> draw;
};

const Input::Parameters kSmooth{.value = 0.3, .lower = 0, .upper = 1, .between = Between::smooth};
const Input::Parameters kConstant{.value = 0.5, .lower = 0, .upper = 1};

const std::vector<Use>& uses() {
  const auto law = [](const Input* u) { return u ? MotionLaw(*u) : smooth_step(0.3, 0.5, 0.1, 0.2); };
  const auto number = [](const Input* u) { return u ? Adjustable(*u) : Adjustable(0.5); };
  static const std::vector<Use> all = {
      {"smooth drive",
       [=](SystemGraph& graph, const Input* u, RevoluteJoint& pin, Marker) {
         graph.add<CoordinateDrive>("element", {pin.angle()}, {.motion = constant(-0.3) + law(u)});
       }},
      {"smooth motor",
       [=](SystemGraph& graph, const Input* u, RevoluteJoint& pin, Marker) {
         std::function<double(double, double, double)> effort;
         if (u)
           effort = *u;
         else
           effort = [step = law(u)](double t, double, double) { return step(t).value; };
         graph.add<CoordinateMotor>("element", {pin.angle()}, {.effort = effort});
       }},
      {"smooth target",
       [=](SystemGraph& graph, const Input* u, RevoluteJoint& pin, Marker) {
         auto& memory = graph.add<IntegralState>("memory");
         graph.add<PidController>("element", {pin.angle(), memory.coordinate()},
                                  {.target = law(u), .proportional = 8, .integral = 2, .derivative = 0.3});
       }},
      {"smooth user force",
       [=](SystemGraph& graph, const Input* u, RevoluteJoint&, Marker tip) {
         graph.add<UserForce>("element", {tip}, {[of = law(u)](double t, const MarkerView&) {
                                return force({0, 0, of(t).value});
                              }});
       }},
      {"smooth amplitude",
       [=](SystemGraph& graph, const Input* u, RevoluteJoint&, Marker tip) {
         graph.add<DistributedLoad>("element", {tip},
                                    {.forces = {{0, 0, 2}}, .axes = DistributedLoad::Axes::world, .amplitude = law(u)});
       }},
      {"smooth length",
       [=](SystemGraph& graph, const Input* u, RevoluteJoint&, Marker tip) {
         // A ball at the end of a rod that telescopes from the tip.
         auto& ball =
             graph.add<RigidBody>("ball", {.mass = 0.1, .inertia = {1e-4, 1e-4, 1e-4}, .position = {0.4, 0, -0.3}});
         graph.add<DistanceJoint>("element", {tip, ball.marker()}, {.length_law = law(u)});
       }},
      {"constant spring",
       [=](SystemGraph& graph, const Input* u, RevoluteJoint&, Marker tip) {
         graph.add<SpringDamper>(
             "element", {graph.ground().marker({0.2, 0, 0.3}), tip},
             {.stiffness = number(u), .damping = number(u), .natural_length = number(u), .preload = number(u)});
       }},
      {"constant clock spring",
       [=](SystemGraph& graph, const Input* u, RevoluteJoint& pin, Marker) {
         graph.add<CoordinateSpring>(
             "element", {pin.angle()},
             {.stiffness = number(u), .damping = number(u), .free_value = number(u), .preload = number(u)});
       }},
      {"constant factor",
       [=](SystemGraph& graph, const Input* u, RevoluteJoint&, Marker tip) {
         if (u)
           graph.add<PointForce>("element", {tip}, {.force = {0, 0, 2}, .factor = *u});
         else
           graph.add<PointForce>("element", {tip}, {.force = {0, 0, 1}});
       }},
  };
  return all;
}

struct Pendulum {
  SystemGraph graph;
  Input* input = nullptr;
  std::unique_ptr<System> system;
  Method method;
  std::unique_ptr<Simulation> simulation;
  State state;

  Pendulum(const Use& use, bool flexible, bool by_input, const MakeMethod& make) {
    const bool smooth = std::string(use.name).starts_with("smooth");
    if (by_input) input = &graph.add<Input>("u", smooth ? kSmooth : kConstant);
    Marker tip;
    RevoluteJoint* pin;
    if (flexible) {
      draw_flexible(graph);
      pin = graph.find<RevoluteJoint>("pin");
      tip = graph.find<FlexibleBody>("rod")->node(rod_modes()->node_ids.back());
    } else {
      auto& rod = graph.add<RigidBody>("rod", {.mass = 0.5, .inertia = {1e-3, 5e-3, 5e-3}, .position = {0.2, 0, 0}});
      pin = &graph.add<RevoluteJoint>("pin",
                                      {graph.ground().marker({0, 0, 0}, kAxisY), rod.marker({-0.2, 0, 0}, kAxisY)});
      tip = rod.marker({0.2, 0, 0});
    }
    use.draw(graph, input, *pin, tip);
    if (by_input && smooth) input->set(0.1, 0.3), input->set(0.2, 0.5);
    system = std::make_unique<System>(assemble(graph));
    method = make(*system);
    simulation = std::make_unique<Simulation>(*system, *method);
    state = system->initial_state();
  }
};

TEST(Input, runs_bit_for_bit_as_the_function_that_it_is) {
  for (const bool flexible : {false, true})
    for (const Use& use : uses())
      for (const std::size_t m : {std::size_t{0}, std::size_t{1}, smooth_methods().size() - 1}) {
        SCOPED_TRACE(std::string(use.name) + (flexible ? " flexible " : " rigid ") + smooth_methods()[m].name);
        Pendulum by_input(use, flexible, true, smooth_methods()[m].make),
            by_function(use, flexible, false, smooth_methods()[m].make);
        for (const double end : {0.13, 0.3}) {
          by_input.simulation->run(by_input.state, end);
          by_function.simulation->run(by_function.state, end);
          EXPECT_EQ(by_input.state.q, by_function.state.q);
          EXPECT_EQ(by_input.state.v, by_function.state.v);
          EXPECT_EQ(by_input.state.v_dot, by_function.state.v_dot);
          EXPECT_EQ(by_input.simulation->statistics().steps, by_function.simulation->statistics().steps);
        }
        EXPECT_GT((by_input.state.q - by_input.system->initial_state().q).norm(), 1e-3);
      }
}

// ---- jumps and bends ----

/// A shaft of inertia J about z under a torque.
struct Shaft {
  static constexpr double kInertia = 0.4;
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  RigidBody& body = graph.add<RigidBody>("shaft", {.mass = 1, .inertia = {kInertia, kInertia, kInertia}});
  RevoluteJoint& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker(), body.marker()});

  double angle(const System& system, const State& state) const {
    Snapshot now(system, state);
    return coordinate(pin.angle(), "angle").value(now);
  }
  double speed(const System& system, const State& state) const {
    Snapshot now(system, state);
    return coordinate_rate(pin.angle(), "speed").value(now);
  }
};

/// Between jumps of the torque φ̈ = T/J: every method is exact to its tolerance, wherever they fall.
TEST(Input, jumps_end_steps_and_keep_the_order_of_methods) {
  for (const auto& [name, make] : smooth_methods()) {
    SCOPED_TRACE(name);
    Shaft shaft;
    auto& torque = shaft.graph.add<Input>("torque", {.unit = "N m", .value = 0.8});
    shaft.graph.add<CoordinateMotor>("motor", {shaft.pin.angle()}, {.effort = torque});
    torque.set(0.1234, -2), torque.set(0.3171, 5);
    const System system = assemble(shaft.graph);
    const Method method = make(system);
    Simulation simulation{system, *method};
    State state = system.initial_state();
    Recorder record{{input_value(torque), coordinate_acceleration(shaft.pin.angle(), "a")}};
    simulation.observe(record, every_step());
    simulation.run(state, 0.25);
    torque.set(0.4, 1);
    simulation.run(state, 0.5);
    double angle = 0, speed = 0, at = 0;
    for (const auto& [until, T] : {std::pair(0.1234, 0.8), {0.3171, -2.0}, {0.4, 5.0}, {0.5, 1.0}}) {
      const double h = until - at, a = T / Shaft::kInertia;
      angle += h * speed + h * h * a / 2, speed += h * a, at = until;
    }
    EXPECT_NEAR(shaft.speed(system, state), speed, 1e-6);
    // Exact to the tolerance of 1e-6 a step; fixed steps of 2 ms of first order err by some h² φ̈ a jump.
    const bool low_order = std::string(name) == "bdf_fixed" || std::string(name) == "linearly_implicit";
    EXPECT_NEAR(shaft.angle(system, state), angle, low_order ? 1e-3 : 1e-5);
    // What is told at a jump belongs together: the old torque, the old acceleration.
    const std::vector<double> T = record.table().column("torque"), a = record.table().column("a");
    const std::vector<double> times = record.table().column("t");
    EXPECT_EQ(std::count(times.begin(), times.end(), 0.1234), 1);
    EXPECT_EQ(std::count(times.begin(), times.end(), 0.4), 1);
    for (std::size_t i = 0; i < T.size(); ++i) EXPECT_NEAR(a[i], T[i] / Shaft::kInertia, 1e-5) << times[i];
  }
}

/// A controller on a computer: an observer reads the angle each 10 ms and sets the torque that is held until the next.
/// The sampled system is a recursion in closed form.
TEST(Input, is_set_by_observers_while_a_run_goes_on) {
  class Controller final : public Observer {
   public:
    Controller(Input& torque, const RevoluteJoint& pin)
        : torque_(torque), angle_(coordinate(pin.angle(), "angle")), speed_(coordinate_rate(pin.angle(), "speed")) {}
    void observe(Snapshot& now) override {
      torque_.set(now.time(), 3 * (1 - angle_.value(now)) - 0.5 * speed_.value(now));
    }

   private:
    Input& torque_;
    Sensor angle_, speed_;
  };
  for (const std::size_t m : {std::size_t{0}, std::size_t{1}, smooth_methods().size() - 1})
    for (const bool at_once : {false, true}) {
      Shaft shaft;
      auto& torque = shaft.graph.add<Input>("torque", {.unit = "N m"});
      shaft.graph.add<CoordinateMotor>("motor", {shaft.pin.angle()}, {.effort = torque});
      const System system = assemble(shaft.graph);
      const Method method = smooth_methods()[m].make(system);
      Simulation simulation{system, *method};
      Controller controller(torque, shaft.pin);
      simulation.observe(controller, every(0.01));
      State state = system.initial_state();
      for (int k = 1; !at_once && k < 50; ++k) simulation.run(state, 0.013 * k > 0.65 ? 0.65 : 0.013 * k);
      simulation.run(state, 0.65);
      double angle = 0, speed = 0;
      for (int k = 0; k < 65; ++k) {
        const double h = 0.01, a = (3 * (1 - angle) - 0.5 * speed) / Shaft::kInertia;
        angle += h * speed + h * h * a / 2, speed += h * a;
      }
      EXPECT_NEAR(shaft.angle(system, state), angle, 2e-6) << smooth_methods()[m].name;
      EXPECT_NEAR(shaft.speed(system, state), speed, 1e-5) << smooth_methods()[m].name;
    }
}

/// A straight line from sample to sample: the drive turns the shaft at the line's slope, with a knock at each bend.
TEST(Input, knocks_where_a_drive_bends) {
  for (const std::size_t m : {std::size_t{0}, smooth_methods().size() - 1}) {
    Shaft shaft;
    auto& target = shaft.graph.add<Input>("target", {.unit = "rad", .between = Between::linear});
    shaft.graph.add<CoordinateDrive>("drive", {shaft.pin.angle()}, {.motion = target});
    target.set(0.1, 0), target.set(0.2, 0.5), target.set(0.4, 0.3);
    const System system = assemble(shaft.graph);
    const Method method = smooth_methods()[m].make(system);
    Simulation simulation{system, *method};
    State state = system.initial_state();
    for (const auto& [time, angle, speed] :
         std::vector<std::array<double, 3>>{{0.05, 0, 0}, {0.15, 0.25, 5}, {0.3, 0.4, -1}, {0.5, 0.3, 0}}) {
      simulation.run(state, time);
      EXPECT_NEAR(shaft.angle(system, state), angle, 1e-9);
      EXPECT_NEAR(shaft.speed(system, state), speed, 1e-6);
    }
  }
}

// ---- kept ----

TEST(Input, is_kept_in_checkpoints_bit_for_bit) {
  const ScratchFolder folder;
  for (const bool flexible : {false, true})
    for (const auto& [name, make] : smooth_methods())
      for (const double saved : {0.1, 0.173}) {  // at a jump, and between
        SCOPED_TRACE(std::string(name) + (flexible ? " flexible " : " rigid ") + std::to_string(saved));
        const Use push{"held push", [](SystemGraph& graph, const Input* u, RevoluteJoint&, Marker tip) {
                         graph.add<PointForce>("push", {tip}, {.force = {0, 0, 2}, .factor = *u});
                       }};
        Pendulum whole(push, flexible, true, make), resumed(push, flexible, true, make);
        whole.input->set(0.1, 0.9), whole.input->set(0.21, 0.1);
        whole.simulation->run(whole.state, saved);
        whole.input->set(0.25, 1);
        whole.simulation->save(whole.state, folder.path("run.h5"));
        whole.simulation->run(whole.state, 0.3);
        resumed.input->set(3, 0.2);  // forgotten
        resumed.state = resumed.simulation->resume(folder.path("run.h5"));
        EXPECT_EQ(resumed.input->samples().size(), 4u);
        resumed.simulation->run(resumed.state, 0.3);
        EXPECT_TRUE(same(whole.state, resumed.state));
      }
  // Another input, or none: another scene.
  SystemGraph graph;
  draw_flexible(graph);
  graph.add<Input>("w");
  const System system = assemble(graph);
  GeneralizedAlpha method{{.step = 1e-3}};
  Simulation simulation{system, method};
  expect_says(message_of<Error>([&] { simulation.resume(folder.path("run.h5")); }), {"another scene"});
}

/// Islands meet where observers wait; each ends its own steps at the jumps of what acts on it.
TEST(Input, acts_in_islands_as_in_the_whole) {
  double angles[2];
  for (const bool split : {false, true}) {
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    auto& torque = graph.add<Input>("torque", {.unit = "N m", .value = 0.8});
    std::vector<Sensor> watched;
    for (const char* name : {"a", "b"}) {
      auto& body = graph.add<RigidBody>(name, {.mass = 1, .inertia = {0.4, 0.4, 0.4}});
      auto& pin = graph.add<RevoluteJoint>(std::string("pin ") + name, {graph.ground().marker(), body.marker()});
      if (*name == 'a')
        graph.add<CoordinateMotor>("motor", {pin.angle()}, {.effort = torque});
      else
        graph.add<PointForce>("push", {body.marker()}, {.torque = {0, 0, 1}, .factor = torque});
      watched.push_back(coordinate(pin.angle(), name));
    }
    Recorder record{watched};
    Simulation simulation{graph,
                          [] { return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = 1e-3}); },
                          {.split = split}};
    simulation.observe(record, every(0.1));
    State state = simulation.start();
    torque.set(0.0505, -1);
    simulation.run(state, 0.2);
    torque.set(0.2, 2);
    simulation.run(state, 0.4);
    const int last = record.table().row_count() - 1;
    EXPECT_NEAR(record.table().at(last, 1), record.table().at(last, 2), 1e-12);
    angles[split] = record.table().at(last, 1);
    EXPECT_EQ(simulation.islands().size(), split ? 2u : 1u);
  }
  EXPECT_NEAR(angles[0], angles[1], 1e-12);
}

}  // namespace
}  // namespace lithe::test::input_test
