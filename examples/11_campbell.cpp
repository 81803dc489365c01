// 11_campbell: a rotor on elastic bearings is turned up; its whirl splits with speed.
//
// Shows: linearization about a spinning state, the Campbell diagram over speed.
// Expect: results/campbell/diagram.svg; tilting whirls follow s² ∓ Ω (J_p / J_d) s - k / J_d = 0, forward and backward.
#include <algorithm>
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. A disc on a bushing that holds its centre and its tilt, and lets it spin about z.
  const double mass = 2, polar = 0.02, diametral = 0.012, lateral = 8e4, tilting = 300;
  const auto scene = [&](double speed) {
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    auto& disc = graph.add<RigidBody>(
        "disc", {.mass = mass, .inertia = {diametral, diametral, polar}, .angular_velocity = {0, 0, speed}});
    // Springs along axes of the world, at four points of a cross on the spin axis: they do not feel the spin.
    const double arm = std::sqrt(tilting / lateral);
    for (double z : {-arm, arm})
      for (int axis = 0; axis < 2; ++axis)
        graph.add<CoordinateSpring>(
            (z < 0 ? "lower " : "upper ") + std::string(axis == 0 ? "x" : "y"),
            {displacement_between(graph.ground().marker({0, 0, z}), disc.marker({0, 0, z}), axis)},
            {.stiffness = lateral / 2});
    const System system = assemble(graph);
    return linearize(system, system.initial_state(), {.axes = PerturbationAxes::world});
  };

  // 2. From 1 to 400 rad/s.
  std::vector<double> speeds;
  for (double speed = 1; speed <= 400; speed += 10) speeds.push_back(speed);
  const Campbell diagram = campbell(speeds, scene);
  diagram.write_csv("results/campbell/diagram.csv");
  diagram.write_chart("results/campbell/diagram", "Rotor on elastic bearings");

  // 3. Check the answer: each branch, at each speed, is one of the closed form's.
  double worst = 0;
  for (const auto& branch : diagram.branches)
    for (std::size_t i = 0; i < branch.speed.size(); ++i) {
      const double g = branch.speed[i] * polar / diametral, root = std::sqrt(g * g / 4 + tilting / diametral);
      double nearest = std::abs(branch.frequency[i] - std::sqrt(lateral / mass) / (2 * M_PI));
      for (double s : {root + g / 2, root - g / 2})
        nearest = std::min(nearest, std::abs(branch.frequency[i] - s / (2 * M_PI)));
      worst = std::max(worst, nearest);
    }
  std::printf("%zu branches over %zu speeds, off the closed form by %.1e Hz\n", diagram.branches.size(), speeds.size(),
              worst);
  return diagram.branches.size() == 4 && worst < 1e-6 ? 0 : 1;
}
