// R15: the hunting wheelset of the IVP Test Set (tests/reference/wheelset.h). Mark: scd 4, good 6, on positions,
// velocities and spin at t = 10 s.
#include "tests/reference/wheelset.h"

#include <gtest/gtest.h>

#include "integrators/explicit_runge_kutta.h"
#include "tests/reference/accuracy.h"
#include "tests/support/joint_checks.h"

namespace lithe::test::r15_wheelset_test {
namespace {

Scene on_the_rails() {
  const double yaw = -0.28573e-3, roll = 0.26459e-3;
  return Scene({0, -9.81, 0}, [&](SystemGraph& graph) {
    using namespace wheelset;
    auto& body = graph.add<RigidBody>(
        "wheelset", {.mass = kMass,
                     .inertia = {kSpinInertia, kInertia, kInertia},
                     .position = {0.14941e-2, 0.40089e-6, 0.11241e-5},
                     .orientation = rotation_about({0, 1, 0}, yaw) * rotation_about({0, 0, 1}, roll)});
    const Marker middle = body.marker();
    auto& rails = graph.add<Rails>("rails", {graph.ground().marker(), middle}, {});
    graph.add<Spin>("spin", {middle}, {});
    graph.add<Suspension>("suspension", {middle}, {});
    graph.add<Creep>("creep", {middle}, {.rails = &rails});
  });
}

/// Columns of the reference: x, y, z, yaw, roll, their rates, spin, ψ and ξ right and left, multipliers (1e4 N).
std::array<double, 17> unknowns(const Scene& scene) {
  const Vector3 p = scene.position(0), v = scene.state.v.head<3>();
  const Matrix3 A = rotation_matrix(scene.state.q.segment<4>(3));
  const Vector3 a = A.col(0), omega = A * scene.state.v.segment<3>(3);
  const double yaw = std::atan2(-a.z(), a.x()), cp = std::hypot(a.x(), a.z());
  const Vector3 e3(std::sin(yaw), 0, std::cos(yaw)), e2 = e3.cross(a);
  const double yaw_rate = omega.dot(e2) / cp;
  const wheelset::Contact left(1, p, a, v, omega), right(-1, p, a, v, omega);
  const auto psi = [&](const wheelset::Contact& c) { return std::atan2(c.u.dot(e3), c.u.dot(e2)); };
  return {p.x(),
          p.y(),
          p.z(),
          yaw,
          std::atan2(a.y(), cp),
          v.x(),
          v.y(),
          v.z(),
          yaw_rate,
          omega.dot(e3),
          omega.dot(a) - yaw_rate * a.y(),
          psi(right),
          right.xi,
          psi(left),
          left.xi,
          -scene.state.lambda[0] / 1e4,
          -scene.state.lambda[1] / 1e4};
}

TEST(R15Wheelset, RailsOweWhatEveryJointOwes) {
  SystemGraph graph;
  auto& body = graph.add<RigidBody>("wheelset", {.mass = 1, .inertia = {1, 2, 2}});
  auto& rails = graph.add<wheelset::Rails>("rails", {graph.ground().marker(), body.marker()}, {});
  check_joint(graph, rails, {.rank = 2});
}

TEST(R15Wheelset, StartsWithTheTestSetsContactsAndNormalForces) {
  const Table table = reference("R15_wheelset/reference.csv");
  Scene scene = on_the_rails();
  EXPECT_EQ(scene.system.velocity_rows().size(), 2u);
  runge_kutta(1e-8)->start(scene.equations, scene.state);
  const auto now = unknowns(scene);
  for (int i = 0; i < 17; ++i) EXPECT_NEAR(now[i], table.at(0, 1 + i), 1e-11) << table.columns[1 + i];
}

/// Position, velocity and spin against the table: largest error as a part of the column's largest value up to `end`,
/// and relative at `end`.
struct Errors {
  double scaled = 0, relative = 0;
};
Errors hunt(Integrator& integrator, double end) {
  const Table table = reference("R15_wheelset/reference.csv");
  constexpr int kCompared = 11;
  std::array<double, kCompared> largest{};
  for (int row = 0; row < table.row_count(); ++row)
    for (int i = 0; i < kCompared; ++i) largest[i] = std::max(largest[i], std::abs(table.at(row, 1 + i)));
  Scene scene = on_the_rails();
  Errors errors;
  follow(scene, integrator, table, end, [&](std::span<const double> row) {
    const auto now = unknowns(scene);
    errors.relative = 0;  // the last one stays
    for (int i = 0; i < kCompared; ++i) {
      errors.scaled = std::max(errors.scaled, std::abs(now[i] - row[i]) / largest[i]);
      if (row[i] != 0) errors.relative = std::max(errors.relative, std::abs(now[i] / row[i] - 1));
    }
  });
  return errors;
}

TEST(R15Wheelset, HuntsForTenSecondsToSixDigits) {
  // The cut-off of the creep force has kinks, which end the gain of high order: a tight tolerance and short steps.
  ExplicitRungeKutta integrator({.tolerance = {.relative = 1e-11, .absolute = 1e-11}, .max_step = 1e-3});
  const Errors errors = hunt(integrator, 10);
  expect_below("R15, " + integrator.name() + ", relative error at 10 s (threshold 1e-4, good 1e-6)", errors.relative,
               1e-6);
  expect_below("R15, " + integrator.name() + ", of the largest values, 0 ... 10 s", errors.scaled, 5e-7);
}

TEST(R15Wheelset, HuntsAlikeWithImplicitMethods) {
  const Errors code = hunt(*ida(1e-9), 2), second_order = hunt(*index2(2.5e-4), 1), finer = hunt(*index2(1.25e-4), 1);
  expect_below("R15, SUNDIALS IDA, of the largest values, 0 ... 2 s", code.scaled, 3e-6);
  expect_below("R15, generalized-alpha, 2.5e-4 s, of the largest values, 0 ... 1 s", second_order.scaled, 1e-3);
  EXPECT_NEAR(second_order.scaled / finer.scaled, 4, 0.5);
}

TEST(R15Wheelset, MeetsItsMarkByDefault) {
  expect_below("R15, default at 1e-8, relative error at 10 s (mark 1e-4)", hunt(*automatic(1e-8), 10).relative, 1e-4);
  expect_accuracy(
      "R15", "11 unknowns over 10 s", 1, [](Method m) { return hunt(*m, 10).scaled; }, 300);
}

}  // namespace
}  // namespace lithe::test::r15_wheelset_test
