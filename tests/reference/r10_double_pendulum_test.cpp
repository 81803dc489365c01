// R10: double pendulum of point masses, A mild, B chaotic: in double precision no better than 1e-9 at 10 s.
#include <gtest/gtest.h>

#include "tests/reference/accuracy.h"

namespace lithe::test::r10_double_pendulum_test {
namespace {

struct Trial {
  Method method;
  double early, late, energy;  // bounds: m up to 5 s, m up to 10 s, J
};

double check(const std::string& variant, double angle, Trial run) {
  const Table table = reference("R10_double_pendulum/reference_" + variant + ".csv");
  Scene scene = mass_chain({angle, angle});
  const double start = scene.energy();
  double early = 0, late = 0, energy = 0;
  follow(scene, *run.method, table, 10, [&](std::span<const double> row) {
    const Vector3 first(std::sin(row[0]), -std::cos(row[0]), 0), second(row[4], row[5], 0);
    const double error = std::max((scene.position(0) - first).norm(), (scene.position(1) - second).norm());
    late = std::max(late, error);
    if (scene.state.time <= 5) early = late;
    energy = std::max(energy, std::abs(scene.energy() - start));
  });
  const std::string name = "R10 " + variant + ", " + run.method->name();
  expect_below(name + ", masses to 5 s (m)", early, run.early);
  expect_below(name + ", masses to 10 s (m)", late, run.late);
  expect_below(name + ", energy (J)", energy, run.energy);
  return late;
}

TEST(R10DoublePendulum, FollowsTheMildMotionForTenSeconds) {
  check("A", M_PI / 2, {runge_kutta(1e-10), 1e-8, 3e-7, 1e-7});
  check("A", M_PI / 2, {ida(1e-11), 1e-7, 3e-7, 3e-7});
  check("A", M_PI / 2, {index3(2e-4), 1e-5, 2e-4, 4e-4});
  check("A", M_PI / 2, {index2(2e-4), 1e-5, 2e-4, 4e-4});
}

TEST(R10DoublePendulum, FollowsTheChaoticMotionForTenSeconds) {
  check("B", 3 * M_PI / 4, {runge_kutta(1e-14), 3e-10, 3e-6, 3e-11});
  check("B", 3 * M_PI / 4, {ida(1e-12), 5e-7, 3e-3, 1e-7});
}

TEST(R10DoublePendulum, IsFollowedByDefault) {
  expect_accuracy("R10 A", "masses to 10 s", 2, [](Method m) {
    return check("A", M_PI / 2, {std::move(m), kAny, kAny, kAny});
  });
  expect_accuracy(
      "R10 B", "masses to 10 s", 2,
      [](Method m) {
        return check("B", 3 * M_PI / 4, {std::move(m), kAny, kAny, kAny});
      },
      1e6);
}

}  // namespace
}  // namespace lithe::test::r10_double_pendulum_test
