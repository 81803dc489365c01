// FMUs for model exchange: models of the Reference FMUs against their published outputs and exact solutions, by all
// kinds of methods; a controller against the same drawn of the engine's own elements; files that are wrong.
#include "models/fmu/model_exchange_fmu.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "bodies/integral_state.h"
#include "engine/archive/archive.h"
#include "engine/assembly/batch_of.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/pid_controller.h"
#include "joints/revolute_joint.h"
#include "tests/models/fmu/arm.h"
#include "tests/models/fmu/drive_fmu.h"
#include "tests/models/fmu/test_fmu.h"
#include "tests/support/message_of.h"
#include "tests/support/methods.h"

namespace lithe::test::model_exchange_fmu_test {
namespace {

using Reads = ModelExchangeFmu::Reads;
constexpr double kGravity = 9.81, kRestitution = 0.7;

std::string reference(const std::string& file) {
  std::ifstream in(std::string(LITHE_TEST_DATA) + "/fmi/reference-fmus/" + file);
  EXPECT_TRUE(in) << file;
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Numbers of a table, without its line of names.
std::vector<std::vector<double>> table(const std::string& file) {
  std::istringstream in(reference(file));
  std::vector<std::vector<double>> out;
  std::string line;
  for (std::getline(in, line); std::getline(in, line);) {
    out.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) out.back().push_back(std::stod(cell));
  }
  return out;
}

/// One of the Reference FMUs.
TestFmu model(int version, const std::string& name) {
  return {version, name, LITHE_TEST_EQUATIONS + name + ".so",
          reference(name + ".FMI" + std::to_string(version) + ".modelDescription.xml")};
}

/// A scene with an FMU and nothing else.
struct Alone {
  Alone(const TestFmu& file, Method with, ModelExchangeFmu::Parameters parameters = {})
      : fmu(graph, "fmu", file.packed(), std::move(parameters)), method(std::move(with)), system(assemble(graph)) {
    fmu.join(simulation);
  }
  double value(const std::string& variable) {
    Snapshot now(system, state);
    return fmu.sensor(variable).value(now);
  }
  double run(double end, const std::string& variable) {
    simulation.run(state, end);
    return value(variable);
  }

  SystemGraph graph{{.gravity = {0, 0, -9.81}}};  // states have no weight
  ModelExchangeFmu fmu;
  Method method;
  System system;
  Simulation simulation{system, *method};
  State state = system.initial_state();
};

struct Tried {
  const char* name;
  Method (*make)();
  double bound;    // of relative errors over some seconds of slow motion
  double impacts;  // of the times of impacts, s
};
const Tried kMethods[] = {
    {"automatic", [] { return automatic(1e-8); }, 1e-7, 1e-6},
    {"runge_kutta", [] { return runge_kutta(1e-9); }, 1e-7, 1e-6},
    {"radau", [] { return radau(1e-9); }, 1e-7, 1e-6},
    {"bdf", [] { return bdf(1e-8); }, 1e-5, 1e-4},
    {"ida", [] { return ida(1e-9); }, 1e-5, 1e-4},
    {"index3", [] { return index3(1e-3); }, 1e-6, 2e-4},
    {"index2", [] { return index2(1e-3); }, 1e-6, 2e-4},
};

class ByMethod : public testing::TestWithParam<std::tuple<Tried, int>> {
 protected:
  const Tried& method() const { return std::get<0>(GetParam()); }
  int version() const { return std::get<1>(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(Fmu, ByMethod, testing::Combine(testing::ValuesIn(kMethods), testing::Values(2, 3)),
                         [](const auto& tested) {
                           return std::string(std::get<0>(tested.param).name) +
                                  (std::get<1>(tested.param) == 2 ? "_two" : "_three");
                         });

TEST_P(ByMethod, a_decay_is_the_exponential_function) {
  Alone decay(model(version(), "Dahlquist"), method().make(), {.values = {{"k", 1.5}}});
  EXPECT_EQ(decay.value("x"), 1);
  EXPECT_EQ(decay.value("der(x)"), -1.5);
  EXPECT_NEAR(decay.run(2, "x") / std::exp(-3.0), 1, method().bound);
}

TEST_P(ByMethod, an_oscillator_follows_its_equations_integrated_by_hand) {
  Alone oscillator(model(version(), "VanDerPol"), method().make());
  Eigen::Vector2d x(2, 0);
  const auto f = [](const Eigen::Vector2d& at) { return Eigen::Vector2d(at[1], (1 - at[0] * at[0]) * at[1] - at[0]); };
  constexpr double h = 1e-3;
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector2d k1 = f(x), k2 = f(x + h / 2 * k1), k3 = f(x + h / 2 * k2), k4 = f(x + h * k3);
    x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  EXPECT_NEAR(oscillator.run(4, "x0"), x[0], 50 * method().bound);
  EXPECT_NEAR(oscillator.value("x1"), x[1], 50 * method().bound);
}

TEST_P(ByMethod, a_ball_bounces_at_the_times_and_with_the_speeds_of_the_impact_law) {
  Alone ball(model(version(), "BouncingBall"), method().make());
  // Exact: falls from 1 m, each flight e times as long as the one before.
  std::vector<double> times = {std::sqrt(2 / kGravity)};
  double speed = kGravity * times[0] * kRestitution;
  for (; speed >= 0.1; speed *= kRestitution) times.push_back(times.back() + 2 * speed / kGravity);
  Recorder flight({ball.fmu.sensor("h"), ball.fmu.sensor("v")});
  ball.simulation.observe(flight, every(0.01));
  ball.simulation.run(ball.state, 3);
  const auto& events = ball.simulation.events();
  ASSERT_EQ(events.size(), times.size());
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_EQ(events[i].name, "fmu: state event 1");
    EXPECT_NEAR(events[i].time, times[i], method().impacts) << i;
  }
  EXPECT_NEAR(ball.value("h"), 0, 1e-12);  // at rest, where the FMU puts it
  EXPECT_EQ(ball.value("v"), 0);
  // The published output is Euler's with steps of 1 ms, at whose ends it finds impacts: it errs by 24 mm.
  const auto published = table("BouncingBall_out.csv");
  double worst = 0;
  for (std::size_t i = 0; i < published.size(); ++i)
    worst = std::max(worst, std::abs(flight.table().at(static_cast<int>(i), 1) - published[i][1]));
  EXPECT_LT(worst, 0.025);
}

TEST_P(ByMethod, a_stair_steps_at_its_times_and_ends_the_simulation) {
  Alone stair(model(version(), "Stair"), method().make());
  const auto published = table("Stair_out.csv");
  for (std::size_t i = 1; i < published.size() - 1; ++i) {
    // A moment before and after: what it is at the very second depends on round-off of the others' times.
    if (i % 5 == 0) {
      EXPECT_EQ(stair.run(published[i][0] - 1e-6, "counter"), published[i][1] - 1);
      EXPECT_EQ(stair.run(published[i][0] + 1e-6, "counter"), published[i][1]);
    } else {
      EXPECT_EQ(stair.run(published[i][0], "counter"), published[i][1]) << published[i][0];
    }
  }
  ASSERT_EQ(stair.simulation.events().size(), 8);
  for (int i = 0; i < 8; ++i) EXPECT_NEAR(stair.simulation.events()[i].time, i + 1, 1e-14 * (i + 1));
  expect_says(message_of<SimulationError>([&] { stair.simulation.run(stair.state, 10); }),
              {"asks to end the simulation", "FMU 'fmu', t = 9 s"});
}

TEST(ModelExchangeFmu, has_an_event_that_it_asks_for_after_a_step) {
  for (const int version : {2, 3}) {
    TestFmu file = model(version, "Dahlquist");
    file.describe(replaced(
        reference("Dahlquist.FMI" + std::to_string(version) + ".modelDescription.xml"), "</ModelVariables>",
        version == 2 ? "<ScalarVariable name=\"kick\" valueReference=\"4\" causality=\"parameter\" "
                       "variability=\"fixed\"><Real start=\"0\"/></ScalarVariable></ModelVariables>"
                     : "<Float64 name=\"kick\" valueReference=\"4\" causality=\"parameter\" variability=\"fixed\" "
                       "start=\"0\"/></ModelVariables>"));
    Alone decay(file, index2(0.01), {.values = {{"kick", 0.505}}});
    decay.simulation.run(decay.state, 1);
    ASSERT_EQ(decay.simulation.events().size(), 1);
    const double at = decay.simulation.events()[0].time;
    EXPECT_NEAR(at, 0.51, 1e-12);
    EXPECT_NEAR(decay.value("x"), (std::exp(-at) + 1) * std::exp(at - 1), 1e-5);
  }
}

TEST(ModelExchangeFmu, that_is_stiff_costs_implicit_methods_few_steps) {
  constexpr double kMu = 1000;  // relaxation: x0 slides from 2 to 1 in about (3 - 2 ln 2) / 2 · mu s
  for (const bool exact : {true, false}) {
    TestFmu file = model(2, "VanDerPol");
    std::string text = reference("VanDerPol.FMI2.modelDescription.xml");
    if (!exact) text = replaced(text, "providesDirectionalDerivative=\"true\"", "");
    file.describe(text);
    for (auto* make : {+[] { return radau(1e-6); }, +[] { return bdf(1e-6); }}) {
      Alone oscillator(file, make(), {.values = {{"mu", kMu}}});
      // On the slow branch x1 = x0 / (mu (1 - x0²)), so ln x0 - x0²/2 grows by t / mu.
      const double x = oscillator.run(500, "x0");
      EXPECT_NEAR(std::log(x) - x * x / 2, std::log(2.0) - 2 + 500 / kMu, 1e-4);
      expect_below("steps of " + oscillator.method->name(), oscillator.simulation.statistics().steps, 200);
    }
  }
}

// ---- a controller, beside the engine's own elements ----

constexpr double kTarget = 0.4, kProportional = 12, kIntegral = 40, kDerivative = 0.5;

/// The drive's equations as an element: with a lag, which the PidController does not have. Coordinates: the angle, the
/// integral's, the current's.
class LaggedPid final : public Force</*markers=*/6, /*rows=*/0> {
 public:
  struct Parameters {
    double lag = 0;  // s
  };
  LaggedPid(CoordinateSet coordinates, Parameters p) : coordinates_(std::move(coordinates)), lag_(p.lag) {}
  std::vector<MeasuredAngle> angles() const override { return coordinates_.angles(); }
  void evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const override {
    const MeasuredCoordinate x = coordinates_.measure(0, markers, rows),
                             integral = coordinates_.measure(1, markers, rows),
                             current = coordinates_.measure(2, markers, rows);
    const double e = kTarget - x.value, wanted = kProportional * e + kIntegral * integral.rate - kDerivative * x.rate;
    const auto push = [&](std::size_t first, const MeasuredCoordinate& c, double by) {
      rows.add_load(markers[first], by * c.on_A);
      rows.add_load(markers[first + 1], by * c.on_B);
    };
    push(0, x, current.rate);
    push(2, integral, e);
    push(4, current, (wanted - current.rate) / lag_);
  }

 private:
  const CoordinateSet coordinates_;
  const double lag_;
};

struct Arm {
  Arm(bool flexible, Method with)
      : hinge(graph.add<RevoluteJoint>("hinge", {graph.ground().marker({}, kAlongY), arm_root(graph, flexible)})),
        method(std::move(with)) {
    graph.add<CoordinateSpring>("bearing", {hinge.angle()}, {.damping = 0.05});
  }
  static ModelExchangeFmu::Parameters wires(const RevoluteJoint& hinge, double lag, double fault = 0) {
    return {.inputs = {{"motion[1]", hinge.angle()}, {"motion[2]", hinge.angle(), Reads::rate}},
            .laws = {{"target", constant(kTarget)}},
            .outputs = {{"torque", hinge.angle()}},
            .values = {{"gains[1]", kProportional},
                       {"gains[2]", kIntegral},
                       {"gains[3]", kDerivative},
                       {"lag", lag},
                       {"fault", fault}}};
  }
  void by_fmu(const TestFmu& file, double lag, double fault = 0) {
    fmu.emplace(graph, "drive", file.packed(), wires(hinge, lag, fault));
    finish();
    fmu->join(*simulation);
  }
  void by_elements(double lag) {
    auto& memory = graph.add<IntegralState>("memory");
    if (lag > 0) {
      auto& current = graph.add<IntegralState>("current");
      graph.add<LaggedPid>("drive", {hinge.angle(), memory.coordinate(), current.coordinate()}, {.lag = lag});
    } else {
      graph.add<PidController>("drive", {hinge.angle(), memory.coordinate()},
                               {.target = constant(kTarget),
                                .proportional = kProportional,
                                .integral = kIntegral,
                                .derivative = kDerivative});
    }
    finish();
  }
  void finish() {
    system = std::make_unique<System>(assemble(graph));
    simulation = std::make_unique<Simulation>(*system, *method);
    state = system->initial_state();
  }
  double run(double end) {
    simulation->run(state, end);
    Snapshot now(*system, state);
    return coordinate(hinge.angle(), "angle").value(now);
  }

  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  RevoluteJoint& hinge;
  Method method;
  std::optional<ModelExchangeFmu> fmu;
  std::unique_ptr<System> system;
  std::unique_ptr<Simulation> simulation;
  State state;
};

class Driven : public testing::TestWithParam<std::tuple<Tried, int, bool, double>> {};
INSTANTIATE_TEST_SUITE_P(Fmu, Driven,
                         testing::Combine(testing::ValuesIn(kMethods), testing::Values(2, 3), testing::Bool(),
                                          testing::Values(0, 0.002)),
                         [](const auto& of) {
                           return std::string(std::get<0>(of.param).name) +
                                  (std::get<1>(of.param) == 2 ? "_two" : "_three") +
                                  (std::get<2>(of.param) ? "_flexible" : "_rigid") +
                                  (std::get<3>(of.param) > 0 ? "_lagged" : "");
                         });

TEST_P(Driven, the_arm_moves_as_under_the_same_controller_of_the_engines_elements) {
  const auto& [method, version, flexible, lag] = GetParam();
  // Elements of scalar bodies give implicit methods nothing of a lag: the reference for it is explicit.
  const bool same_method = lag == 0;
  Arm a(flexible, method.make()), b(flexible, same_method ? method.make() : runge_kutta(1e-9));
  a.by_fmu(drive_fmu(version), lag);
  b.by_elements(lag);
  for (const double end : {0.1, 0.3}) {
    const double angle = a.run(end);
    EXPECT_NEAR(angle, b.run(end), (same_method ? 1 : 20) * method.bound) << end;
  }
  EXPECT_GT(std::abs(a.run(0.3)), 0.05);
}

// ---- runs ----

TEST(ModelExchangeFmu, goes_on_from_a_checkpoint_with_the_same_bits) {
  // Between bounces, and at rest, where the FMU has changed its gravity.
  for (const auto& [version, saved] : {std::pair(2, 1.0), std::pair(3, 2.9)})
    for (const Tried& method : kMethods) {
      const TestFmu file = model(version, "BouncingBall");
      Alone first(file, method.make()), second(file, method.make());
      first.simulation.run(first.state, saved);
      Archive archive;
      first.simulation.save(first.state, archive);
      archive.rewind();
      second.state = second.simulation.resume(archive);
      EXPECT_EQ(second.value("g"), first.value("g"));
      for (Alone* ball : {&first, &second}) ball->simulation.run(ball->state, saved + 0.5);
      EXPECT_EQ(first.state.v, second.state.v) << method.name;
      EXPECT_EQ(first.state.v_dot, second.state.v_dot) << method.name;
      EXPECT_EQ(second.value("g"), saved < 2 ? -kGravity : 0);
    }
}

TEST(ModelExchangeFmu, starts_anew_when_told_so) {
  const TestFmu file = model(3, "BouncingBall");
  Alone ball(file, runge_kutta(1e-8));
  const double there = ball.run(1, "h");
  ball.state = ball.system.initial_state();
  expect_says(message_of<SimulationError>([&] { ball.simulation.run(ball.state, 1); }),
              {"has passed an event at t = 0.", "reset()", "'fmu'"});
  ball.fmu.reset();
  ball.state = ball.system.initial_state();
  EXPECT_EQ(ball.run(1, "h"), there);
  // Before any event it starts anew by itself.
  Alone early(file, runge_kutta(1e-8));
  const double soon = early.run(0.3, "h");
  early.state = early.system.initial_state();
  EXPECT_EQ(early.run(0.3, "h"), soon);
}

TEST(ModelExchangeFmu, says_what_it_is_and_how_it_is_connected) {
  Arm arm(false, radau(1e-6));
  arm.by_fmu(drive_fmu(3), 0.1);
  expect_says(arm.fmu->describe(), {"FMU 'drive': Drive, FMI 3.0, made by a text editor; 2 states, 0 event indicators",
                                    "input motion [1] from a coordinate [2] from the rate of a coordinate",
                                    "input target from a function of time\n", "output torque [N.m] to a coordinate",
                                    "parameter lag = 0.1", "parameter gains [1] = 12 [2] = 40 [3] = 0.5"});
}

// ---- what goes wrong ----

TEST(ModelExchangeFmu, refuses_wires_that_do_not_fit) {
  const auto refused = [&](int version,
                           const std::function<void(ModelExchangeFmu::Parameters&, const RevoluteJoint&)>& change,
                           const std::string& text = "") {
    const TestFmu file = drive_fmu(version);
    if (!text.empty()) file.describe(text);
    Arm arm(false, radau(1e-6));
    auto wires = Arm::wires(arm.hinge, 0);
    change(wires, arm.hinge);
    return message_of<Error>([&] { ModelExchangeFmu(arm.graph, "drive", file.packed(), wires); });
  };
  EXPECT_EQ(refused(3, [](auto&, auto&) {}), "");
  expect_says(refused(2, [](auto& w, auto&) { w.inputs[0].variable = "angle"; }), {"it has no input 'angle'"});
  expect_says(refused(2, [](auto& w, auto&) { w.outputs[0].variable = "target"; }), {"'target' is no output"});
  expect_says(refused(2, [](auto& w, auto&) { w.laws[0].variable = "switch"; }),
              {"'switch' is a discrete Int32", "continuous Float64"});
  expect_says(refused(2, [](auto& w, auto&) { w.laws[0].law = {}; }), {"'target' has no law"});
  expect_says(refused(2, [](auto& w, auto&) { w.laws.push_back(w.laws[0]); }), {"'target' is connected twice"});
  expect_says(refused(3, [](auto& w, auto&) { w.inputs[1].variable = "motion[1]"; }),
              {"'motion[1]' is connected twice"});
  expect_says(refused(3, [](auto& w, auto&) { w.inputs[0].variable = "motion"; }),
              {"'motion' is an array of 2", "'motion[1]'"});
  expect_says(refused(3, [](auto& w, auto&) { w.inputs[0].variable = "motion[3]"; }), {"no 'motion[3]'"});
  expect_says(refused(3, [](auto& w, auto&) { w.inputs[0].variable = "motion[0]"; }), {"no input 'motion[0]'"});
  expect_says(refused(2, [](auto& w, auto&) { w.values[0].second = NAN; }), {"'gains[1]' is not finite"});
  expect_says(refused(2,
                      [](auto& w, auto& hinge) {
                        for (int i = 2; i < 130; ++i) {
                          JointCoordinate other = hinge.angle();
                          other.sign = i;
                          w.outputs.push_back({"torque", other});
                        }
                      }),
              {"129 coordinates and 2 states are more than there is room for"});
  expect_says(refused(
                  2, [](auto&, auto&) {}, replaced(kDrive2, "<ModelExchange", "<CoSimulation")),
              {"not for model exchange", "ImportedFmu"});
  expect_says(refused(
                  2, [](auto&, auto&) {}, replaced(kDrive2, "derivative=\"5\"", "derivative=\"99\"")),
              {"no variable 6 is the derivative of another", "modelDescription.xml:"});
  expect_says(
      refused(
          2, [](auto&, auto&) {}, replaced(kDrive2, "numberOfEventIndicators=\"0\"", "numberOfEventIndicators=\"-1\"")),
      {"numberOfEventIndicators is no whole number"});
  expect_says(refused(
                  3, [](auto&, auto&) {}, replaced(kDrive3, "start=\"1 0 0\"", "start=\"1 0\"")),
              {"'gains' has 2 start values for 3 numbers"});
  expect_says(refused(
                  3, [](auto&, auto&) {}, replaced(kDrive3, "derivative=\"5\"", "derivative=\"77\"")),
              {"no variable has the value reference 77"});
}

TEST(ModelExchangeFmu, ends_the_run_with_its_message_and_the_time_where_it_fails) {
  for (const int version : {2, 3}) {
    const TestFmu file = drive_fmu(version);
    const auto failing = [&](double fault, Method method) {
      Arm arm(false, std::move(method));
      arm.by_fmu(file, 0, fault);
      const std::string said = message_of<SimulationError>([&] { arm.run(1); });
      EXPECT_NEAR(arm.state.time, 0.1, 0.02);  // the state is the last good one
      return said;
    };
    for (auto* make : {+[] { return runge_kutta(1e-6); }, +[] { return radau(1e-6); }, +[] { return index3(1e-3); }}) {
      expect_says(failing(1, make()), {"'drive'", "gives a value that is not finite at t = 0.1"});
      expect_says(failing(2, make()), {"'drive'", "gives an error: the amplifier is too hot", "t = 0.1"});
      expect_says(failing(3, make()), {"'drive'", "gives a value that is not finite at t = 0.1"});
      expect_says(failing(4, make()), {"asks to end the simulation", "FMU 'drive', t = 0.1"});
    }
  }
}

TEST(ModelExchangeFmu, needs_a_simulation_and_one_alone) {
  const TestFmu file = model(2, "Dahlquist");
  Alone decay(file, radau(1e-6));
  expect_says(message_of<SceneError>([&] { decay.fmu.join(decay.simulation); }), {"has joined a simulation before"});
  SystemGraph graph;
  ModelExchangeFmu forgotten(graph, "decay", file.packed(), {});
  const System system = assemble(graph);
  const Method method = radau(1e-6);
  Simulation simulation{system, *method};
  State state = system.initial_state();
  expect_says(message_of<SimulationError>([&] { simulation.run(state, 1); }), {"nobody looks for the FMU's events"});
  graph.add<RigidBody>("apart", {.mass = 1, .inertia = {1, 1, 1}});
  Simulation islands{graph, [] { return radau(1e-6); }};
  EXPECT_NE(message_of<SceneError>([&] { forgotten.join(islands); }), "");
}

TEST(ModelExchangeFmu, that_cannot_give_its_state_has_no_checkpoints) {
  const TestFmu file = drive_fmu(2);
  file.describe(replaced(kDrive2, "canSerializeFMUstate=\"true\"", ""));
  Arm arm(false, radau(1e-6));
  arm.by_fmu(file, 0);
  arm.run(0.1);
  Archive archive;
  expect_says(message_of<SceneError>([&] { arm.simulation->save(arm.state, archive); }),
              {"cannot give its state", "checkpoints"});
}

}  // namespace
}  // namespace lithe::test::model_exchange_fmu_test
