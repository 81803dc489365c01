// What an FMU's step costs beside that of the run that it is: told, not asserted, since a busy machine blurs it.
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <limits>

#include "tests/scripting/command.h"
#include "tests/scripting/fmu_importer.h"
#include "tests/scripting/fmu_pendulum.cpp"

namespace lithe::test::fmu_overhead_test {
namespace {

constexpr double kStep = 1e-3;  // s, of the integrator, and between communication points

double cpu_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

TEST(FmuOverhead, IsToldOfStepsThatAreTheNativeOnes) {
  const ScriptFolder scratch;
  const UnpackedFmu fmu(scratch, "tests/scripting/fmu_pendulum.cpp", 3);
  const FmuLibrary library(fmu.library);
  ImportedInstance one(library, fmu.token(), 3);
  ASSERT_EQ(one.start(), 0);
  const StudyScene study = scene();
  SystemGraph graph({.gravity = study.gravity});
  const std::vector<Sensor> sensors = study.draw(graph);
  const System system = assemble(graph);
  GeneralizedAlpha method{{.step = kStep}};
  Simulation simulation{system, method};
  State state = system.initial_state();

  // By turns, the least of each: other programs only add.
  constexpr int kRounds = 40, kSteps = 250;
  double here = std::numeric_limits<double>::infinity(), there = here, time = 0;
  int worst = 0;
  for (int round = 0; round < kRounds; ++round) {
    double begun = cpu_time();
    for (int i = 0; i < kSteps; ++i) simulation.run(state, state.time + kStep);
    here = std::min(here, cpu_time() - begun);
    begun = cpu_time();
    for (int i = 0; i < kSteps; ++i) {
      worst |= one.step(time, kStep);
      time += kStep;
    }
    there = std::min(there, cpu_time() - begun);
  }
  EXPECT_EQ(worst, 0) << one.log.text;
  std::printf("a step: %.2f us in the native run, %.2f us in the FMU\n", 1e6 * here / kSteps, 1e6 * there / kSteps);
  std::vector<double> angle;
  EXPECT_EQ(one.get({fmu.reference("angle")}, angle), 0);
  Snapshot now(system, state);
  EXPECT_EQ(angle[0], sensors[0].value(now));
}

}  // namespace
}  // namespace lithe::test::fmu_overhead_test
