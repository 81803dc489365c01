#include <gtest/gtest.h>

#include "joints/coordinate_drive.h"
#include "joints/planar_joint.h"
#include "joints/point_on_line_joint.h"
#include "joints/point_on_plane_joint.h"
#include "tests/joints/mechanisms.h"

/// Guides of points and blocks: planes and wires.
namespace lithe::test::guide_test {
namespace {

constexpr double kGravity = 9.81, kSlope = 0.4;

/// Down a slope along x of the plane; the plane's normal carries m g cos α.
TEST(PlanarJoint, LetsABlockSlideDownASlopeAndSpinOnIt) {
  const Matrix3 plane = rotation_about({0, 1, 0}, kSlope);
  for (auto& [name, method] : every_method(1e-3)) {
    SCOPED_TRACE(name);
    PlanarJoint* table;
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      auto& block = graph.add<RigidBody>("block", {.mass = 2,
                                                   .inertia = {0.1, 0.1, 0.2},
                                                   .position = plane * Vector3(0.1, 0, 0.05),
                                                   .orientation = plane,
                                                   .velocity = plane * Vector3(0, 0.3, 0),
                                                   .angular_velocity = {0, 0, 9}});
      table = &graph.add<PlanarJoint>("table", {graph.ground().marker({}, plane), block.marker({0, 0, -0.05})});
    });
    scene.run(*method, 2);
    EXPECT_NEAR(read(scene, coordinate(table->displacement_x(), "x")), 0.1 + 0.5 * kGravity * std::sin(kSlope) * 4,
                1e-6);
    EXPECT_NEAR(read(scene, coordinate(table->displacement_y(), "y")), 0.6, 1e-6);
    EXPECT_NEAR(read(scene, coordinate(table->angle(), "phi")), 18, 1e-6);  // nearly three turns
    const Vector3 F = read_vector(scene, joint_reaction(*table));
    EXPECT_LT((F - Vector3(0, 0, 2 * kGravity * std::cos(kSlope))).norm(), 1e-5);
  }
}

/// On a wire that turns at Ω about the vertical a bead flies out, r = r₀ cosh Ω t; the wire pushes it by 2 m Ω ṙ.
TEST(PointOnLineJoint, LetsABeadFlyOutAlongATurningWire) {
  const double m = 0.3, speed = 3, r0 = 0.2, end = 1;
  for (auto& [name, method] : every_method(2e-4)) {
    SCOPED_TRACE(name);
    PointOnLineJoint* wire;
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      const Shaft post = draw_shaft(graph, "post", 1);
      graph.add<CoordinateDrive>("drive", {post.angle()}, {.motion = ramp(0, speed)});
      auto& bead = graph.add<RigidBody>("bead", {.mass = m, .position = {r0, 0, 0}, .velocity = {0, speed * r0, 0}});
      // z of the wire is x of the post, its x points down.
      wire = &graph.add<PointOnLineJoint>("wire",
                                          {post.body->marker({}, rotation_about({0, 1, 0}, kPi / 2)), bead.marker()});
    });
    scene.run(*method, end);
    const double r = r0 * std::cosh(speed * end), r_dot = r0 * speed * std::sinh(speed * end);
    EXPECT_NEAR(read(scene, coordinate(wire->displacement(), "r")), r, 2e-6 * r);
    EXPECT_NEAR(read(scene, coordinate_rate(wire->displacement(), "r")), r_dot, 2e-6 * r_dot);
    const Vector3 F = read_vector(scene, joint_reaction(*wire));
    EXPECT_LT((F - Vector3(-m * kGravity, 2 * m * speed * r_dot, 0)).norm(), 1e-4);
  }
}

/// The plane carries m g cos α and pushes the ball nowhere else; it turns as it likes.
TEST(PointOnPlaneJoint, CarriesABallOnASlopeAndLetsItGoElse) {
  const Matrix3 plane = rotation_about({0, 1, 0}, kSlope);
  for (auto& [name, method] : every_method(1e-3)) {
    SCOPED_TRACE(name);
    PointOnPlaneJoint* table;
    RigidBody* ball;
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      ball = &graph.add<RigidBody>("ball", {.mass = 2,
                                            .position = plane * Vector3(0.1, 0, 0),
                                            .velocity = plane * Vector3(0, 0.3, 0),
                                            .angular_velocity = {1, 2, 3}});
      table = &graph.add<PointOnPlaneJoint>("table", {graph.ground().marker({}, plane), ball->marker()});
    });
    scene.run(*method, 2);
    const Vector3 expected = plane * Vector3(0.1 + 0.5 * kGravity * std::sin(kSlope) * 4, 0.6, 0);
    EXPECT_LT((scene.position(0) - expected).norm(), 1e-6);
    EXPECT_LT((read_vector(scene, joint_reaction(*table)) - Vector3(0, 0, 2 * kGravity * std::cos(kSlope))).norm(),
              1e-5);
  }
}

}  // namespace
}  // namespace lithe::test::guide_test
