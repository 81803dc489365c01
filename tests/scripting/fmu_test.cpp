// FMUs: made by the command, loaded as an importer does, and compared with the native run bit for bit.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <regex>
#include <thread>
#include <vector>

#include "tests/scripting/command.h"
#include "tests/scripting/fmu_importer.h"

namespace lithe::test::fmu_test {
namespace {

namespace fs = std::filesystem;
using Values = std::vector<double>;

constexpr double kCommunication = 0.0123;  // s

/// What a schedule of inputs does in step k: the k-th values of torque (held) and of the other one. In the native
/// program too: numbers that are exact, however they are compiled.
constexpr const char* kSchedule = R"(
struct Given {
  double torque, other;
};
inline Given given(int k) { return {k < 5 ? 0.0 : (k % 9 - 4) / 16.0, k < 12 ? 0.3125 : 0.3125 + (k % 7) / 64.0}; }
)";
struct Given {
  double torque, other;
};
Given given(int k) { return {k < 5 ? 0.0 : (k % 9 - 4) / 16.0, k < 12 ? 0.3125 : 0.3125 + (k % 7) / 64.0}; }

/// The same steps by Simulation itself, as the documentation of FmuInstance says; all outputs after each step.
std::vector<Values> native(const ScriptFolder& scratch, const std::string& scene, const std::string& other, int steps) {
  return native_rows(scratch, scene, kSchedule,
                     R"(
  Input &torque = graph.input("torque"), &smooth = graph.input(")" +
                         other + R"(");
  graph.input("stiffness").reset(0, 1.7);
  smooth.reset(0, given(0).other);
  for (int k = 0; k < )" +
                         std::to_string(steps) + R"(; ++k) {
    const double end = state.time + 0.0123;
    torque.reset(state.time, given(k).torque);
    if (const double present = smooth.value(state.time); present != given(k).other)
      smooth.reset(state.time, present), smooth.set(end, given(k).other);
    simulation.run(state, end);
    // As observers see it.
    print(state, method.approximates_accelerations() ? Accelerations::solved : Accelerations::as_left);
  }
)");
}

struct Case {
  const char* scene;
  const char* other;  // the input that is not held
  int version;
  const char* options = "";
};

/// Nothing beneath but what is packed, and glibc.
void expect_stands_alone(const ScriptFolder& scratch, const UnpackedFmu& fmu) {
  const Outcome beneath =
      scratch.shell("ldd " + fmu.library.string() + " | grep '=>' | grep -vE ' => " +
                    fmu.library.parent_path().string() + "/|lib(c|m|dl|pthread|rt|resolv)\\.so'; true");
  EXPECT_EQ(beneath.output, "");
}

/// Event mode, intermediate updates and early return of FMI 3.0, which change no bit of the run.
void use_events(const FmuLibrary& library, const UnpackedFmu& fmu, const Case& c, const std::vector<Values>& exact,
                const std::vector<unsigned>& outputs) {
  const unsigned stiffness = fmu.reference("stiffness"), torque = fmu.reference("torque"),
                 other = fmu.reference(c.other), clock = fmu.reference("time");
  constexpr int kError = 3;
  ImportedInstance* here = nullptr;
  std::vector<double> told;
  double wanted_end = 1e9;
  Values seen;
  ImportedInstance one(library, fmu.token(), [&](double time, bool may_end) {
    EXPECT_TRUE(may_end);
    EXPECT_EQ(here->get({clock}, seen), 0);
    EXPECT_EQ(seen[0], time);
    EXPECT_EQ(here->get(outputs, seen), 0) << here->log.text;
    EXPECT_EQ(here->set(other, 0.4), kError) << "it is smooth";
    EXPECT_EQ(here->set(stiffness, 2), kError) << "a parameter";
    EXPECT_EQ(here->step(time, kCommunication), kError);
    told.push_back(time);
    return time >= wanted_end;
  });
  here = &one;
  ASSERT_TRUE(one.exists());
  EXPECT_EQ(one.set(stiffness, 1.7) | one.set(other, given(0).other) | one.start(), 0);
  bool changed = true, early = true;
  double time = 0, last = 0;
  EXPECT_EQ(one.step(0, kCommunication), kError) << "it begins in event mode";
  for (int k = 0; k < 10; ++k) {
    if (k > 0) {
      EXPECT_EQ(one.call("EnterEventMode"), 0);
      EXPECT_EQ(one.call("EnterContinuousTimeMode"), kError) << "that is model exchange";
    }
    EXPECT_EQ(one.set(torque, given(k).torque), 0);
    EXPECT_EQ(one.update(changed), 0);
    EXPECT_FALSE(changed);
    EXPECT_EQ(one.call("EnterStepMode"), 0);
    EXPECT_EQ(one.set(other, given(k).other), 0);
    told.clear();
    EXPECT_EQ(one.step(time, kCommunication, early, last), 0) << one.log.text;
    EXPECT_FALSE(early);
    EXPECT_EQ(last, time + kCommunication);
    ASSERT_GE(told.size(), 5u) << "the integrator's own steps";
    EXPECT_EQ(told.back(), last);
    EXPECT_GT(told.front(), time);
    time = last;
    Values values;
    EXPECT_EQ(one.get(outputs, values), 0);
    EXPECT_EQ(values, exact[static_cast<std::size_t>(k)]) << k;
  }
  // Ends at the first step beyond what the importer wants, and goes on from there.
  wanted_end = time + 0.4 * kCommunication;
  EXPECT_EQ(one.step(time, kCommunication, early, last), 0);
  EXPECT_TRUE(early);
  EXPECT_GE(last, wanted_end);
  EXPECT_LT(last, time + 0.7 * kCommunication);
  EXPECT_EQ(last, told.back());
  Values values;
  EXPECT_EQ(one.get(outputs, values), 0);
  EXPECT_EQ(values, seen);
  wanted_end = 1e9;
  EXPECT_EQ(one.step(last, time + kCommunication - last), 0) << one.log.text;
  EXPECT_EQ(one.call("EnterEventMode") | one.call("Terminate"), 0);
}

std::string hexadecimal(const std::vector<unsigned char>& bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const unsigned char byte : bytes) text += {kDigits[byte / 16], kDigits[byte % 16]};
  return text;
}

/// All that an importer does with one.
void drive(const Case& c) {
  const ScriptFolder scratch;
  const UnpackedFmu fmu(scratch, c.scene, c.version, c.options);
  ASSERT_TRUE(fs::exists(fmu.library)) << fmu.library;
  const std::string token = fmu.token();
  const FmuLibrary library(fmu.library);

  // 1. Every function of the standard is there.
  std::ifstream list(std::string(LITHE_TEST_DATA) + "/fmi/functions-" + std::to_string(c.version) + ".0.txt");
  int functions = 0;
  const std::regex declared("^[\\w* ]+?\\*? ?(fmi[23][A-Za-z0-9]+)\\(.*");
  for (std::string line; std::getline(list, line);) {
    std::smatch found;
    if (line.starts_with("#") || line.find("(*") != std::string::npos) continue;
    if (!std::regex_match(line, found, declared)) continue;
    EXPECT_TRUE(library.has(found[1])) << found[1];
    ++functions;
  }
  EXPECT_EQ(functions, c.version == 3 ? 75 : 44);

  // 2. Co-simulation is the native run, bit for bit, also in a second instance at the same time, and each step in a
  // thread of its own: four threads at once.
  constexpr int kSteps = 40;
  const std::vector<Values> exact = native(scratch, c.scene, c.other, kSteps);
  ASSERT_EQ(exact.size(), std::size_t{kSteps});
  const unsigned torque = fmu.reference("torque"), stiffness = fmu.reference("stiffness"),
                 other = fmu.reference(c.other);
  std::vector<unsigned> outputs(exact[0].size());
  const unsigned first = fmu.reference("angle");
  for (std::size_t i = 0; i < outputs.size(); ++i) outputs[i] = first + static_cast<unsigned>(i);
  const auto begin = [&](ImportedInstance& one) {
    EXPECT_EQ(one.set(stiffness, 1.7), 0);
    EXPECT_EQ(one.set(other, given(0).other), 0);
    EXPECT_EQ(one.start(), 0);
  };
  const auto advance = [&](ImportedInstance& one, int k, double& time, Values& values) {
    int worst = one.set(torque, given(k).torque);
    worst |= one.set(other, given(k).other);
    worst |= one.step(time, kCommunication);
    time += kCommunication;
    worst |= one.get(outputs, values);
    EXPECT_EQ(worst, 0) << one.log.text;
  };
  const auto run = [&](std::vector<Values>& rows) {
    ImportedInstance one(library, token, c.version);
    begin(one);
    double time = 0;
    for (int k = 0; k < kSteps; ++k) std::thread([&] { advance(one, k, time, rows.emplace_back()); }).join();
  };
  std::vector<Values> rows[2];
  std::thread beside([&] { run(rows[1]); });
  run(rows[0]);
  beside.join();
  for (const auto& mine : rows)
    for (int k = 0; k < kSteps; ++k)
      EXPECT_EQ(mine[static_cast<std::size_t>(k)], exact[static_cast<std::size_t>(k)]) << k;

  // 3. Rolled back, and carried over to another instance, and to one in another process: the same bits again, a hundred
  // times.
  std::mt19937 random(7);
  std::string cases;
  std::vector<Values> wanted;
  ImportedInstance one(library, token, c.version, true), two(library, token, c.version);
  begin(one);
  double time = 0;
  int k = 0;
  for (int trial = 0; trial < 100; ++trial) {
    void* state = nullptr;
    ASSERT_EQ(one.save(&state), 0) << one.log.text;
    const int saved = k, ahead = 1 + static_cast<int>(random() % 3);
    const double saved_time = time;
    std::vector<Values> forth, again, there;
    for (int i = 0; i < ahead; ++i) advance(one, k++, time, forth.emplace_back());
    ASSERT_EQ(one.restore(state), 0) << one.log.text;
    k = saved, time = saved_time;
    for (int i = 0; i < ahead; ++i) advance(one, k++, time, again.emplace_back());
    ASSERT_EQ(forth, again) << trial;
    void* copy = nullptr;
    const std::vector<unsigned char> bytes = one.serialized(state);
    cases += hexadecimal(bytes) + " " + exact_text(saved_time);
    for (int i = 0; i < ahead; ++i)
      cases += " " + exact_text(given(saved + i).torque) + " " + exact_text(given(saved + i).other);
    cases += "\n";
    wanted.insert(wanted.end(), forth.begin(), forth.end());
    ASSERT_EQ(two.deserialize(bytes, &copy), 0) << two.log.text;
    ASSERT_EQ(two.restore(copy), 0) << two.log.text;
    double other_time = saved_time;
    for (int i = 0; i < ahead; ++i) advance(two, saved + i, other_time, there.emplace_back());
    ASSERT_EQ(forth, there) << trial;
    if (trial % 2 == 0) one.restore(state), k = saved, time = saved_time;  // from the same copy, more than once
    EXPECT_EQ(one.forget(&state), 0);
    EXPECT_EQ(two.forget(&copy), 0);
    EXPECT_EQ(state, nullptr);
    if (k > kSteps) {
      EXPECT_EQ(one.call("Reset"), 0);
      begin(one);
      k = 0, time = 0;
    }
  }
  scratch.write("cases", cases);
  std::string references;
  for (const unsigned r : outputs) references += (references.empty() ? "" : ",") + std::to_string(r);
  const Outcome elsewhere =
      scratch.shell("python3 -B " LITHE_SOURCE_DIR "/tests/scripting/continue_fmu.py '" + fmu.library.string() + "' '" +
                    token + "' " + std::to_string(c.version) + " " + exact_text(kCommunication) + " " +
                    std::to_string(torque) + "," + std::to_string(other) + " " + references + " < cases");
  EXPECT_EQ(elsewhere.exit_code, 0) << elsewhere.output.substr(0, 1000);
  EXPECT_EQ(rows_of(elsewhere.output), wanted);
  // After Reset it is the native run again.
  EXPECT_EQ(one.call("Reset"), 0);
  begin(one);
  time = 0;
  Values values;
  for (int i = 0; i < 10; ++i) {
    advance(one, i, time, values);
    EXPECT_EQ(values, exact[static_cast<std::size_t>(i)]);
  }
  EXPECT_NE(one.log.text.find("assembled"), std::string::npos) << "milestones go to the importer's logger";

  // 4. What importers get wrong: an error, a message, and the instance lives on.
  constexpr int kError = 3;
  ImportedInstance wrong_token(library, "another", c.version);
  EXPECT_FALSE(wrong_token.exists());
  EXPECT_NE(wrong_token.log.text.find("another FMU"), std::string::npos);
  const auto refused = [&](int status, const std::string& words) {
    EXPECT_EQ(status, kError) << words;
    EXPECT_NE(one.log.text.find(words), std::string::npos) << words << " in " << one.log.text;
    one.log.text.clear();
  };
  refused(one.set(torque, 1e3), "outside its bounds");
  refused(one.set(torque, NAN), "not finite");
  refused(one.set(other, NAN), "not finite");
  refused(one.set(outputs[0], 1), "is no input or parameter");
  refused(one.get({4711}, values), "value reference 4711");
  refused(one.start(), "not allowed in this mode");
  EXPECT_EQ(one.get(outputs, values), 0);
  EXPECT_EQ(values, exact[9]);
  void* state = nullptr;
  ASSERT_EQ(one.save(&state), 0);
  std::vector<unsigned char> bytes = one.serialized(state);
  void* broken = nullptr;
  for (const std::size_t at : {std::size_t{0}, bytes.size() / 2, bytes.size() - 1}) {
    std::vector<unsigned char> damaged = bytes;
    damaged[at] ^= 1;
    refused(one.deserialize(damaged, &broken), "damaged");
  }
  bytes.resize(bytes.size() / 2);
  refused(one.deserialize(bytes, &broken), "damaged");
  bytes.clear();
  refused(one.deserialize(bytes, &broken), "damaged");
  EXPECT_EQ(broken, nullptr);
  EXPECT_EQ(one.step(time + 1, kCommunication), kError);
  EXPECT_NE(one.log.text.find("not the one reached"), std::string::npos);
  EXPECT_EQ(one.step(time, kCommunication), kError) << "after an error: restore, reset or free";
  ASSERT_EQ(one.restore(state), 0);
  advance(one, 10, time, values);
  EXPECT_EQ(values, exact[10]);
  EXPECT_EQ(one.forget(&state), 0);
  EXPECT_EQ(one.call("Terminate"), 0);
  library.call<void>(c.version == 3 ? "fmi3FreeInstance" : "fmi2FreeInstance", (void*)nullptr);

  if (c.version == 3) use_events(library, fmu, c, exact, outputs);
  if (*c.options) expect_stands_alone(scratch, fmu);

  // 5. The description, by the standard's schema, and what other importers say, where these tools are.
  expect_valid_description(scratch, c.version);
  expect_passes_importers(scratch);
}

TEST(Fmu, OfAFlexibleArmByFmi3IsTheNativeRunBitForBit) { drive({"examples/studies/driven_arm.cpp", "lift", 3}); }

TEST(Fmu, OfARigidPendulumByFmi2IsTheNativeRunBitForBit) {
  drive({"tests/scripting/fmu_pendulum.cpp", "target", 2, "--with-libraries"});
}

TEST(Fmu, IsNotMadeOfASceneThatCannotBeDrawn) {
  const ScriptFolder folder;
  folder.write("scene.cpp",
               "#include \"lithe/lithe.h\"\nlithe::StudyScene scene() { return {.name = \"x\", .draw = "
               "[](lithe::SystemGraph& graph) -> std::vector<lithe::Sensor> { "
               "graph.add<lithe::RigidBody>(\"a\", {.mass = -1}); return {}; }}; }\n");
  const Outcome made = folder.shell("lithe fmu scene.cpp");
  EXPECT_EQ(made.exit_code, 1);
  EXPECT_NE(made.output.find("mass"), std::string::npos) << made.output;
  EXPECT_FALSE(fs::exists(folder.path() / "scene.fmu"));
  folder.write("scene.cpp", "int nothing;\n");
  EXPECT_EQ(folder.shell("lithe fmu scene.cpp").exit_code, 2);
  EXPECT_EQ(folder.shell("lithe fmu missing.cpp").exit_code, 1);
}

}  // namespace
}  // namespace lithe::test::fmu_test
