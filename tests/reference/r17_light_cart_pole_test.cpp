// R17: pole of 1 kg on a cart of 1e-6 kg: at each lower vertical the cart turns the pole's end within a microsecond, at
// up to 4429 rad/s. Mark 1e-6 rad at all outputs over 10 s.
#include <gtest/gtest.h>

#include "joints/distance_joint.h"
#include "joints/prismatic_joint.h"
#include "tests/reference/accuracy.h"
#include "tests/reference/mechanism.h"

namespace lithe::test::r17_light_cart_pole_test {
namespace {

/// Bodies: cart, tip.
Scene cart_pole() {
  return Scene({0, -9.81, 0}, [](SystemGraph& graph) {
    const Part cart(graph, "cart", 1e-6, Vector3::Constant(1e-6), {0, 0, 0});
    const Part tip(graph, "tip", 1, {1, 1, 1}, {1, 0, 0});
    const Matrix3 along_x = axes_with_z({1, 0, 0}, {0, 1, 0});
    graph.add<PrismaticJoint>("rail", {graph.ground().marker({0, 0, 0}, along_x), cart.at({0, 0, 0}, along_x)});
    graph.add<DistanceJoint>("pole", {cart.at({0, 0, 0}), tip.at({1, 0, 0})}, {.length = 1});
  });
}

double check(Method method, double angle, double energy) {
  const Table table = reference("R17_light_cart_pole/reference.csv");
  Scene scene = cart_pole();
  const double start = scene.energy();
  double theta = 0, x = 0, e = 0;
  follow(scene, *method, table, 10, [&](std::span<const double> row) {
    const Vector3 d = scene.position(1) - scene.position(0);
    theta = std::max(theta, std::abs(std::remainder(std::atan2(d.x(), -d.y()) - row[1], 2 * M_PI)));
    x = std::max(x, std::abs(scene.position(0).x() - row[0]));
    e = std::max(e, std::abs(scene.energy() - start));
  });
  const std::string name = "R17, " + method->name() + " " + std::to_string(method->statistics().steps) + " steps";
  expect_below(name + ", angle (rad; mark 1e-6)", theta, angle);
  expect_below(name + ", cart (m)", x, angle);
  expect_below(name + ", energy (J)", e, energy);
  return theta;
}

TEST(R17LightCartPole, KeepsItsAngleThroughElevenFlicksOfAMicrosecond) {
  check(runge_kutta(1e-10), 1e-6, 1e-6);
  check(runge_kutta(1e-12), 1e-8, 2e-9);
}

TEST(R17LightCartPole, MeetsItsMarkByDefault) {
  check(automatic(1e-9), 1e-6, kAny);
  expect_accuracy(
      "R17", "angle over 10 s", 1, [](Method m) { return check(std::move(m), kAny, kAny); }, 300);
}

}  // namespace
}  // namespace lithe::test::r17_light_cart_pole_test
