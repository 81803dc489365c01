// R02: N four-bar windows in a row; where the uprights lie flat the Jacobian drops rank by N and branches meet.
#include <gtest/gtest.h>

#include "tests/reference/accuracy.h"
#include "tests/reference/loops.h"

namespace lithe::test::r02_n_four_bar_test {
namespace {

Scene four_bars(int windows) {
  return Scene({0, -9.81, 0}, [&](SystemGraph& graph) { draw_four_bars(graph, windows); });
}

struct Run {
  double tip = 0, speed = 0, speed_flat = 0, lim = 0, energy = 0, spread = 0, gap = 0;
};

/// Uprights' angles are compared: where a window leaves the parallelogram branch they differ.
Run follow_uprights(int windows, Integrator& method, double end) {
  const Table table = reference("R02_n_four_bar/reference_N" + std::to_string(windows) + ".csv");
  Scene scene = four_bars(windows);
  EXPECT_EQ(scene.system.redundant_rows().size(), 3u * windows);
  EXPECT_EQ(scene.system.degrees_of_freedom(), 1);
  const double start = scene.energy();
  Run run;
  double sum = 0;
  int count = 0;
  follow(scene, method, table, end, [&](std::span<const double> row) {
    const Vector3 B = 2 * scene.position(0), v = 2 * scene.state.v.head<3>();
    const double seen[] = {B.x(), B.y(), v.x(), v.y()};
    for (int j = 0; j < 4; ++j, ++count)
      sum += std::pow((seen[j] - row[j + 2]) / std::max(std::abs(row[j + 2]), 1e-3), 2);
    run.tip = std::max(run.tip, std::hypot(seen[0] - row[2], seen[1] - row[3]));
    // Where the uprights lie flat to 0.01 rad, the least singular value of G is as small and its round-off shows in v
    // for that moment: 1.7e-9 m/s at 0.002 rad, 9e-11 at 0.003, below 5e-11 elsewhere; the pose does not keep it.
    double& speed = std::abs(B.y()) < 0.01 ? run.speed_flat : run.speed;
    speed = std::max(speed, std::hypot(seen[2] - row[4], seen[3] - row[5]));
    for (int i = 1; i <= windows; ++i)
      run.spread = std::max(run.spread, (scene.position(i) - scene.position(0) - Vector3(i, 0, 0)).norm());
    run.energy = std::max(run.energy, std::abs(scene.energy() - start));
    run.gap = std::max(run.gap, scene.violation(Level::position));
  });
  run.lim = std::sqrt(sum / count);
  return run;
}

struct Bounds {
  double tip, lim, energy;  // m, LIM error, J
};

double check(int windows, Method method, const Bounds& bounds) {
  const Run run = follow_uprights(windows, *method, windows == 2 ? 10 : 20);
  const std::string name = "R02 N = " + std::to_string(windows) + ", " + method->name();
  expect_below(name + ", B_0 (m)", run.tip, bounds.tip);
  expect_below(name + ", velocity of B_0 (m/s)", run.speed, 10 * bounds.tip);
  expect_below(name + ", its velocity in flat poses (m/s)", run.speed_flat, 100 * bounds.tip);
  expect_below(name + ", LIM error (high precision 1e-3)", run.lim, bounds.lim);
  expect_below(name + ", energy (J)", run.energy, bounds.energy);
  expect_below(name + ", uprights leave their parallels (m)", run.spread, 1e-10);
  expect_below(name + ", |g| of all rows", run.gap, 1e-10);
  return run.tip;
}

TEST(R02FourBars, TwoWindowsPassTheirSingularPositionsForTenSeconds) {
  check(2, runge_kutta(1e-8), {3e-6, 3e-5, 2e-6});
  check(2, index3(1e-3), {4e-4, 4e-3, 2e-3});  // published: 1.14e-3 J at this step
  check(2, index2(1e-3), {4e-4, 4e-3, 2e-3});
}

TEST(R02FourBars, FortyWindowsPassTheirSingularPositionsForTwentySeconds) {
  check(40, runge_kutta(1e-8), {2e-5, 1e-4, 5e-5});
}

/// What explicit steps reach near the singular poses is noise of 1e-8; the way across begins before them.
TEST(R02FourBars, KeepTenDigitsThroughTheirSingularPositions) {
  check(2, runge_kutta8(1e-13), {1e-10, kAny, 1e-7});
  check(2, automatic(1e-12), {1e-10, kAny, 1e-7});
  check(40, runge_kutta8(1e-13), {1e-10, kAny, 1e-6});
}

TEST(R02FourBars, MeetTheirMarksByDefault) {
  check(2, automatic(1e-6), {kAny, 1e-3, kAny});
  for (int windows : {2, 40})
    expect_accuracy("R02 N = " + std::to_string(windows), "B_0", 1, [=](Method m) {
      return check(windows, std::move(m), {kAny, kAny, kAny});
    });
}

}  // namespace
}  // namespace lithe::test::r02_n_four_bar_test
