// R04: Bricard's closed 6R loop, 30 rows of rank 29 all along; marks 1e-4 m and 1e-4 J over 10 s, |g| < 1e-8.
#include <gtest/gtest.h>

#include "engine/assembly/evaluated.h"
#include "tests/reference/accuracy.h"
#include "tests/reference/loops.h"

namespace lithe::test::r04_bricard_test {
namespace {

Scene bricard() { return Scene({0, -9.81, 0}, draw_bricard); }

double check(Method method, double position, double energy) {
  const Table table = reference("R04_bricard/reference.csv");
  Scene scene = bricard();
  EXPECT_EQ(scene.system.rank(), 29);
  EXPECT_EQ(scene.system.degrees_of_freedom(), 1);
  const double start = scene.energy();
  EXPECT_NEAR(start, -29.43, 1e-12);
  const RigidBody& second = *static_cast<const RigidBody*>(scene.graph.bodies()[2].body);
  double p = 0, v = 0, e = 0, g = 0;
  follow(scene, *method, table, 10, [&](std::span<const double> row) {
    e = std::max(e, std::abs(scene.energy() - start));
    const MarkerKinematics end = marker_kinematics(scene.equations, {&second, 1}, Level::velocity);
    p = std::max(p, (end.p - Vector3(row[0], row[1], row[2])).norm());
    v = std::max(v, (end.v - Vector3(row[3], row[4], row[5])).norm());
    g = std::max(g, scene.violation(Level::position));
  });
  const std::string name = "R04, " + method->name();
  expect_below(name + ", P3 (m; mark 1e-4)", p, position);
  expect_below(name + ", velocity of P3 (m/s)", v, 30 * position);
  expect_below(name + ", energy (J; mark 1e-4)", e, energy);
  expect_below(name + ", |g| of all rows (mark 1e-8)", g, 1e-9);
  return p;
}

TEST(R04Bricard, FollowsTheTableWithItsRedundantRow) {
  check(runge_kutta(1e-9), 1e-8, 1e-7);
  check(index3(1e-3), 2e-5, 2e-5);
  check(index2(1e-3), 2e-5, 2e-5);
  check(ida(1e-9), 1e-5, 1e-5);
}

TEST(R04Bricard, MeetsItsMarksByDefault) {
  check(automatic(1e-6), 1e-4, 1e-4);
  expect_accuracy("R04", "P3", 1, [](Method m) { return check(std::move(m), kAny, kAny); });
}

}  // namespace
}  // namespace lithe::test::r04_bricard_test
