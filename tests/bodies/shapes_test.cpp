#include "bodies/shapes.h"

#include <gtest/gtest.h>

#include "engine/base/error.h"

namespace lithe::test::shapes_test {
namespace {

TEST(Shapes, a_box_has_the_moments_of_a_box) {
  const MassProperties m = box({1, 2, 3}, 10);
  EXPECT_NEAR(m.mass, 60, 1e-12);
  EXPECT_LT((m.inertia.matrix.diagonal() - 5 * Vector3(13, 10, 5)).norm(), 1e-12);
}

TEST(Shapes, a_sphere_and_a_cylinder_have_theirs) {
  const MassProperties ball = sphere(0.5, 3), rod = cylinder(0.2, 3, 7);
  EXPECT_NEAR(ball.inertia.matrix(1, 1), 0.4 * ball.mass * 0.25, 1e-14);
  EXPECT_NEAR(rod.mass, 7 * M_PI * 0.04 * 3, 1e-13);
  EXPECT_NEAR(rod.inertia.matrix(2, 2), 0.5 * rod.mass * 0.04, 1e-13);
  EXPECT_NEAR(rod.inertia.matrix(0, 0), rod.mass * (0.04 / 4 + 9.0 / 12), 1e-12);
}

TEST(Shapes, a_capsule_without_length_is_nearly_a_ball) {
  const MassProperties m = capsule(0.5, 1e-12, 3), ball = sphere(0.5, 3);
  EXPECT_NEAR(m.mass, ball.mass, 1e-10);
  EXPECT_LT((m.inertia.matrix - ball.inertia.matrix).norm(), 1e-10);
}

TEST(Shapes, the_hull_of_a_displaced_box_is_that_box) {
  std::vector<Vector3> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(1 + (i & 1), 2 + (i & 2), 3 + 0.75 * (i & 4));
  const MassProperties hull = convex_hull(corners, 10), solid = box({1, 2, 3}, 10);
  EXPECT_NEAR(hull.mass, solid.mass, 1e-10);
  EXPECT_LT((hull.center - Vector3(1.5, 3, 4.5)).norm(), 1e-12);
  EXPECT_LT((hull.inertia.matrix - solid.inertia.matrix).norm(), 1e-9);
}

TEST(Shapes, refuse_what_has_no_volume) {
  EXPECT_THROW(box({1, 0, 1}, 10), SceneError);
  EXPECT_THROW(sphere(0.5, -1), SceneError);
  EXPECT_THROW(convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, 10), SceneError);
}

}  // namespace
}  // namespace lithe::test::shapes_test
