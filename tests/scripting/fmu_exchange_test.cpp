// FMUs for model exchange: integrated by importers of our own, and compared with the native run, with closed forms and
// with differences.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <random>

#include "lithe/lithe.h"
#include "tests/scripting/command.h"
#include "tests/scripting/exchange_importers.h"
#include "tests/scripting/exchange_instances.h"
#include "tests/scripting/fmu_importer.h"
#include "tests/support/message_of.h"

namespace lithe::test::fmu_exchange_test {
namespace arm {
#include "examples/studies/driven_arm.cpp"
}
namespace pendulum {
#include "tests/scripting/fmu_pendulum.cpp"
}
namespace {

using Form = ImportedInstance::Form;

constexpr int kDiscard = 2, kError = 3;  // of both standards

struct Case {
  const char* file;
  StudyScene scene;
  const char* other;      // the input that is not held
  double start;           // of it
  int version;            // of the description; the library has both
  double h;               // of the importer's steps
  double error, of_pose;  // of all outputs, of angle and tip: accelerations of fast modes err most
};

/// What every FMU owes to an importer that integrates it.
void drive(const Case& c) {
  const ScriptFolder scratch;
  const UnpackedFmu fmu(scratch, c.file, c.version);
  ASSERT_TRUE(std::filesystem::exists(fmu.library));
  const FmuLibrary library(fmu.library);
  const unsigned torque = fmu.reference("torque"), stiffness = fmu.reference("stiffness"),
                 other = fmu.reference(c.other), first = fmu.reference("angle");
  Native native(c.scene);
  const int n = native.system.layout().q_count() + native.system.layout().v_count();
  const auto count = static_cast<std::size_t>(n);
  const auto kinks = static_cast<int>(find_kinks(native.system).size());
  const auto begin = [&](ImportedInstance& one) {
    ASSERT_TRUE(one.exists()) << one.log.text;
    EXPECT_EQ(one.set(torque, 0.5) | one.set(stiffness, 1.7) | one.set(other, c.start), 0) << one.log.text;
    EXPECT_EQ(one.start(), 0) << one.log.text;
  };

  expect_valid_description(scratch, c.version);
  // Without these calls nobody would measure drift.
  if (c.version == 3)
    EXPECT_EQ(fmu.attribute("needsCompletedIntegratorStep"), "true");
  else
    EXPECT_EQ(fmu.attribute("completedIntegratorStepNotNeeded"), "");

  // 1. The native run, by either standard; torque and stiffness change on the way.
  native.graph.input("torque").reset(0, 0.5);
  native.graph.input("stiffness").reset(0, 1.7);
  native.graph.input(c.other).reset(0, c.start);
  const Values middle = native.at(0.3);
  const State at_middle = native.state;
  native.graph.input("torque").reset(0.3, -0.75);
  native.graph.input("stiffness").reset(0.3, 3);
  const Values end = native.at(0.6);
  std::vector<unsigned> outputs(end.size());
  for (std::size_t i = 0; i < outputs.size(); ++i) outputs[i] = first + static_cast<unsigned>(i);
  Values values;
  for (const int version : {2, 3}) {
    ImportedInstance one(library, fmu.token(), version, false, Form::model_exchange);
    begin(one);
    Importer importer(one, n, kinks);
    importer.run(0.3, c.h);
    EXPECT_EQ(one.get(outputs, values), 0);
    const double at_03 = difference(values, middle);
    EXPECT_LT(at_03, c.error);
    EXPECT_EQ(one.call("EnterEventMode"), 0);
    EXPECT_EQ(one.set(torque, -0.75) | one.set(stiffness, 3), 0) << one.log.text;
    importer.handle_event();
    importer.run(0.6, c.h);
    EXPECT_EQ(one.get(outputs, values), 0);
    std::printf("FMI %d: %.1e, then %.1e off the native run, %.1e in pose, %ld corrections\n", version, at_03,
                difference(values, end), difference(values, end, 4), importer.corrections);
    EXPECT_LT(difference(values, end), c.error);
    EXPECT_LT(difference(values, end, 4), c.of_pose);
    EXPECT_EQ(one.call("Terminate"), 0);
  }

  // 2. Derivatives are those of the native motion: differences of its states.
  constexpr double kApart = 1e-5;  // s
  native.graph.input("torque").reset(0, 0.5);
  native.graph.input("stiffness").reset(0, 1.7);
  native.state = at_middle;
  std::vector<Values> around;
  for (const int k : {-2, -1, 0, 1, 2}) native.at(0.3 + 0.1 + k * kApart), around.push_back(native.x());
  ImportedInstance one(library, fmu.token(), 3, false, Form::model_exchange);
  begin(one);
  Importer importer(one, n, kinks);
  Values rates(count), nominals(count);
  EXPECT_EQ(one.set_time(0.4) | one.set_states(around[2]) | one.derivatives(rates), 0) << one.log.text;
  EXPECT_EQ(one.nominals(nominals), 0);
  for (std::size_t i = 0; i < count; ++i) {
    const double slope = (8 * (around[3][i] - around[1][i]) - (around[4][i] - around[0][i])) / (12 * kApart);
    EXPECT_NEAR(rates[i], slope, 1e-6 * std::max(1.0, std::abs(slope))) << i;
    EXPECT_GT(nominals[i], 0);
  }

  // 3. The order of calls does not matter, to the last bit.
  ImportedInstance two(library, fmu.token(), 2, false, Form::model_exchange);
  begin(two);
  Importer other_importer(two, n, kinks);
  Values again(count), seen;
  EXPECT_EQ(one.get(outputs, values), 0);
  EXPECT_EQ(two.set_states(around[0]) | two.derivatives(again) | two.set_time(7) | two.get(outputs, seen), 0);
  EXPECT_EQ(two.set(torque, 1) | two.derivatives(again) | two.set(torque, 0.5), 0);
  EXPECT_EQ(two.set_states(around[2]) | two.set_time(0.4) | two.get(outputs, seen) | two.derivatives(again), 0);
  EXPECT_EQ(again, rates);
  EXPECT_EQ(seen, values);

  // 4. A quaternion of another norm is the same rotation; the next event takes the norm back.
  const auto body = native.system.layout().bodies().front();
  Values stretched = around[2];
  double norm = 0;
  for (int i = body.q + 3; i < body.q + 7; ++i) stretched[static_cast<std::size_t>(i)] *= 1.001;
  EXPECT_EQ(one.set_states(stretched) | one.derivatives(again), 0);
  for (std::size_t i = 0; i < count; ++i) {
    const bool of_e = static_cast<int>(i) >= body.q + 3 && static_cast<int>(i) < body.q + 7;
    EXPECT_NEAR(again[i], (of_e ? 1.001 : 1) * rates[i], 1e-11 * std::max(1.0, std::abs(rates[i]))) << i;
    if (of_e) norm += stretched[i] * again[i];
  }
  EXPECT_NEAR(norm, 0, 1e-15) << "it does not change its norm";
  bool asks = false, changed = false;
  EXPECT_EQ(one.complete_step(asks), 0);
  EXPECT_TRUE(asks);
  EXPECT_EQ(one.call("EnterEventMode") | one.update(changed) | one.call("EnterContinuousTimeMode"), 0);
  EXPECT_TRUE(changed);
  EXPECT_EQ(one.states(again), 0);
  EXPECT_LT(difference(again, around[2]), 1e-9);

  // 5. Rolled back and carried over, a hundred times: the same bits.
  std::mt19937 random(11);
  EXPECT_EQ(one.call("EnterEventMode"), 0);
  importer.handle_event();
  importer.go_on_from(0.4);
  for (int trial = 0; trial < 100; ++trial) {
    void *state = nullptr, *copy = nullptr;
    ASSERT_EQ(one.save(&state), 0) << one.log.text;
    const double saved = importer.time();
    const int ahead = 1 + static_cast<int>(random() % 3);
    const auto go = [&](auto& by, ImportedInstance& instance) {
      for (int i = 0; i < ahead; ++i) by.step(1e-3);
      Values all;
      EXPECT_EQ(instance.get(outputs, all), 0);
      all.insert(all.end(), by.states().begin(), by.states().end());
      return all;
    };
    const Values forth = go(importer, one);
    ASSERT_EQ(one.restore(state), 0) << one.log.text;
    importer.go_on_from(saved);
    ASSERT_EQ(go(importer, one), forth) << trial;
    ASSERT_EQ(two.deserialize(one.serialized(state), &copy) | two.restore(copy), 0) << two.log.text;
    other_importer.go_on_from(saved);
    ASSERT_EQ(go(other_importer, two), forth) << trial;
    if (trial % 2 == 0) one.restore(state), importer.go_on_from(saved);
    EXPECT_EQ(one.forget(&state) | two.forget(&copy), 0);
  }

  // 6. What importers get wrong: an error with a message, and the instance lives on.
  EXPECT_EQ(one.derivatives(rates) | one.get(outputs, values), 0);
  const auto refused = [&](int status, const std::string& words, int expected = kError) {
    EXPECT_EQ(status, expected) << words;
    EXPECT_NE(one.log.text.find(words), std::string::npos) << words << " in " << one.log.text;
    one.log.text.clear();
  };
  refused(one.step(importer.time(), 1e-3), "not allowed in this mode");
  refused(one.update(changed), "not allowed in this mode");
  refused(one.call("EnterContinuousTimeMode"), "not allowed in this mode");
  refused(one.call("ExitInitializationMode"), "not allowed in this mode");
  refused(one.set(stiffness, 2), "in event mode");
  refused(one.set(torque, 1e3), "outside its bounds");
  refused(one.set(first, 1), "is no input or parameter");
  refused(one.set_states({rates.data(), count - 1}), "there are " + std::to_string(n) + " continuous states");
  Values too_many(static_cast<std::size_t>(kinks) + 1);
  refused(one.indicators(too_many), "there are " + std::to_string(kinks) + " event indicators");
  refused(one.set_time(NAN), "not finite");
  Values broken = importer.states();
  broken[1] = NAN;
  refused(one.set_states(broken), "is not finite", kDiscard);
  broken = importer.states();
  for (int i = body.q + 3; i < body.q + 7; ++i) broken[static_cast<std::size_t>(i)] = 0;
  refused(one.set_states(broken), "quaternion", kDiscard);
  refused(one.directional_derivative({first}, {first}, {1}, seen), "no derivatives by 'angle'");
  refused(one.directional_derivative({torque}, {torque}, {1}, seen), "no derivatives of 'torque'");
  EXPECT_EQ(one.derivatives(again) | one.get(outputs, seen), 0);
  EXPECT_EQ(again, rates);
  EXPECT_EQ(seen, values);
  EXPECT_EQ(one.call("EnterEventMode"), 0);
  refused(one.set_states(importer.states()), "not allowed in this mode");
  refused(one.call("EnterEventMode"), "not allowed in this mode");
  refused(one.complete_step(asks), "not allowed in this mode");
  void* state = nullptr;
  ASSERT_EQ(one.save(&state), 0);
  {
    ImportedInstance stepped(library, fmu.token(), 3);
    EXPECT_EQ(stepped.restore(state), kError) << "it is of the other form";
    EXPECT_NE(stepped.log.text.find("form"), std::string::npos) << stepped.log.text;
    EXPECT_EQ(stepped.start(), 0) << stepped.log.text;
    EXPECT_EQ(stepped.derivatives(again), kError) << "an instance for co-simulation";
    EXPECT_EQ(stepped.set_time(1), kError);
    EXPECT_EQ(stepped.step(0, 1e-3), 0);
  }
  EXPECT_EQ(one.forget(&state), 0);
  EXPECT_EQ(one.call("EnterContinuousTimeMode") | one.call("Terminate"), 0);
  refused(one.call("EnterEventMode"), "not allowed in this mode");
  EXPECT_EQ(one.call("Reset"), 0);
  begin(one);
  bool first_change = true;
  EXPECT_EQ(one.update(first_change), 0);
  EXPECT_FALSE(first_change) << "it starts on its constraints";

  // 7. FMPy, where it is installed: its solver CVODE agrees with co-simulation.
  const Outcome checked = scratch.shell(
      "python3 -c 'import fmpy' 2>/dev/null || { echo no FMPy: pip install fmpy; exit 0; }; python3 -c '"
      "import fmpy; o = dict(stop_time=0.1, output_interval=0.002, start_values=dict(torque=0.5)); "
      "a = fmpy.simulate_fmu(\"model.fmu\", fmi_type=\"ModelExchange\", solver=\"CVode\", relative_tolerance=1e-7, "
      "**o); "
      "b = fmpy.simulate_fmu(\"model.fmu\", fmi_type=\"CoSimulation\", **o); "
      "d = abs(a[\"angle\"][-1] - b[\"angle\"][-1]); print(\"FMPy, CVODE beside co-simulation:\", d); "
      "exit(int(d > 1e-4))'");
  EXPECT_EQ(checked.exit_code, 0) << checked.output;
  std::printf("%s", checked.output.c_str());
}

TEST(FmuExchange, OfAFlexibleArmIsTheNativeMotionByBothStandards) {
  drive({"examples/studies/driven_arm.cpp", arm::scene(), "lift", 0.35, 2, 2e-5, 2e-6, 1e-11});
}

TEST(FmuExchange, OfARigidPendulumIsTheNativeMotionByBothStandards) {
  drive({"tests/scripting/fmu_pendulum.cpp", pendulum::scene(), "target", 0.2, 3, 1e-3, 1e-9, 1e-10});
}

TEST(FmuExchange, DerivativesOfDerivativesAreThoseOfAPendulum) {
  // I α̇ = torque - k α - m g l cos α + 5 (target - α) + … about the pin, I = 0.03 + 1 · 0.3².
  const FmuModel model = model_of(pendulum::scene());
  Direct one(model);
  FmuInstance& instance = one.instance;
  instance.set(reference(instance, "torque"), 0.3);
  instance.update();
  Importer importer(one, static_cast<int>(instance.states().size()), 0);
  importer.run(0.2, 1e-3);
  const double angle = instance.get(reference(instance, "angle"));
  ASSERT_GT(std::abs(angle), 0.05);
  const unsigned turn = reference(instance, "der(rod.omega_y)"), torque = reference(instance, "torque"),
                 stiffness = reference(instance, "stiffness"), target = reference(instance, "target"),
                 x = reference(instance, "rod.p_x");
  const auto derivative = [&](unsigned unknown, unsigned known) {
    const double seed = 1;
    double out = 0;
    instance.directional_derivative({&unknown, 1}, {&known, 1}, {&seed, 1}, {&out, 1});
    return out;
  };
  const auto by = [&](unsigned known) { return derivative(turn, known); };
  // Turning about the marker's z is turning about the rod's y.
  constexpr double kInertia = 0.12, kBound = 1e-9;
  const double sign = by(torque) > 0 ? 1 : -1;
  EXPECT_NEAR(by(torque), sign / kInertia, kBound);
  EXPECT_NEAR(by(target), sign * 5 / kInertia, 10 * kBound);
  EXPECT_NEAR(by(stiffness), -sign * angle / kInertia, kBound);
  EXPECT_NEAR(derivative(reference(instance, "tip_z"), reference(instance, "rod.p_z")), 1, kBound);
  // A product of the matrix from the left is one from the right.
  const std::vector<unsigned> unknowns{turn, reference(instance, "tip_z"), reference(instance, "pin_force_x")},
      knowns{torque, stiffness, x, reference(instance, "rod.omega_y"), reference(instance, "rod.e_y")};
  const Values left{0.3, -2, 0.7}, right{1, -0.4, 0.02, 0.6, -0.05};
  Values from_left(5), from_right(3);
  instance.adjoint_derivative(unknowns, knowns, left, from_left);
  instance.directional_derivative(unknowns, knowns, right, from_right);
  double l = 0, r = 0;
  for (std::size_t i = 0; i < 5; ++i) l += from_left[i] * right[i];
  for (std::size_t i = 0; i < 3; ++i) r += left[i] * from_right[i];
  EXPECT_GT(std::abs(l), 1);
  EXPECT_NEAR(l, r, 1e-8 * std::abs(l));
}

TEST(FmuExchange, AMotionGivenByTimeIsHonouredFromAnyStart) {
  const StudyScene scene{
      .name = "shaken", .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
        const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
        auto& arm = graph.add<RigidBody>("arm", {.mass = 1, .inertia = {0.01, 0.03, 0.03}, .position = {0.3, 0, 0}});
        auto& rod = graph.add<RigidBody>("rod", {.mass = 1, .inertia = {0.01, 0.03, 0.03}, .position = {0.9, 0, 0}});
        auto& pin =
            graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, along_y), arm.marker({-0.3, 0, 0}, along_y)});
        graph.add<RevoluteJoint>("elbow", {arm.marker({0.3, 0, 0}, along_y), rod.marker({-0.3, 0, 0}, along_y)});
        graph.add<CoordinateDrive>("drive", {pin.angle()}, {.motion = harmonic(0.4, 3)});
        return {coordinate(pin.angle(), "angle"), position(rod.marker({0.3, 0, 0}), "tip"), joint_reaction(pin, "pin")};
      }};
  const FmuModel model = model_of(scene);
  Direct one(model);
  Importer importer(one, static_cast<int>(one.instance.states().size()), 0);
  importer.run(1, 5e-4);
  Native native(scene);
  EXPECT_LT(difference(outputs_of(one.instance), native.at(1)), 1e-7);
  EXPECT_NEAR(one.instance.get(reference(one.instance, "angle")), 0.4 * std::sin(3.0), 1e-9);
  // From another time on the drive is where it is then, and as fast.
  one.instance.reset();
  one.instance.begin(0.7);
  EXPECT_NEAR(one.instance.get(reference(one.instance, "angle")), 0.4 * std::sin(2.1), 1e-12);
  EXPECT_NEAR(one.instance.get(reference(one.instance, "arm.omega_y")), 1.2 * std::cos(2.1), 1e-12);
}

TEST(FmuExchange, AStopIsAnEventWithHysteresis) {
  const StudyScene scene{
      .name = "stopped", .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
        const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
        auto& rod = graph.add<RigidBody>("rod", {.mass = 1, .inertia = {0.01, 0.03, 0.03}, .position = {0.3, 0, 0}});
        auto& pin =
            graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, along_y), rod.marker({-0.3, 0, 0}, along_y)});
        graph.add<CoordinateStop>("stop", {pin.angle()},
                                  {.lower = -1.0, .upper = 1.0, .stiffness = 1e4, .dissipation = 0.1});
        return {coordinate(pin.angle(), "angle"), coordinate_rate(pin.angle(), "rate")};
      }};
  const FmuModel model = model_of(scene);
  Direct one(model);
  ASSERT_EQ(one.instance.equations().indicator_count(), 2);
  Importer importer(one, static_cast<int>(one.instance.states().size()), 2);
  Native native(scene);
  for (const double time : {0.5, 1.0, 1.5}) {
    importer.run(time, 1e-4);
    const Values exact = native.at(time);
    EXPECT_NEAR(one.instance.get(reference(one.instance, "angle")), exact[0], 1e-6) << time;
    EXPECT_NEAR(one.instance.get(reference(one.instance, "rate")), exact[1], 1e-5) << time;
    for (const double z : importer.indicators()) EXPECT_GT(std::abs(z), 1e-11);
  }
  // CVODE finds the same ones.
  FmuInstance instance(model, FmuInstance::Form::model_exchange);
  instance.begin(0, 1e-9);
  CvodeImporter cvode(instance, 1e-9);
  cvode.run(1.5, [](const VectorX&) {});
  EXPECT_EQ(cvode.crossings, importer.crossings);
  EXPECT_NEAR(instance.get(reference(instance, "angle")), one.instance.get(reference(instance, "angle")), 1e-5);
  // As often as the native run has met and left a stop, and never twice for one passage.
  EXPECT_GE(importer.crossings, 4);
  EXPECT_LT(importer.crossings, 40);
  EXPECT_EQ(importer.crossings % 2, std::abs(one.instance.get(reference(one.instance, "angle"))) > 1 ? 1 : 0);
}

/// A ball above a floor.
StudyScene ball_on_floor(const Contact::Parameters& law) {
  return {.name = "ball", .draw = [law](SystemGraph& graph) -> std::vector<Sensor> {
            auto& ball = graph.add<RigidBody>("ball", {.mass = 1, .position = {0, 0, 0.3}});
            graph.add<Contact>(
                "floor", {{graph.ground().marker(), shape::half_space()}, {ball.marker(), shape::sphere(0.1)}}, law);
            return {height(ball.marker(), "height")};
          }};
}

TEST(FmuExchange, SurfacesThatMeetAreEvents) {
  const StudyScene scene =
      ball_on_floor({.law = Compliance{.stiffness = 1e5, .dissipation = Dissipation::fixed, .damping = 0.1}});
  const FmuModel model = model_of(scene);
  Direct one(model);
  ASSERT_EQ(one.instance.equations().indicator_count(), 1);
  Importer importer(one, static_cast<int>(one.instance.states().size()), 1);
  importer.run(1, 1e-4);
  Native native(scene);
  EXPECT_NEAR(one.instance.get(reference(one.instance, "height")), native.at(1)[0], 1e-6);
  EXPECT_GE(importer.crossings, 4);
}

TEST(FmuExchange, IsRefusedByNameWhereASceneHasNoSuchForm) {
  const auto why = [](const StudyScene& scene) {
    const FmuModel model = model_of(scene);
    const std::string refusal = FmuInstance(model).refusal();
    expect_says(message_of<SceneError>([&] { FmuInstance(model, FmuInstance::Form::model_exchange); }), {refusal});
    return refusal;
  };
  expect_says(why(ball_on_floor({.law = RigidSurfaces{}})), {"'floor'", "impulses"});
  expect_says(why(ball_on_floor({.law = Compliance{.stiffness = 1e5, .restitution = 0.5}})), {"'floor'", "remembers"});
  expect_says(why({.name = "driven",
                   .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
                     auto& rod = graph.add<RigidBody>("rod", {});
                     auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker(), rod.marker()});
                     auto& target = graph.add<Input>("target", {.between = Input::Between::smooth});
                     graph.add<CoordinateDrive>("drive", {pin.angle()}, {.motion = target});
                     return {};
                   }}),
              {"'target'", "prescribes a motion"});

  const ScriptFolder folder;
  folder.write("ball.cpp", R"(#include "lithe/lithe.h"
using namespace lithe;
StudyScene scene() {
  return {.name = "ball", .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
    auto& ball = graph.add<RigidBody>("ball", {.mass = 1, .position = {0, 0, 0.3}});
    graph.add<Contact>("floor", {{graph.ground().marker(), shape::half_space()}, {ball.marker(), shape::sphere(0.1)}},
                       {.law = RigidSurfaces{}});
    return {height(ball.marker(), "height")};
  }};
}
)");
  const Outcome made = folder.shell("lithe fmu ball.cpp && python3 -m zipfile -e ball.fmu ball");
  EXPECT_EQ(made.exit_code, 0) << made.output;
  expect_says(made.output, {"for co-simulation alone", "'floor'", "impulses"});
  const Outcome described = folder.shell("cat ball/modelDescription.xml");
  expect_says(described.output, {"CoSimulation"});
  EXPECT_EQ(described.output.find("ModelExchange"), std::string::npos);
}

}  // namespace
}  // namespace lithe::test::fmu_exchange_test
