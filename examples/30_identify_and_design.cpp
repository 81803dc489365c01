// 30_identify_and_design: what does a result owe to each parameter? Which parameters did a measured machine have, and
// which should it get?
//
// Shows: gradient() of a run by any number that its drawing is made of; fit() of parameters to a noisy table, with
//        their confidence; minimize() under limits.
// Expect: derivatives that agree with differences of runs to 1e-7; stiffness and damping of the table within their
//         intervals; the softest spring that keeps the arm within its limit, met to 1e-6.
#include <cmath>
#include <cstdio>
#include <random>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. A scene as a function of its parameters: an arm on a hinge with a spring and a damper, a rod hinged to its end.
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);  // hinges turn about the z axes of their markers
  ParametricScene scene{.name = "arm", .duration = 1};
  scene.draw = [&](SystemGraph& graph, const SweepPoint& p) {
    auto& arm = graph.add<RigidBody>("arm", {.mass = 1, .inertia = {0.03, 0.03, 0.03}, .position = {0.3, 0, 0}});
    auto& rod =
        graph.add<RigidBody>("rod", {.mass = p["mass"], .inertia = {0.02, 0.02, 0.02}, .position = {0.8, 0, 0}});
    auto& pin =
        graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, along_y), arm.marker({-0.3, 0, 0}, along_y)});
    graph.add<RevoluteJoint>("knee", {arm.marker({0.3, 0, 0}, along_y), rod.marker({-0.2, 0, 0}, along_y)});
    graph.add<CoordinateSpring>("spring", {pin.angle()},
                                {.stiffness = p["stiffness"], .damping = p["damping"], .free_value = 0.0});
    const double stiffness = p["stiffness"];
    return std::vector<Sensor>{coordinate(pin.angle(), "angle"), position(rod.marker({0.2, 0, 0}), "tip"),
                               joint_reaction(pin, "pin"),
                               Sensor{"cost", {"cost"}, [=](Snapshot&, std::span<double> out) { out[0] = stiffness; }}};
  };
  scene.integrator = [] { return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = 5e-3}); };

  // 2. Derivatives of the very steps of that run, beside a difference of two runs.
  const std::vector<DesignParameter> drawn{{"mass", 0.8}, {"stiffness", 60}, {"damping", 1.5}};
  const std::vector<Quantity> quantities{value_at("tip_z", 1), largest("pin_force_y"), integral("angle"),
                                         at_rest("angle"), frequency(0)};
  const Gradient slopes = gradient(scene, quantities, drawn);
  for (Eigen::Index i = 0; i < slopes.values.size(); ++i)
    std::printf("%-20s %9.5f   by mass %9.5f, stiffness %9.6f, damping %9.6f\n",
                slopes.quantities[static_cast<std::size_t>(i)].c_str(), slopes.values[i], slopes.derivatives(i, 0),
                slopes.derivatives(i, 1), slopes.derivatives(i, 2));
  auto up = drawn, down = drawn;
  up[1].value *= 1 + 1e-4, down[1].value *= 1 - 1e-4;
  const double difference =
      (gradient(scene, {quantities[0]}, up).values[0] - gradient(scene, {quantities[0]}, down).values[0]) /
      (2e-4 * drawn[1].value);
  const double off = std::abs(slopes("tip_z at 1 s", "stiffness") / difference - 1);
  std::printf("tip by stiffness: off a difference of runs by %.1e of it\n", off);

  // 3. A table as one would measure it: angles with 2 mrad of noise. Which stiffness and damping had the machine?
  std::vector<Quantity> samples;
  for (int i = 1; i <= 50; ++i) samples.push_back(value_at("angle", 0.02 * i));
  const VectorX exact = gradient(scene, samples, drawn).values;
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 2e-3);
  Table measured{.columns = {"t", "angle"}};
  for (int i = 0; i < 50; ++i) measured.add_row({0.02 * (i + 1), exact[i] + noise(random)});
  const Fit found = fit(scene, measured, {{"stiffness", 40, 1, 500}, {"damping", 0.5, 0, 20}, {"mass", 1, 0.1, 5}},
                        {.confidence = 0.99});
  std::printf("\n%snoise of the table: %.2f mrad, %d runs\n", found.text().c_str(), 1e3 * found.deviation,
              found.evaluations);
  bool inside = found.converged;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double truth = drawn[k == 0 ? 1 : k == 1 ? 2 : 0].value;
    inside = inside && found.lower[k] <= truth && truth <= found.upper[k];
  }

  // 4. The softest spring with which the arm never sinks by more than 0.15 rad.
  const Optimum best = minimize(scene, value_at("cost", 1),
                                {{"stiffness", 60, 10, 500}, {"damping", 1.5, 1, 5}, {"mass", 0.8, 0.79, 0.81}},
                                {{.quantity = largest("angle"), .upper = 0.15}});
  std::printf("\nstiffness %.3f N m/rad, damping %.3f N m s/rad: sinks by %.6f rad; %d runs; %s\n", best("stiffness"),
              best("damping"), best.limited[0], best.evaluations, best.message.c_str());
  return off < 1e-7 && inside && best.converged && std::abs(best.limited[0] - 0.15) < 1e-6 ? 0 : 1;
}
