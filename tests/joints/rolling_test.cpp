#include <gtest/gtest.h>

#include "joints/coordinate_drive.h"
#include "joints/rolling_disc.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/joint_checks.h"
#include "tests/support/pairs.h"

/// The disc that rolls without slip.
namespace lithe::test::rolling_test {
namespace {

constexpr double kGravity = 9.81, kMass = 2, kRadius = 0.3;
constexpr double kAxial = 0.5 * kMass * kRadius * kRadius, kAcross = 0.5 * kAxial;

TEST(RollingDisc, LeavesThreeVelocitiesFree) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SystemGraph graph;
    std::vector<Marker> m = pair.draw(graph, {0.2, -0.3, 0.4});
    // Markers are drawn parallel: the plane is taken along their x, so that the disc stands.
    auto& post = graph.add<RigidBody>("post", {.orientation = rotation_exp(Vector3(0.4, -0.7, 0.9))});
    auto& disc = graph.add<RollingDisc>("disc", {post.marker({}, rotation_about({0, 1, 0}, kPi / 2)), m[1]},
                                        {.radius = kRadius});
    check_joint(graph, disc, {.rank = 3, .tolerance = 1e-6});
  }
  for (const Pair& pair : pairs()) {  // and the plane on every kind of body
    SCOPED_TRACE(pair.name);
    SystemGraph graph;
    std::vector<Marker> m = pair.draw(graph, {0.2, -0.3, 0.4});
    auto& wheel = graph.add<RigidBody>("wheel", {.orientation = rotation_exp(Vector3(1.3, 0.7, 0.2))});
    auto& disc = graph.add<RollingDisc>("disc", {m[0], wheel.marker()}, {.radius = kRadius});
    check_joint(graph, disc, {.rank = 3, .tolerance = 1e-6});
  }
}

RigidBody::Parameters disc_body(const Vector3& position, const Matrix3& axes, const Vector3& velocity,
                                const Vector3& turn) {
  return {.mass = kMass,
          .inertia = {kAcross, kAcross, kAxial},
          .position = position,
          .orientation = axes,
          .velocity = velocity,
          .angular_velocity = Vector3(axes.transpose() * turn)};
}

/// Down a slope: a = g sin α / (1 + J / (m r²)); friction is what turns it.
TEST(RollingDisc, RollsDownASlopeSlowerThanItWouldSlide) {
  const double slope = 0.3, a = kGravity * std::sin(slope) / (1 + kAxial / (kMass * kRadius * kRadius));
  const Matrix3 axle_y = rotation_about({1, 0, 0}, -kPi / 2);  // z of the disc is y
  for (auto& [name, method] : every_method(1e-3)) {
    SCOPED_TRACE(name);
    RollingDisc* rolling;
    Scene scene({kGravity * std::sin(slope), 0, -kGravity * std::cos(slope)}, [&](SystemGraph& graph) {
      auto& wheel = graph.add<RigidBody>("wheel", disc_body({0, 0, kRadius}, axle_y, Vector3::Zero(), Vector3::Zero()));
      rolling = &graph.add<RollingDisc>("rolling", {graph.ground().marker(), wheel.marker()}, {.radius = kRadius});
    });
    EXPECT_EQ(scene.system.degrees_of_freedom(), 3);
    scene.run(*method, 1.5);
    EXPECT_NEAR(scene.position(0)[0], 0.5 * a * 2.25, 1e-6);
    EXPECT_NEAR(scene.state.v[0], 1.5 * a, 1e-6);
    EXPECT_NEAR(scene.position(0)[2], kRadius, 1e-9);
    const Vector3 F = read_vector(scene, reaction(*rolling, 1));
    EXPECT_LT((F - Vector3(kMass * (a - kGravity * std::sin(slope)), 0, kMass * kGravity * std::cos(slope))).norm(),
              1e-5);
    EXPECT_NEAR(read(scene, power(*rolling)), 0, 1e-9);
  }
}

/// Round and round, leaning inwards by π/2 - θ: centre on a circle of radius ρ, axle at θ from the vertical, at
///   Ω² = m g r cos θ / (sin θ ((m r + C/r) ρ + A cos θ)),   C, A: inertia about the axle and across it,
/// from dL/dt = Ω n × L about the centre; the contact carries m g and pulls inwards by m Ω² ρ.
TEST(RollingDisc, RollsSteadilyInACircle) {
  const double theta = 1.2, rho = 1.5, c = std::cos(theta), s = std::sin(theta);
  const double Omega =
      std::sqrt(kMass * kGravity * kRadius * c / (s * ((kMass * kRadius + kAxial / kRadius) * rho + kAcross * c)));
  const double spin = -Omega * rho / kRadius - Omega * c;  // about the axle, against the leaning frame
  for (auto& [name, method] : every_method(2e-4)) {
    SCOPED_TRACE(name);
    RollingDisc* rolling;
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      const Matrix3 axes = rotation_about({0, 1, 0}, theta);  // axle cos θ n + sin θ e_r, e_r = x
      const Vector3 axle = axes.col(2), turn = Omega * Vector3(0, 0, 1) + spin * axle;
      auto& coin =
          graph.add<RigidBody>("coin", disc_body({rho, 0, kRadius * s}, axes, Omega * rho * Vector3(0, 1, 0), turn));
      rolling = &graph.add<RollingDisc>("rolling", {graph.ground().marker(), coin.marker()}, {.radius = kRadius});
    });
    EXPECT_LT(scene.violation(Level::velocity), 1e-12);  // drawn consistent: nothing was projected
    const double turn_time = 2 * kPi / Omega;
    for (double part : {0.4, 1.0}) {
      scene.run(*method, part * turn_time);
      const double phi = 2 * kPi * part;
      const Vector3 e_r(std::cos(phi), std::sin(phi), 0);
      EXPECT_LT((scene.position(0) - (rho * e_r + Vector3(0, 0, kRadius * s))).norm(), 1e-5) << part;
      const Vector3 axle = rotation_matrix(scene.state.q.segment<4>(3)).col(2);
      EXPECT_LT((axle - (s * e_r + Vector3(0, 0, c))).norm(), 1e-5) << part;
      const Vector3 F = read_vector(scene, reaction(*rolling, 1));
      EXPECT_LT((F - (kMass * kGravity * Vector3(0, 0, 1) - kMass * Omega * Omega * rho * e_r)).norm(), 1e-3) << part;
    }
  }
}

/// A wobbling coin: energy is kept, it touches and does not slip, though friction pushes all the time.
TEST(RollingDisc, KeepsItsEnergyHoweverItWobbles) {
  for (auto& [name, method] : every_method(2e-4)) {
    SCOPED_TRACE(name);
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      const Matrix3 axes = rotation_exp(Vector3(1.2, 0.3, -0.2));
      const Vector3 axle = axes.col(2);
      const Vector3 u = (Vector3(0, 0, 1) - axle[2] * axle).normalized(), turn = 6 * axle + Vector3(0.3, 0.2, 1.5);
      auto& coin = graph.add<RigidBody>("coin", disc_body({0, 0, kRadius * u[2]}, axes, turn.cross(kRadius * u), turn));
      graph.add<RollingDisc>("rolling", {graph.ground().marker(), coin.marker()}, {.radius = kRadius});
    });
    const double start = scene.energy();
    scene.run(*method, 2);
    EXPECT_NEAR(scene.energy(), start, 1e-5 * start);
    EXPECT_LT(scene.violation(Level::position), 1e-9);
    EXPECT_GT((scene.position(0) - Vector3(0, 0, scene.position(0)[2])).norm(), 0.5);
  }
}

/// On a turntable a disc is carried along: the contact's speed is that of the table, not of the ground.
TEST(RollingDisc, DoesNotSlipOnAPlaneThatMoves) {
  RigidBody* wheel;
  Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
    const Shaft table = draw_shaft(graph, "table", 10);
    graph.add<CoordinateDrive>("drive", {table.angle()}, {.motion = ramp(0, 2)});
    wheel = &graph.add<RigidBody>(
        "wheel", disc_body({0.5, 0, kRadius}, rotation_about({1, 0, 0}, -kPi / 2), Vector3(0.3, 1, 0), {0, 1, 2}));
    graph.add<RollingDisc>("rolling", {table.body->marker(), wheel->marker()}, {.radius = kRadius});
  });
  const Method method = index2(1e-3);
  scene.run(*method, 0.4);
  Snapshot now{scene.system, scene.state};
  const MarkerKinematics k = now.marker(Marker{wheel, 0});
  const Vector3 axle = k.R.col(2), u = (Vector3(0, 0, 1) - axle[2] * axle).normalized(), contact = k.p - kRadius * u;
  EXPECT_LT((k.v + k.w.cross(-kRadius * u) - 2 * Vector3(0, 0, 1).cross(contact)).norm(), 1e-8);
}

}  // namespace
}  // namespace lithe::test::rolling_test
