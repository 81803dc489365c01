// 09_equilibrium_and_modes: a chain of two balls finds where it hangs; then its small motions are told.
//
// Shows: static equilibrium, linearization about it, eigenfrequencies and mode shapes of the whole mechanism.
// Expect: ω² = (2 ± √2) g / l, each twice (it swings in two planes); the equilibrium stays at rest when simulated.
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. Two balls on massless rods, drawn aside.
  const double g = 9.81, l = 0.5;
  SystemGraph graph{{.gravity = {0, 0, -g}}};
  auto& upper = graph.add<RigidBody>("upper", {.mass = 1, .inertia = {1e-3, 1e-3, 1e-3}, .position = {0.3, 0, -0.4}});
  auto& lower = graph.add<RigidBody>("lower", {.mass = 1, .inertia = {1e-3, 1e-3, 1e-3}, .position = {0.6, 0.4, -0.4}});
  graph.add<DistanceJoint>("rod 1", {graph.ground().marker(), upper.marker()}, {.length = l});
  graph.add<DistanceJoint>("rod 2", {upper.marker(), lower.marker()}, {.length = l});
  const System system = assemble(graph);
  std::printf("%s\n", describe(system).c_str());

  // 2. Where it hangs, and how it moves about that place.
  const Equilibrium hanging = find_equilibrium(system, system.initial_state());
  const Linearization small = linearize(system, hanging.state);
  std::printf("hangs after %d Newton iterations; mode, frequency (Hz):\n", hanging.iterations);
  std::vector<double> swings;
  for (const Mode& mode : small.modes)
    if (mode.frequency() > 0.01) {  // the balls also turn freely about themselves
      swings.push_back(mode.frequency());
      std::printf("  %.9f\n", mode.frequency());
    }

  // 3. Simulated from there, it stays.
  State state = hanging.state;
  GeneralizedAlpha integrator{{.step = 1e-2}};
  Simulation{system, integrator}.run(state, 2.0);
  const double moved = (state.q - hanging.state.q).cwiseAbs().maxCoeff();

  // 4. Check the answer.
  const double slow = std::sqrt((2 - std::sqrt(2.0)) * g / l) / (2 * M_PI);
  const double fast = std::sqrt((2 + std::sqrt(2.0)) * g / l) / (2 * M_PI);
  double error = swings.size() == 4 ? 0 : 1;
  for (std::size_t i = 0; i < swings.size() && i < 4; ++i)
    error = std::max(error, std::abs(swings[i] - (i < 2 ? slow : fast)));
  std::printf("exact %.9f and %.9f Hz: off by %.1e; moved in 2 s by %.1e m\n", slow, fast, error, moved);
  return error < 1e-7 && moved < 1e-9 ? 0 : 1;
}
