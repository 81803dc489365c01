// Fast bodies and thin ones: points are found in the middle of a step, which may be on the other side of a plate.
#include <gtest/gtest.h>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/surface_mesh.h"
#include "engine/observe/sensors.h"
#include "tests/reference/contact_scene.h"

namespace lithe::test::contact_swept_test {
namespace {

constexpr double kRadius = 0.02, kSpeed = 50, kEnd = 0.04;  // m, m/s, s

/// Off a fixed surface with e = 0.5: where and how fast the ball is at the end, exactly, whenever it started.
void expect_bounce(Stepper stepper, double step, double start, double top, const Shape& surface) {
  SCOPED_TRACE("step " + std::to_string(step) + ", start " + std::to_string(start));
  ContactScene scene{{0, 0, 0}};
  auto& ball = scene.sphere("ball", kRadius, 0.1, {0.003, 0.001, start}, {0, 0, -kSpeed});
  scene.contact({{scene.graph.ground().marker(), surface}, {ball.marker(), shape::sphere(kRadius)}}, 0, 0.5);
  scene.start(stepper, step);
  scene.run(kEnd);
  const double met = (start - kRadius - top) / kSpeed;
  EXPECT_NEAR(scene.state().v[2], kSpeed / 2, 1e-9);
  EXPECT_NEAR(scene.state().q[2], top + kRadius + kSpeed / 2 * (kEnd - met), 1e-9);
}

class Swept : public ::testing::TestWithParam<Stepper> {};

TEST_P(Swept, a_ball_at_50_m_per_s_bounces_off_plates_of_2_and_5_mm_at_steps_of_1_to_20_ms) {
  for (const double thick : {0.002, 0.005})
    for (const double step : {1e-3, 5e-3, 2e-2})
      for (double start = 0.0235; start < 0.6; start *= 1.17)
        expect_bounce(GetParam(), step, start, thick / 2, shape::box({0.2, 0.2, thick}));
}

TEST_P(Swept, it_does_not_pass_through_terrain_that_has_one_side) {
  const std::vector<Vector3> corners{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  for (double start = 0.0215; start < 0.6; start *= 1.31) {
    expect_bounce(GetParam(), 5e-3, start, 0, shape::mesh(corners, {{0, 1, 2}, {0, 2, 3}}));
    expect_bounce(GetParam(), 5e-3, start, 0, shape::height_field(MatrixX::Zero(5, 5), 0.3, 0.3));
  }
}

TEST_P(Swept, it_throws_a_free_plate_as_the_conservation_laws_say) {
  const double m = 0.1, M = 0.3;
  for (double start = 0.0235; start < 0.3; start *= 1.4) {
    ContactScene scene{{0, 0, 0}};
    auto& plate = scene.box("plate", {0.2, 0.2, 0.002}, M, {0, 0, 0});
    auto& ball = scene.sphere("ball", kRadius, m, {0, 0, start}, {0, 0, -kSpeed});
    scene.contact({{plate.marker(), shape::box({0.2, 0.2, 0.002})}, {ball.marker(), shape::sphere(kRadius)}}, 0, 1);
    scene.start(GetParam(), 5e-3);
    scene.run(0.03);
    EXPECT_NEAR(scene.state().v[2], -2 * m / (m + M) * kSpeed, 1e-9);    // plate
    EXPECT_NEAR(scene.state().v[8], -(m - M) / (m + M) * kSpeed, 1e-9);  // ball
    EXPECT_GT(scene.state().q[9], scene.state().q[2]) << "the ball is still above the plate";
  }
}

TEST_P(Swept, a_flexible_rod_of_10_mm_is_not_passed_either) {
  const FiniteElementModel model =
      brick_mesh({.size = {0.4, 0.01, 0.01}, .divisions = {8, 1, 1}, .type = "C3D8I", .material = {2e11, 0.3, 7850}});
  for (double start = 0.027; start < 0.3; start *= 1.5) {
    ContactScene scene{{0, 0, 0}};
    auto& rod = scene.graph.add<FlexibleBody>("rod", {.basis = make_basis(model, MeanAxisFrame{}, 6)});
    const SurfaceMesh skin = surface(rod);
    auto& ball = scene.sphere("ball", kRadius, 0.1, {0.17, 0.005, 0.01 + start}, {0, 0, -kSpeed});
    scene.contact({{skin.frame, shape::surface(skin.nodes, skin.points, skin.triangles, skin.reach)},
                   {ball.marker(), shape::sphere(kRadius)}},
                  0, 0);
    scene.start(GetParam(), 2e-3);
    const double before = scene.read(total_energy());
    scene.run(0.012);
    EXPECT_LE(scene.read(total_energy()), before * (1 + 1e-9));
    EXPECT_GT(scene.read(position(ball.marker()), 2), scene.read(position(skin.frame), 2)) << start;
    EXPECT_GT(scene.read(velocity(ball.marker()), 2), -0.9 * kSpeed) << "the rod has been hit";
  }
}

INSTANTIATE_TEST_SUITE_P(, Swept, ::testing::Values(Stepper::moreau_jean, Stepper::generalized_alpha),
                         [](const auto& of) {
                           return of.param == Stepper::moreau_jean ? "MoreauJean" : "NonsmoothGeneralizedAlpha";
                         });

}  // namespace
}  // namespace lithe::test::contact_swept_test
