// Inputs that an importer sets within communication steps (FMI 3.0), against the same run by Simulation, bit for bit.
#include <gtest/gtest.h>

#include <string>
#include <tuple>
#include <vector>

#include "tests/scripting/command.h"
#include "tests/scripting/fmu_importer.h"

namespace lithe::test::fmu_intermediate_test {
namespace {

using Values = std::vector<double>;

constexpr int kSteps = 24;
constexpr const char* kScene = "tests/scripting/fmu_pendulum.cpp";

/// What is set in the n-th update: the torque is held, the target linear. Here and in the native program, which has
/// this text.
#define LITHE_GIVEN_WITHIN                                                                                      \
  struct Within {                                                                                               \
    bool jumps, bends;                                                                                          \
    double torque, target;                                                                                      \
  };                                                                                                            \
  inline Within within(int n) { return {n % 3 == 0, n % 4 == 1, (n * 7 % 11 - 5) / 8.0, 0.25 + n % 5 / 64.0}; } \
  inline double torque_of_step(int k) { return k % 3 == 1 ? (k % 5 - 2) / 4.0 : 99; /* 99: not set */ }         \
  constexpr double kCommunication = 0.0123;
#define LITHE_TEXT_OF(...) #__VA_ARGS__
#define LITHE_TEXT(...) LITHE_TEXT_OF(__VA_ARGS__)
LITHE_GIVEN_WITHIN

/// After each step of the integrator the outputs, then those with what is set there; and the outputs of each
/// communication step.
std::vector<Values> native(const ScriptFolder& scratch) {
  return native_rows(scratch, kScene, LITHE_TEXT(LITHE_GIVEN_WITHIN) R"(
#include <functional>
struct Setter final : Observer {
  std::function<void(const State&)> set;
  void observe(Snapshot& now) override { set(now.state()); }
};
)",
                     R"(
  Input &torque = graph.input("torque"), &target = graph.input("target");
  double begun = 0, end = 0, given = 0;
  int updates = 0;
  Setter setter;
  setter.set = [&](const State& at) {
    if (at.time == begun) return;
    print(at, Accelerations::solved);
    const Within w = within(updates++);
    if (w.jumps) torque.set(at.time, w.torque);
    if (w.bends) given = w.target;
    if (w.bends && at.time < end) target.reset(at.time, target.value(at.time)), target.set(end, given);
    if (at.time < end) print(at, Accelerations::solved);
  };
  simulation.observe(setter, every_step());
  for (int k = 0; k < 24; ++k) {
    begun = state.time, end = begun + kCommunication;
    if (torque_of_step(k) != 99) torque.reset(begun, torque_of_step(k));
    if (const double present = target.value(begun); present != given)
      target.reset(begun, present), target.set(end, given);
    simulation.run(state, end);
    print(state, Accelerations::solved);
  }
)");
}

TEST(Fmu, TakesInputsWithinCommunicationStepsAsTheNativeRunDoes) {
  const ScriptFolder scratch;
  const UnpackedFmu fmu(scratch, kScene, 3);
  const std::vector<Values> exact = native(scratch);
  ASSERT_GT(exact.size(), std::size_t{20 * kSteps});
  const FmuLibrary library(fmu.library);
  const unsigned torque = fmu.reference("torque"), target = fmu.reference("target"), first = fmu.reference("angle");
  std::vector<unsigned> outputs(exact[0].size());
  for (std::size_t i = 0; i < outputs.size(); ++i) outputs[i] = first + static_cast<unsigned>(i);

  ImportedInstance* here = nullptr;
  std::vector<Values> rows;
  double end = 0;
  int updates = 0, jumps_seen = 0;
  const auto look = [&] { EXPECT_EQ(here->get(outputs, rows.emplace_back()), 0) << here->log.text; };
  ImportedInstance one(library, fmu.token(), [&](double time, bool) {
    look();
    const Within w = within(updates++);
    EXPECT_EQ(w.jumps ? here->set(torque, w.torque) : 0, 0) << here->log.text;
    EXPECT_EQ(w.bends ? here->set(target, w.target) : 0, 0) << here->log.text;
    if (time >= end) return false;
    look();
    jumps_seen += rows[rows.size() - 2] != rows.back();
    return false;
  });
  here = &one;
  ASSERT_TRUE(one.exists());
  EXPECT_EQ(one.start() | one.call("EnterStepMode"), 0);
  double time = 0;
  const auto advance = [&](int k) {
    EXPECT_EQ(torque_of_step(k) != 99 ? one.set(torque, torque_of_step(k)) : 0, 0);
    bool early = true;
    double last = 0;
    end = time + kCommunication;
    EXPECT_EQ(one.step(time, kCommunication, early, last), 0) << one.log.text;
    EXPECT_FALSE(early);
    time = last;
    look();
  };
  // Half of it, the rest, and this again from a state that was saved: what was set within steps is part of it.
  for (int k = 0; k < kSteps / 2; ++k) advance(k);
  void* state = nullptr;
  ASSERT_EQ(one.save(&state), 0);
  const auto saved = [&, time, updates, count = rows.size()] { return std::tuple(time, updates, count); }();
  for (int k = kSteps / 2; k < kSteps; ++k) advance(k);
  EXPECT_EQ(rows, exact);
  EXPECT_GT(jumps_seen, 50) << "outputs after a jump are those with the new torque";
  ASSERT_EQ(one.restore(state), 0);
  std::size_t count = 0;
  std::tie(time, updates, count) = saved;
  rows.resize(count);
  for (int k = kSteps / 2; k < kSteps; ++k) advance(k);
  EXPECT_EQ(rows, exact);
  EXPECT_EQ(one.forget(&state), 0);
  const auto says = [&](const char* input, const char* words) {
    const std::size_t at = fmu.description.find(std::string("<Float64 name=\"") + input + "\"");
    return fmu.description.substr(at, fmu.description.find('>', at) - at).find(words) != std::string::npos;
  };
  EXPECT_TRUE(says("torque", "intermediateUpdate=\"true\"") && says("target", "intermediateUpdate=\"true\""));
  EXPECT_TRUE(says("stiffness", "tunable") && !says("stiffness", "intermediateUpdate"));
}

}  // namespace
}  // namespace lithe::test::fmu_intermediate_test
