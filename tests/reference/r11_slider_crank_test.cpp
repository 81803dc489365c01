// R11: planar slider-crank through its dead centres; mark 1e-6 rad of the crank at 5 s.
#include <gtest/gtest.h>

#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/reference/accuracy.h"
#include "tests/reference/mechanism.h"

namespace lithe::test::r11_slider_crank_test {
namespace {

struct Variant {
  std::string name;
  double crank, rod, crank_mass, rod_mass, slider_mass, angle, speed;
};
const Variant kA{"A", 0.15, 0.30, 0.36, 0.151104, 0.075552, 0, 15};
const Variant kB{"B", 1, 1, 1, 1, 1, M_PI / 4, 5};

/// Bodies: crank, rod, slider; the slider on the x axis.
Scene slider_crank(const Variant& of) {
  return Scene({0, -9.81, 0}, [&](SystemGraph& graph) {
    const double sine = of.crank * std::sin(of.angle), cosine = of.crank * std::cos(of.angle);
    // Equal links: the branch on which the slider goes through the crank's axis.
    const bool equal = of.rod == of.crank;
    const double along = equal ? cosine : std::sqrt(of.rod * of.rod - sine * sine), x = cosine + along;
    const double speed = -of.speed * sine * (equal ? 2 : 1 + cosine / along);
    const Vector3 pin(cosine, sine, 0), end(x, 0, 0), v_pin = of.speed * Vector3(-sine, cosine, 0), v_end(speed, 0, 0);
    const Part crank = rod(graph, "crank", {0, 0, 0}, pin, of.crank_mass, 0, {0, 0, 0}, v_pin);
    const Part link = rod(graph, "rod", pin, end, of.rod_mass, 0, v_pin, v_end);
    const Part slider(graph, "slider", of.slider_mass, {1, 1, 1}, end, Matrix3::Identity(), v_end);
    const Matrix3 along_x = axes_with_z({1, 0, 0}, {0, 1, 0});
    graph.add<RevoluteJoint>("main bearing", {graph.ground().marker(), crank.at({0, 0, 0})});
    graph.add<RevoluteJoint>("crank pin", {crank.at(pin), link.at(pin)});
    graph.add<RevoluteJoint>("wrist pin", {link.at(end), slider.at(end)});
    graph.add<PrismaticJoint>("guide", {graph.ground().marker({0, 0, 0}, along_x), slider.at(end, along_x)});
  });
}

double check(const Variant& variant, Method method, double angle, double energy) {
  const Table table = reference("R11_slider_crank_dead_centre/reference_" + variant.name + ".csv");
  Scene scene = slider_crank(variant);
  EXPECT_EQ(scene.system.degrees_of_freedom(), 1);
  EXPECT_EQ(scene.system.redundant_rows().size(), 3u);
  const double start = scene.energy();
  double theta = 0, rate = 0, slider = 0, e = 0, branch = 0;
  follow(scene, *method, table, 5, [&](std::span<const double> row) {
    const Vector3 pin = 2 * scene.position(0);
    const double off = pin.normalized().cross(Vector3(std::cos(row[0]), std::sin(row[0]), 0)).norm();
    theta = std::max(theta, off);
    rate = std::max(rate, std::abs(scene.state.v[5] - row[1]));
    slider = std::max(slider, std::abs(scene.position(2).x() - row[2]));
    branch = std::max(branch, std::abs(2 * (scene.position(1) - pin).y() + pin.y()));
    e = std::max(e, std::abs(scene.energy() - start));
  });
  const std::string name = "R11 " + variant.name + ", " + method->name();
  expect_below(name + ", crank angle over 5 s (rad; mark 1e-6)", theta, angle);
  expect_below(name + ", crank speed (rad/s)", rate, 100 * angle);
  expect_below(name + ", slider (m)", slider, 3 * angle);
  expect_below(name + ", rod end off the axis (m)", branch, 1e-10);
  expect_below(name + ", energy (J)", e, energy);
  return theta;
}

TEST(R11SliderCrank, PassesItsDeadCentres) {
  check(kA, runge_kutta(1e-10), 1e-7, 2e-9);
  check(kA, index2(2e-4), 2e-3, 1e-5);
  check(kA, ida(1e-9), 1e-4, 1e-6);
}

TEST(R11SliderCrank, WithEqualLinksPassesTheCrankAxisOnItsBranch) {
  check(kB, runge_kutta(1e-10), 1e-7, 2e-7);
  check(kB, index2(2e-4), 1e-4, 2e-3);
}

TEST(R11SliderCrank, StartsInItsSingularPositionWithThreeRedundantRowsAllTheSame) {
  // At 90 degrees a fourth row depends on the others, there alone: left out for good, the slider would lose its guide.
  Variant upright = kB;
  upright.angle = M_PI / 2;
  Scene scene = slider_crank(upright);
  EXPECT_EQ(scene.system.redundant_rows().size(), 3u);
  EXPECT_EQ(scene.system.degrees_of_freedom(), 1);
  // One coordinate: I(θ) θ̇²/2 + V(θ) = E, I of crank, rod (centre at 1.5 cos, 0.5 sin), slider (2 cos).
  const auto rate = [](double th) {
    const double s = std::sin(th), c = std::cos(th);
    const double I = 1.0 / 3 + 1.0 / 12 + 2.25 * s * s + 0.25 * c * c + 4 * s * s;
    const double energy = 0.5 * (1.0 / 3 + 1.0 / 12 + 6.25) * 25 + 9.81;
    return std::sqrt(2 * (energy - 9.81 * s) / I);
  };
  const double start = scene.energy();
  double th = M_PI / 2, angle = 0, branch = 0, e = 0, g = 0;
  Method method = runge_kutta(1e-9);
  for (int i = 1; i <= 100; ++i) {
    for (int k = 0; k < 50; ++k) {  // classical Runge-Kutta, 0.4 ms
      constexpr double h = 4e-4;
      const double k1 = rate(th), k2 = rate(th + h / 2 * k1), k3 = rate(th + h / 2 * k2), k4 = rate(th + h * k3);
      th += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    ASSERT_NO_FATAL_FAILURE(scene.run(*method, 0.02 * i));
    angle = std::max(angle, (2 * scene.position(0) - Vector3(std::cos(th), std::sin(th), 0)).norm());
    branch = std::max(branch, std::abs(scene.position(2).x() - 2 * std::cos(th)));
    e = std::max(e, std::abs(scene.energy() - start));
    g = std::max(g, scene.violation(Level::position));
  }
  expect_below("R11 B from its singular position, crank angle over 2 s (rad)", angle, 1e-6);
  expect_below("R11 B from its singular position, slider (m)", branch, 3e-6);
  expect_below("R11 B from its singular position, energy (J)", e, 1e-5);
  expect_below("R11 B from its singular position, |g|", g, 1e-10);
}

TEST(R11SliderCrank, MeetsItsMarkByDefault) {
  for (const Variant& variant : {kA, kB}) {
    check(variant, automatic(1e-8), 1e-6, kAny);
    expect_accuracy("R11 " + variant.name, "crank angle over 5 s", 1,
                    [&](Method m) { return check(variant, std::move(m), kAny, kAny); });
  }
}

}  // namespace
}  // namespace lithe::test::r11_slider_crank_test
