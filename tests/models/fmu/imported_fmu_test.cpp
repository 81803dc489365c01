// FMUs of other tools beside a scene: against the same controller written as an observer, bit for bit; files that are
// wrong.
#include "models/fmu/imported_fmu.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/archive/archive.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "joints/distance_joint.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/revolute_joint.h"
#include "tests/models/fmu/arm.h"
#include "tests/models/fmu/servo_fmu.h"
#include "tests/support/message_of.h"

namespace lithe::test::imported_fmu_test {
namespace {

constexpr double kGain = 12, kIntegralGain = 40, kTarget = 0.4, kInterval = 0.005;

/// An arm of 0.4 m on a hinge under a torque: rigid, or with four modes.
struct Arm {
  explicit Arm(bool flexible, Input::Between between = Input::Between::held)
      : torque(graph.add<Input>("torque", {.unit = "N m", .lower = -50, .upper = 50, .between = between})),
        hinge(graph.add<RevoluteJoint>("hinge", {graph.ground().marker({}, kAlongY), arm_root(graph, flexible)})),
        angle(coordinate(hinge.angle(), "angle")) {
    graph.add<CoordinateMotor>("motor", {hinge.angle()}, {.effort = torque});
    graph.add<CoordinateSpring>("bearing", {hinge.angle()}, {.damping = 0.3});
    system = std::make_unique<System>(assemble(graph));
    simulation = std::make_unique<Simulation>(*system, integrator);
    state = system->initial_state();
  }

  ImportedFmu::Parameters wires() {
    return {.interval = kInterval,
            .inputs = {{"angle", angle}},
            .outputs = {{"torque", &torque}},
            .values = {{"gain", kGain}, {"integral_gain", kIntegralGain}, {"target", kTarget}}};
  }
  double run(double end) {
    simulation->run(state, end);
    return angle_now();
  }
  double angle_now() {
    Snapshot now(*system, state);
    return angle.value(now);
  }

  SystemGraph graph;
  Input& torque;
  RevoluteJoint& hinge;
  Sensor angle;
  GeneralizedAlpha integrator{{.step = 1e-3}};
  std::unique_ptr<System> system;
  std::unique_ptr<Simulation> simulation;
  State state;
};

/// The controller of servo.cpp as an observer.
class NativeServo final : public Observer {
 public:
  NativeServo(Input& torque, const Sensor& angle) : torque_(torque), angle_(angle) {}
  void observe(Snapshot& now) override {
    const double error = kTarget - angle_.value(now);
    // Rounded one by one, as in the FMU, which is compiled for processors without FMA.
    const volatile double part = kInterval * error;
    if (begun_) integral_ += part;
    begun_ = true;
    const volatile double proportional = kGain * error, integral = kIntegralGain * integral_;
    torque_.set(now.time(), proportional + integral);
  }
  double integral() const { return integral_; }

 private:
  Input& torque_;
  Sensor angle_;
  double integral_ = 0;
  bool begun_ = false;
};

class ImportedServo : public testing::TestWithParam<std::tuple<int, bool>> {
 protected:
  int version() const { return std::get<0>(GetParam()); }
  bool flexible() const { return std::get<1>(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(Fmi, ImportedServo, testing::Combine(testing::Values(2, 3), testing::Bool()),
                         [](const auto& tested) {
                           return std::string(std::get<0>(tested.param) == 2 ? "two" : "three") +
                                  (std::get<1>(tested.param) ? "_flexible" : "_rigid");
                         });

TEST_P(ImportedServo, moves_the_arm_bit_for_bit_as_the_same_controller_written_in_the_scene) {
  const ServoFmu file(version());
  Arm by_fmu(flexible()), by_hand(flexible());
  ImportedFmu servo(file.packed(), by_fmu.wires());
  servo.join(*by_fmu.simulation);
  NativeServo native(by_hand.torque, by_hand.angle);
  by_hand.simulation->observe(native, every(kInterval));
  for (const double end : {0.3, 0.75, 3.0}) {
    by_fmu.run(end), by_hand.run(end);
    EXPECT_EQ(by_fmu.state.q, by_hand.state.q) << end;
    EXPECT_EQ(by_fmu.state.v, by_hand.state.v) << end;
    EXPECT_EQ(servo.value("integral"), native.integral()) << end;
  }
  // The integral removes the error, and holds the weight: the arm's, at its length's middle.
  EXPECT_NEAR(by_fmu.angle_now(), kTarget, 0.02);
  Snapshot now(*by_fmu.system, by_fmu.state);
  EXPECT_EQ(servo.sensor("torque").value(now), by_fmu.torque.value(by_fmu.state.time));
}

TEST_P(ImportedServo, goes_on_from_a_checkpoint_with_the_same_bits) {
  const ServoFmu file(version());
  const std::string path = file.packed();
  Arm through(flexible()), first(flexible()), second(flexible());
  ImportedFmu a(path, through.wires()), b(path, first.wires()), c(path, second.wires());
  a.join(*through.simulation), b.join(*first.simulation), c.join(*second.simulation);
  first.run(0.4);
  Archive archive;
  first.simulation->save(first.state, archive);
  archive.rewind();
  second.state = second.simulation->resume(archive);
  EXPECT_EQ(c.value("integral"), b.value("integral"));
  through.run(0.4);
  through.run(1), second.run(1);
  EXPECT_EQ(through.state.q, second.state.q);
  EXPECT_EQ(a.value("integral"), c.value("integral"));
}

TEST_P(ImportedServo, starts_anew_with_a_run_that_does) {
  const ServoFmu file(version());
  Arm arm(flexible());
  ImportedFmu servo(file.packed(), arm.wires());
  servo.join(*arm.simulation);
  EXPECT_EQ(servo.value("integral"), 0);
  const double there = arm.run(0.5), integral = servo.value("integral");
  EXPECT_NE(integral, 0);
  arm.state = arm.system->initial_state();
  EXPECT_EQ(arm.run(0.5), there);
  EXPECT_EQ(servo.value("integral"), integral);
}

TEST(ImportedFmu, leaves_its_default_step_and_takes_truth_values) {
  for (const int version : {2, 3}) {
    const ServoFmu file(version);
    Arm arm(false);
    ImportedFmu::Parameters wires = arm.wires();
    wires.interval = 0;
    wires.values.push_back({"enabled", 0});
    ImportedFmu servo(file.packed(), wires);
    EXPECT_EQ(servo.interval(), 0.01);
    servo.join(*arm.simulation);
    arm.run(0.2);
    EXPECT_EQ(servo.value("enabled"), 0);
    EXPECT_EQ(arm.torque.value(0.2), 0);  // switched off
    EXPECT_GT(arm.angle_now(), 0.15);     // so the arm falls, which counts as positive about y
    EXPECT_LT(arm.angle_now(), 0.5 * 1.5 * 9.81 / 0.4 * 0.2 * 0.2);  // slower than without damping
  }
}

TEST(ImportedFmu, takes_single_numbers_of_arrays) {
  const ServoFmu file(3);
  Arm arm(false);
  ImportedFmu::Parameters wires = arm.wires();
  wires.values.push_back({"gains[2]", 5});
  ImportedFmu servo(file.packed(), wires);
  EXPECT_EQ(servo.value("gains[3]"), 3);  // before a run: its start value
  servo.join(*arm.simulation);
  arm.run(0.01);
  EXPECT_EQ(servo.value("gains[1]"), 1);
  EXPECT_EQ(servo.value("gains[2]"), 5);
  EXPECT_EQ(servo.sensor("gains[3]").columns()[0], "gains[3]");
  expect_says(servo.describe(), {"parameter gains [2] = 5"});
  expect_says(message_of<SceneError>([&] { servo.value("gains[4]"); }), {"'gains' has 3 numbers, no 'gains[4]'"});
}

TEST(ImportedFmu, an_output_to_a_smooth_input_arrives_one_interval_later_without_a_jump) {
  const ServoFmu file(3);
  Arm arm(false, Input::Between::smooth);
  ImportedFmu servo(file.packed(), arm.wires());
  servo.join(*arm.simulation);
  arm.run(10 * kInterval);
  const double before = servo.value("torque");
  EXPECT_EQ(arm.torque.value(11 * kInterval), before);
  arm.run(11 * kInterval);
  EXPECT_NEAR(arm.torque.value(11 * kInterval), before, 1e-12);  // the sample that has been reached
  EXPECT_EQ(arm.torque.value(12 * kInterval), servo.value("torque"));
  EXPECT_NE(servo.value("torque"), before);
}

TEST(ImportedFmu, says_what_it_is_and_how_it_is_connected) {
  const ServoFmu file(2);
  Arm arm(false);
  const ImportedFmu servo(file.packed(), arm.wires());
  expect_says(servo.describe(),
              {"Servo, FMI 2.0, made by a text editor; every 0.005 s", "input angle [rad] from sensor 'angle'",
               "output torque [N.m] to input 'torque'", "parameter gain = 12", "enabled = 1, its default"});
}

// ---- what goes wrong ----

std::string refused(const ServoFmu& file, const std::function<void(ImportedFmu::Parameters&)>& change = {}) {
  Arm arm(false);
  ImportedFmu::Parameters wires = arm.wires();
  if (change) change(wires);
  return message_of<Error>([&] { ImportedFmu(file.packed(), wires); });
}

TEST(ImportedFmu, refuses_wires_that_do_not_fit) {
  {
    const ServoFmu three(3);
    expect_says(refused(three, [](auto& w) { w.values[0].first = "gains"; }), {"'gains' is an array"});
  }
  const ServoFmu two(2);
  expect_says(refused(two, [](auto& w) { w.inputs[0].variable = "angel"; }),
              {"it has no input 'angel'", "FMU 'Servo'", "did you mean 'angle'"});
  expect_says(refused(two, [](auto& w) { w.inputs[0].variable = "torque"; }), {"'torque' is no input", "output"});
  expect_says(refused(two, [](auto& w) { w.outputs[0].variable = "gain"; }), {"'gain' is no output"});
  expect_says(refused(two, [](auto& w) { w.values[0].first = "torque"; }), {"'torque' is no parameter"});
  expect_says(refused(two, [](auto& w) { w.values[0].first = "note"; }), {"'note' is of type String"});
  expect_says(refused(two, [](auto& w) { w.inputs.push_back(w.inputs[0]); }), {"'angle' is connected twice"});
  expect_says(refused(two, [](auto& w) { w.inputs[0].column = 1; }), {"takes column 1 of a sensor that has 1"});
  expect_says(refused(two, [](auto& w) { w.outputs[0].input = nullptr; }), {"'torque' goes to no Input"});
  expect_says(refused(two, [](auto& w) { w.interval = -1; }), {"the interval is -1 s"});
  two.describe(replaced(ServoFmu::description(2), " stepSize=\"0.01\"", ""));
  expect_says(refused(two, [](auto& w) { w.interval = 0; }), {"the FMU names no default", ".interval"});
}

TEST(ImportedFmu, refuses_files_that_are_wrong) {
  const ServoFmu file(2);
  const std::string good = ServoFmu::description(2);
  const auto with = [&](const std::string& what, const std::string& by) {
    file.describe(replaced(good, what, by));
    return refused(file);
  };
  expect_says(with("fmiVersion=\"2.0\"", "fmiVersion=\"1.0\""), {"FMI 1.0", "servo.fmu, modelDescription.xml:2"});
  expect_says(with("<CoSimulation", "<ModelExchange"), {"not for co-simulation"});
  expect_says(with("</fmiModelDescription>", ""), {"not well-formed", "modelDescription.xml:"});
  expect_says(with("valueReference=\"3\"", "valueReference=\"-3\""), {"valueReference", "modelDescription.xml:11"});
  expect_says(with("name=\"gain\"", ""), {"<ScalarVariable> has no name", "modelDescription.xml:10"});
  expect_says(with("modelIdentifier=\"servo\"", "modelIdentifier=\"../servo\""), {"'../servo' is no name"});
  expect_says(with("modelIdentifier=\"servo\"", "modelIdentifier=\"other\""),
              {"no binary for linux64", "it has: linux64"});
  expect_says(with("guid=\"servo-1\"", "guid=\"servo-2\""), {"fmi2Instantiate", "error"});
  expect_says(with("canSerializeFMUstate=\"true\"", "needsExecutionTool=\"true\""), {"needs the tool that made it"});
  file.describe(good);
  EXPECT_EQ(refused(file), "");
  std::filesystem::remove(file.file("modelDescription.xml"));
  expect_says(refused(file), {"no modelDescription.xml"});
}

TEST(ImportedFmu, refuses_archives_that_are_no_archive_or_lead_out_of_their_folder) {
  const ScratchFolder folder;
  const auto opened = [&](const std::string& path) {
    return message_of<FileError>([&] { ImportedFmu(path, {.interval = 1}); });
  };
  expect_says(opened("nowhere.fmu"), {"no such file", "nowhere.fmu"});
  expect_says(opened(folder.write("text.fmu", "no archive")), {"no zip archive"});
  const auto made = [&](const std::string& script) {
    const std::string path = (folder.path() / "made.fmu").string();
    std::filesystem::remove(path);
    folder.write("make.py", "import zipfile\nz = zipfile.ZipFile('" + path + "', 'w')\n" + script + "\nz.close()\n");
    EXPECT_EQ(std::system(("python3 '" + (folder.path() / "make.py").string() + "'").c_str()), 0);
    return path;
  };
  expect_says(opened(made("z.writestr('../escaped.txt', 'x')")), {"'../escaped.txt' leads out of its folder"});
  expect_says(opened(made("z.writestr('/nowhere/escaped.txt', 'x')")), {"leads out of its folder"});
  expect_says(opened(made("i = zipfile.ZipInfo('binaries'); i.create_system = 3; i.external_attr = 0o120777 << 16\n"
                          "z.writestr(i, '/etc')")),
              {"'binaries' leads out of its folder"});
  expect_says(opened(made("for i in range(2): z.writestr(f'part{i}', 'x')\n"
                          "for i in z.infolist(): i.file_size = 0xFFFFFFFE  # as its list of files states")),
              {"more than 4 GiB"});
  const std::string path = made("z.writestr('modelDescription.xml', 'x' * 5000, zipfile.ZIP_DEFLATED)");
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 30);
  expect_says(opened(path), {"no zip archive, or damaged"});
  EXPECT_FALSE(std::filesystem::exists("/nowhere/escaped.txt"));
}

TEST(ImportedFmu, ends_the_run_with_its_message_and_the_time_where_it_fails) {
  for (const int version : {2, 3}) {
    const ServoFmu file(version);
    const std::string path = file.packed();
    const auto failing = [&](int fault) {
      Arm arm(false);
      ImportedFmu::Parameters wires = arm.wires();
      wires.values.push_back({"fault", fault});
      ImportedFmu servo(path, wires);
      servo.join(*arm.simulation);
      const std::string said = message_of<SimulationError>([&] { arm.run(1); });
      if (fault == 1) {
        EXPECT_NEAR(arm.state.time, 0.105, 1e-12);  // the state is that of the last point
        EXPECT_NE(message_of<SimulationError>([&] { arm.run(1); }), "");
        arm.state = arm.system->initial_state();
        EXPECT_NE(message_of<SimulationError>([&] { arm.run(0.2); }), "");
        EXPECT_NEAR(arm.state.time, 0.105, 1e-12);  // anew, to the same end
      }
      return said;
    };
    expect_says(failing(1), {"DoStep gives an error: the amplifier is too hot", "FMU 'Servo', t = 0.105"});
    expect_says(failing(2), {"gives nan for 'torque'", "t = 0 s"});
    expect_says(failing(3), {"DoStep discards it", "shorter interval", "t = 0.005 s"});
  }
}

TEST(ImportedFmu, that_cannot_give_its_state_has_no_checkpoints) {
  const ServoFmu file(2);
  file.describe(replaced(ServoFmu::description(2), "canSerializeFMUstate=\"true\"", ""));
  Arm arm(false);
  ImportedFmu servo(file.packed(), arm.wires());
  servo.join(*arm.simulation);
  arm.run(0.1);
  Archive archive;
  expect_says(message_of<SceneError>([&] { arm.simulation->save(arm.state, archive); }),
              {"cannot give its state", "checkpoints"});
  expect_says(servo.describe(), {"no checkpoints"});
}

}  // namespace
}  // namespace lithe::test::imported_fmu_test
