// An outside project: the installed package, one include, one pendulum.
#include <cmath>
#include <cstdio>
#include <memory>

#include "lithe/lithe.h"
#include "plugins/inertial_body/inertial_body.h"

int main() {
  using namespace lithe;
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  auto& bob = graph.add<RigidBody>("bob", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = {1, 0, 0}});
  graph.add<DistanceJoint>("rod", {graph.ground().marker(), bob.marker()}, {.length = 1});
  const System system = assemble(graph);
  State state = system.initial_state();
  Recorder recorder{{position(bob.marker(), "bob"), total_energy("energy")}};
  GeneralizedAlpha integrator{{.step = 1e-3, .spectral_radius = 0.9}};
  Simulation simulation{system, integrator};
  simulation.observe(recorder, every(0.1));
  simulation.run(state, 1.0);
  const double length =
      recorder.table().at(10, 1) * recorder.table().at(10, 1) + recorder.table().at(10, 3) * recorder.table().at(10, 3);
  std::printf("length² %.12f after %d rows\n", length, recorder.table().row_count());

  // A mesh of one's own, written as a deck and read back; a part found by its name.
  const FiniteElementModel bricks =
      brick_mesh({.size = {1, 0.1, 0.1}, .divisions = {4, 1, 1}, .type = "C3D8I", .material = {2e11, 0.3, 7800}});
  write_calculix_deck("bricks.inp", bricks);
  const double mass = check(read_calculix_mesh("bricks.inp")).mass;
  // The plug-in's body, compiled in: the same deck, and a mesh of its own.
  const auto block = std::make_shared<const BrickMesh>(brick_block({1, 0.1, 0.1}, {4, 1, 1}, {2e11, 0.3, 7800}));
  SystemGraph solids;
  const double masses[] = {solids.add<InertialBody>("of the deck", {.mesh_file = "bricks.inp"}).mass(),
                           solids.add<InertialBody>("of a mesh", {.mesh = block}).mass()};
  std::printf("%d nodes, %.9f kg, %.9f kg, %.9f kg\n", bricks.node_count(), mass, masses[0], masses[1]);
  const bool kept = std::abs(mass - 78) < 1e-9 && std::abs(masses[0] - 78) < 1e-9 && std::abs(masses[1] - 78) < 1e-9 &&
                    graph.find<RigidBody>("bob") == &bob;

  // Two equal numbers before two zeros, by value: what GCC 12.2 spoils unless the package's flags forbid it.
  Automatic automatic{{.tolerance = {.relative = 1e-8, .absolute = 1e-8}}};
  Simulation again{system, automatic};
  State start = system.initial_state();
  again.run(start, 1e-4);
  std::printf("%ld steps\n", automatic.statistics().steps);
  return std::abs(length - 1) < 1e-9 && automatic.statistics().steps < 1000 && kept ? 0 : 1;
}
