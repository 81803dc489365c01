// R12: planar four-bar of 3-D hinges: 20 rows of rank 17; mark 1e-6 m over 5 s.
#include <gtest/gtest.h>

#include "joints/revolute_joint.h"
#include "tests/reference/accuracy.h"
#include "tests/reference/mechanism.h"

namespace lithe::test::r12_redundant_four_bar_test {
namespace {

/// Crank O-A, coupler A-B, rocker D-B (bodies 0, 1, 2); the crank turns at 6 rad/s.
Scene four_bar() {
  return Scene({0, -9.81, 0}, [](SystemGraph& graph) {
    const Vector3 O(0, 0, 0), D(1.4, 0, 0), A(0, 0.5, 0);
    const Vector3 v_A(-3, 0, 0), B(1.109610152249955961, 0.9569084262998764912, 0),
        v_B(-2.666762317410566574, -0.8092735752498505519, 0);
    const Part crank = rod(graph, "crank", O, A, 0.5, 0, {0, 0, 0}, v_A);
    const Part coupler = rod(graph, "coupler", A, B, 1.2, 0, v_A, v_B);
    const Part rocker = rod(graph, "rocker", D, B, 1.0, 0, {0, 0, 0}, v_B);
    graph.add<RevoluteJoint>("O", {graph.ground().marker(O), crank.at(O)});
    graph.add<RevoluteJoint>("A", {crank.at(A), coupler.at(A)});
    graph.add<RevoluteJoint>("B", {coupler.at(B), rocker.at(B)});
    graph.add<RevoluteJoint>("D", {graph.ground().marker(D), rocker.at(D)});
  });
}

double check(Method method, double position, double velocity, double energy) {
  const Table table = reference("R12_redundant_four_bar/reference.csv");
  Scene scene = four_bar();
  EXPECT_EQ(scene.system.rank(), 17);
  EXPECT_EQ(scene.system.redundant_rows().size(), 3u);
  EXPECT_EQ(scene.system.degrees_of_freedom(), 1);
  const double start = scene.energy();
  EXPECT_NEAR(start, 21.4930393769398, 1e-12);
  double p = 0, v = 0, e = 0, g = 0;
  follow(scene, *method, table, 5, [&](std::span<const double> row) {
    const Vector3 A = 2 * scene.position(0), B = 2 * scene.position(2) - Vector3(1.4, 0, 0);
    p = std::max({p, (B - Vector3(row[0], row[1], 0)).norm(), (A - Vector3(row[4], row[5], 0)).norm()});
    v = std::max(v, (2 * scene.state.v.segment<3>(12) - Vector3(row[2], row[3], 0)).norm());
    e = std::max(e, std::abs(scene.energy() - start));
    g = std::max(g, scene.violation(Level::position));
  });
  const std::string name = "R12, " + method->name();
  expect_below(name + ", A and B (m; mark 1e-6)", p, position);
  expect_below(name + ", velocity of B (m/s)", v, velocity);
  expect_below(name + ", energy (J)", e, energy);
  expect_below(name + ", |g| of all rows, the redundant ones too", g, 1e-10);
  return p;
}

TEST(R12RedundantFourBar, MeetsTheTableAndNamesThreeRedundantRows) {
  check(runge_kutta(1e-10), 1e-7, 1e-6, 1e-7);
  check(index2(5e-4), 5e-4, 5e-3, 1e-3);
}

TEST(R12RedundantFourBar, MeetsItsMarkByDefault) {
  check(automatic(1e-8), 1e-6, kAny, kAny);
  expect_accuracy("R12", "A and B over 5 s", 1, [](Method m) { return check(std::move(m), kAny, kAny, kAny); });
}

}  // namespace
}  // namespace lithe::test::r12_redundant_four_bar_test
