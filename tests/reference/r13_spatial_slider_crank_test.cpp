// R13: spatial slider-crank (Haug): hinge, ball, cardan joint, slider; mark 1e-6 m over 5 s.
#include <gtest/gtest.h>

#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"
#include "tests/reference/accuracy.h"
#include "tests/reference/mechanism.h"

namespace lithe::test::r13_spatial_slider_crank_test {
namespace {

/// Bodies: crank, rod, slider.
Scene spatial_slider_crank() {
  return Scene({0, 0, -9.81}, [](SystemGraph& graph) {
    const Vector3 A(0, 0.1, 0.12), B(0, 0.1, 0.2), C(0.2, 0, 0), x = Vector3::UnitX();
    const Vector3 v_B = Vector3(6, 0, 0).cross(B - A), v_C(0.24, 0, 0);
    // The rod: x axis along it, y its arm of the cardan joint, across the slider's axis. Its end C stays in the slider
    // and its arm across the x axis: that fixes its spin, omega = d x d_dot / d² + spin d with arm_dot · x = 0.
    const Vector3 d = C - B, d_dot = v_C - v_B, arm = d.cross(x).normalized();
    Matrix3 R;
    R << d.normalized(), arm, d.normalized().cross(arm);
    const Vector3 across = d.cross(d_dot) / d.squaredNorm();
    const Vector3 omega = across - across.cross(arm).dot(x) / d.cross(arm).dot(x) * d;
    EXPECT_LT((omega - Vector3(1.92, -0.96, 0.48)).norm(), 1e-12);

    const Part crank(graph, "crank", 0.12, {1e-4, 1e-4, 1e-5}, (A + B) / 2, Matrix3::Identity(), v_B / 2, {6, 0, 0});
    const Part link(graph, "rod", 0.5, {4e-4, 4e-3, 4e-3}, (B + C) / 2, R, (v_B + v_C) / 2, omega);
    const Part slider(graph, "slider", 2, {1, 1, 1}, C, Matrix3::Identity(), v_C);
    const Matrix3 about_x = axes_with_z(x, {0, 1, 0});
    graph.add<RevoluteJoint>("bearing", {graph.ground().marker(A, about_x), crank.at(A, about_x)});
    graph.add<SphericalJoint>("ball", {crank.at(B), link.at(B)});
    graph.add<UniversalJoint>("cardan", {slider.at(C), link.at(C, R)});
    graph.add<PrismaticJoint>("guide", {graph.ground().marker({0, 0, 0}, about_x), slider.at(C, about_x)});
  });
}

double check(Method method, double position, double energy) {
  const Table table = reference("R13_spatial_slider_crank/reference.csv");
  Scene scene = spatial_slider_crank();
  EXPECT_EQ(scene.system.degrees_of_freedom(), 1);
  EXPECT_TRUE(scene.system.redundant_rows().empty());
  const double start = scene.energy();
  EXPECT_NEAR(start, 0.76643568, 1e-10);
  double x = 0, v = 0, b = 0, e = 0, g = 0;
  follow(scene, *method, table, 5, [&](std::span<const double> row) {
    x = std::max(x, std::abs(scene.position(2).x() - row[0]));
    v = std::max(v, std::abs(scene.state.v[12] - row[1]));
    const Vector3 B = 2 * scene.position(0) - Vector3(0, 0.1, 0.12);
    b = std::max(b, std::hypot(B.y() - row[2], B.z() - row[3]));
    e = std::max(e, std::abs(scene.energy() - start));
    g = std::max(g, scene.violation(Level::position));
  });
  const std::string name = "R13, " + method->name();
  expect_below(name + ", slider (m; mark 1e-6)", x, position);
  expect_below(name + ", slider's speed (m/s)", v, 50 * position);
  expect_below(name + ", crank pin (m)", b, 5 * position);
  expect_below(name + ", energy (J)", e, energy);
  expect_below(name + ", |g|", g, 1e-10);
  return x;
}

TEST(R13SpatialSliderCrank, MeetsTheTableWithinTheMark) {
  check(runge_kutta(1e-9), 2e-8, 1e-8);
  check(ida(3e-10), 1e-6, 1e-6);
  check(index2(1e-4), 1e-5, 1e-5);
}

TEST(R13SpatialSliderCrank, MeetsItsMarkByDefault) {
  check(automatic(1e-6), 1e-6, kAny);
  expect_accuracy("R13", "slider over 5 s", 0.2, [](Method m) { return check(std::move(m), kAny, kAny); });
}

}  // namespace
}  // namespace lithe::test::r13_spatial_slider_crank_test
