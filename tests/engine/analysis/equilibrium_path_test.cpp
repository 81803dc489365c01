// Paths of equilibria against closed forms: past limit points, where a load alone finds nothing near.
#include "engine/analysis/equilibrium_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/engine/output/output_scratch_folder.h"

namespace lithe::test::equilibrium_path_test {
namespace {

/// Two bars from (±1, 0, 0) to a hinge that slides along z, drawn at height 0.4 m without load (von Mises 1923). They
/// are springs; the load on the hinge is t times 100 N, downwards.
///   100 t = 2 k z (l₀/l - 1), l² = 1 + z²
struct Truss {
  static constexpr double kHeight = 0.4, kStiffness = 1000, kLoad = 100;
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  Truss() {
    auto& hinge = graph.add<RigidBody>("hinge", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = {0, 0, kHeight}});
    graph.add<PrismaticJoint>("guide", {graph.ground().marker(), hinge.marker()});
    for (const double side : {-1.0, 1.0})
      graph.add<SpringDamper>(side < 0 ? "left" : "right", {graph.ground().marker({side, 0, 0}), hinge.marker()},
                              {.stiffness = kStiffness, .natural_length = std::hypot(1, kHeight)});
    graph.add<UserForce>("load", {hinge.marker()}, {[](double t, const MarkerView&) {
                           return force({0, 0, -kLoad * t});
                         }});
  }
  static double load_at(double z) {
    return 2 * kStiffness * z * (std::hypot(1, kHeight) / std::hypot(1, z) - 1) / kLoad;
  }
  /// dP/dz = 0: l³ = l₀.
  static double limit() {
    const double l = std::cbrt(std::hypot(1, kHeight));
    return load_at(std::sqrt(l * l - 1));
  }
};

TEST(EquilibriumPath, LeadsATrussThroughBothLimitPoints) {
  Truss truss;
  const System system = assemble(truss.graph);
  const State start = find_equilibrium(system, system.initial_state()).state;
  const EquilibriumPath path = follow_equilibria(system, start);
  double most = 0, least = 0, last = 1;
  for (const State& s : path.states) {
    const double z = s.q[2];
    EXPECT_NEAR(s.time, Truss::load_at(z), 1e-8) << z;
    EXPECT_LE(z, last);  // it never turns back
    last = z;
    if (z > 0) most = std::max(most, s.time);
    least = std::min(least, s.time);
  }
  EXPECT_EQ(path.states.back().time, 1);
  EXPECT_LT(path.states.back().q[2], -Truss::kHeight);
  // Both limit points, as far as the states are dense: some 28 of them.
  EXPECT_NEAR(most, Truss::limit(), 0.1 * Truss::limit());
  EXPECT_LE(most, Truss::limit() + 1e-9);
  EXPECT_NEAR(least, -Truss::limit(), 0.1 * Truss::limit());
  EXPECT_LT(path.states.size(), 40u);
  EXPECT_LT(path.iterations, 8 * static_cast<int>(path.states.size()));
  std::printf("truss: %zu states, %d iterations, limit %.6f of %.6f\n", path.states.size(), path.iterations, most,
              Truss::limit());
}

TEST(EquilibriumPath, IsWhereTheTrussWouldHaveSnapped) {
  // Under the whole load at once it snaps through, to the same end.
  Truss truss;
  const System system = assemble(truss.graph);
  const EquilibriumPath path = follow_equilibria(system, find_equilibrium(system, system.initial_state()).state);
  State loaded = system.initial_state();
  loaded.time = 1;
  const Equilibrium snapped = find_equilibrium(system, loaded);
  EXPECT_NEAR(snapped.state.q[2], path.states.back().q[2], 1e-9);
  EXPECT_LE(snapped.iterations, 30);
  EXPECT_GT(linearize(system, snapped.state).lowest_stiffness(), 0);
  std::printf("snap-through: %d load steps, %d iterations\n", snapped.load_steps, snapped.iterations);
}

TEST(EquilibriumPath, FollowsAnImperfectColumnPastItsBucklingLoad) {
  // A rigid column of 1 m on a torsional spring, drawn leaning by a₀: P sin a = k (a - a₀); the load is 3 t k.
  constexpr double k = 50, lean = 0.01;
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  const Matrix3 axis = rotation_about({1, 0, 0}, -M_PI / 2), A = rotation_about({0, 1, 0}, lean);
  auto& column = graph.add<RigidBody>(
      "column", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = A * Vector3(0, 0, 0.5), .orientation = A});
  auto& pin =
      graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, axis), column.marker({0, 0, -0.5}, axis)});
  graph.add<CoordinateSpring>("spring", {pin.angle()}, {.stiffness = k});
  graph.add<UserForce>("load", {column.marker({0, 0, 0.5})}, {[](double t, const MarkerView&) {
                         return force({0, 0, -3 * k * t});
                       }});
  const System system = assemble(graph);
  const EquilibriumPath path = follow_equilibria(system, find_equilibrium(system, system.initial_state()).state);
  double farthest = 0;
  for (const State& s : path.states) {
    const double a = std::atan2(s.q[0], s.q[2]);
    EXPECT_NEAR(3 * s.time * std::sin(a), a - lean, 1e-8);
    EXPECT_GE(a, farthest);
    farthest = a;
  }
  EXPECT_GT(farthest, 2);  // 3 sin a = a - a₀: 2.28
}

TEST(EquilibriumPath, TurnsWithADriveAsFarAsItSays) {
  // An arm that a drive turns by 6 t rad carries a hanging rod: the rod stays upright.
  SystemGraph graph;
  const Matrix3 axis = rotation_about({1, 0, 0}, -M_PI / 2);
  auto& arm = graph.add<RigidBody>("arm", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = {0.5, 0, 0}});
  auto& rod = graph.add<RigidBody>("rod", {.mass = 2, .inertia = {0.1, 0.1, 0.1}, .position = {1, 0, -0.3}});
  auto& pivot =
      graph.add<RevoluteJoint>("pivot", {graph.ground().marker({0, 0, 0}, axis), arm.marker({-0.5, 0, 0}, axis)});
  graph.add<CoordinateDrive>("drive", {pivot.angle()}, {.motion = [](double t) { return Motion{6 * t, 6, 0}; }});
  graph.add<RevoluteJoint>("pin", {arm.marker({0.5, 0, 0}, axis), rod.marker({0, 0, 0.3}, axis)});
  const System system = assemble(graph);
  const EquilibriumPath path = follow_equilibria(system, find_equilibrium(system, system.initial_state()).state);
  for (const State& s : path.states) {
    const Vector3 end(std::cos(6 * s.time), 0, -std::sin(6 * s.time));
    EXPECT_LT((s.q.segment<3>(0) - 0.5 * end).norm(), 1e-9);
    EXPECT_LT((s.q.segment<3>(7) - end - Vector3(0, 0, -0.3)).norm(), 1e-9);
  }
  EXPECT_GE(path.states.size(), 30u);  // 6 rad by 0.2
}

TEST(EquilibriumPath, AsksForAStartInBalanceAndSaysWhereItWasLost) {
  Truss truss;
  const System system = assemble(truss.graph);
  State off = find_equilibrium(system, system.initial_state()).state;
  off.q[2] -= 0.1;
  EXPECT_THAT(message_of<SceneError>([&] { follow_equilibria(system, off); }), testing::HasSubstr("not in balance"));
  const State start = find_equilibrium(system, system.initial_state()).state;
  EXPECT_THAT(message_of<SimulationError>([&] { follow_equilibria(system, start, {.max_states = 5}); }),
              testing::HasSubstr("max_states"));
}

}  // namespace
}  // namespace lithe::test::equilibrium_path_test
