// 05_load_a_joint: the joint of 04, built alone as a plug-in, is loaded at run time and known by its name.
//
// Shows: a registry, load_plugin with an explicit path, a joint by name with parameters by name, and what a mistake
// says. Expect: the conical pendulum of 04 again. Run with another path: 05_load_a_joint path/to/massless_rod.so
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main(int count, char** arguments) {
  // 1. Load. Between the library and us stand plain C and doubles; plugins/README.md builds one in a page.
  Registry registry;
  registry.load_plugin(count > 1 ? arguments[1] : LITHE_PLUGIN_DIR "/massless_rod.so");

  // 2. Draw the cone of 04.
  const double length = 0.5, mass = 2, angle = M_PI / 6, g = 9.81;
  const double rate = std::sqrt(g / (length * std::cos(angle))), radius = length * std::sin(angle);
  SystemGraph graph{{.gravity = {0, 0, -g}}};
  auto& bob = graph.add<RigidBody>("bob", {.mass = mass,
                                           .inertia = {1e-3, 1e-3, 1e-3},
                                           .position = {radius, 0, -length * std::cos(angle)},
                                           .velocity = {0, rate * radius, 0}});

  // 3. A mistake is told in the scene's terms, and nothing is lost.
  const Marker top = graph.ground().marker();
  try {
    graph.add(registry.joint("massless_rod"), "rod", {top, bob.marker()}, {{"lenght", length}});
  } catch (const SceneError& error) {
    std::printf("%s\n", error.what());
  }

  // 4. The joint by name: one indirect call an element, rows as if compiled in, bit by bit.
  graph.add(registry.joint("massless_rod"), "rod", {top, bob.marker()}, {{"length", length}});

  // 5. Once round, and check the answer.
  const System system = assemble(graph);
  const State start = system.initial_state();
  State state = start;
  ExplicitRungeKutta integrator{{.tolerance = {.relative = 1e-9, .absolute = 1e-9}}};
  Simulation{system, integrator}.run(state, 2 * M_PI / rate);
  const double gap = (state.q - start.q).head<3>().norm(), tension = state.lambda[0] * length;
  std::printf("after one turn %.1e m from the start; tension %.6f N, exact %.6f N\n", gap, tension,
              mass * g / std::cos(angle));
  return gap < 1e-6 && std::abs(tension * std::cos(angle) / (mass * g) - 1) < 1e-6 ? 0 : 1;
}
