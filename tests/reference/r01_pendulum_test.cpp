// R01: point mass on a massless rod, as a free body and a distance joint (not a relative angle).
#include <gtest/gtest.h>

#include "tests/reference/accuracy.h"

namespace lithe::test::r01_pendulum_test {
namespace {

constexpr double kPeriod = 2.36784194757623744930;

struct Trial {
  Method method;
  double energy, position, period;  // bounds: J, m, relative
};

/// Largest error of the position, m.
double check_motion(Trial run) {
  const Table table = reference("R01_simple_pendulum/reference.csv");
  Scene scene = mass_chain({-M_PI / 2});
  const double start = scene.energy();
  double energy = 0, position = 0, rod = 0, velocity = 0;
  follow(scene, *run.method, table, 10, [&](std::span<const double> row) {
    energy = std::max(energy, std::abs(scene.energy() - start));
    position = std::max(position, (scene.position(0) - Vector3(row[0], row[1], 0)).norm());
    rod = std::max(rod, std::abs(scene.position(0).norm() - 1));
    velocity = std::max(velocity, (scene.state.v.head<3>() - Vector3(row[2], row[3], 0)).norm());
  });
  // At 8 ¼ periods it passes the lowest point: what it lacks there is time.
  Scene again = mass_chain({-M_PI / 2});
  again.run(*run.method, 8.25 * kPeriod);
  const double lag = again.position(0).x() / again.state.v[0] / (8.25 * kPeriod);
  const std::string name = "R01 A, " + run.method->name();
  expect_below(name + ", energy (J; mark 5e-5)", energy, run.energy);
  expect_below(name + ", position (m)", position, run.position);
  expect_below(name + ", velocity (m/s)", velocity, 5 * run.position);
  expect_below(name + ", rod's length (m)", rod, 1e-9);
  expect_below(name + ", period (relative)", std::abs(lag), run.period);
  return position;
}

TEST(R01Pendulum, KeepsEnergyPhaseAndPeriodForTenSeconds) {
  check_motion({runge_kutta(1e-8), 2e-7, 1e-7, 2e-7});
  check_motion({ida(1e-9), 5e-6, 3e-6, 2e-7});
  check_motion({index3(8e-4), 5e-5, 2e-4, 5e-6});
  check_motion({index2(8e-4), 5e-5, 2e-4, 5e-6});
}

/// LIM error (González et al. 2006): relative, threshold 1e-3, root mean square over times and quantities.
double lim_error(Integrator& integrator) {
  const Table table = reference("R01_simple_pendulum/reference_2000s.csv");
  Scene scene = mass_chain({M_PI / 2});
  double sum = 0;
  int count = 0;
  follow(scene, integrator, table, 2000, [&](std::span<const double> row) {
    for (int j = 0; j < 2; ++j, ++count) {
      const double error = (scene.position(0)[j] - row[j]) / std::max(std::abs(row[j]), 1e-3);
      sum += error * error;
    }
  });
  return std::sqrt(sum / count);
}

TEST(R01Pendulum, KeepsItsPhaseOverTwoThousandSeconds) {
  expect_below("R01 B, explicit Runge-Kutta 1e-11, LIM error (high precision 1e-3)", lim_error(*runge_kutta(1e-11)),
               1e-3);
  expect_below("R01 B, index 3, 5e-4 s, LIM error (low precision 1e-1)", lim_error(*index3(5e-4)), 1e-1);
}

TEST(R01Pendulum, MeetsItsMarksByDefault) {
  check_motion({automatic(1e-6), 5e-5, kAny, kAny});
  expect_below("R01 B, default at 1e-9, LIM error (high precision 1e-3)", lim_error(*automatic(1e-9)), 1e-3);
  expect_accuracy("R01 A", "position", 1, [](Method m) { return check_motion({std::move(m), kAny, kAny, kAny}); });
}

}  // namespace
}  // namespace lithe::test::r01_pendulum_test
