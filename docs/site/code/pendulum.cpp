// pendulum: the scene that docs/site/coming_from.md shows beside those of others.
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. A slender rod of 1 m and 1 kg on a hinge about the world's y axis, let go level.
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  auto& rod = graph.add<RigidBody>("rod", {.mass = 1, .inertia = {1e-4, 1.0 / 12, 1.0 / 12}, .position = {0.5, 0, 0}});
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, along_y), rod.marker({-0.5, 0, 0}, along_y)});
  const Marker tip = rod.marker({0.5, 0, 0});

  const System system = assemble(graph);
  State state = system.initial_state();
  Recorder recorder{{position(tip, "tip")}};
  GeneralizedAlpha integrator{{.step = 2e-4, .spectral_radius = 0.9}};
  Simulation simulation{system, integrator};
  simulation.observe(recorder, every(2e-3));
  simulation.run(state, 4);
  recorder.write_csv("results/tip.csv");

  // 2. Check the answer: the tip is as fast as its height says, v² = 3 g h.
  const double v = 2 * state.v.head<3>().norm(), height = -2 * state.q[2];
  std::printf("tip %.6f m below the pin, %.6f m/s fast\n", height, v);
  return std::abs(v * v - 3 * 9.81 * height) < 1e-3 ? 0 : 1;
}
