// own_joint: a pin slides in a circular slot; a bob on the pin swings as a pendulum whose rod nobody sees.
#include <cmath>
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

/// A pin B in a circular slot of radius r: in the xy plane of marker A, about its origin.
///   g = (z_A · d, ½ (d·d − r²)),   d = p_B − p_A
class CircularSlot final : public Joint</*markers=*/2, /*rows=*/2> {
 public:
  struct Parameters {
    double radius = 1;  // r, m
  };
  /// Throws SceneError for a radius that is not above zero.
  explicit CircularSlot(Parameters parameters) : radius_(parameters.radius) { require::positive(radius_, "radius"); }

  void evaluate(double /*time*/, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    in_plane(A, A.z(), B, rows);
    at_distance(A, B, radius_, rows);
  }

 private:
  const double radius_;
};

int main() {
  // 1. A slot of 0.5 m in the world's xz plane: the marker's z axis is the world's y axis. The bob starts level with
  // the
  //    middle.
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  auto& bob = graph.add<RigidBody>("bob", {.mass = 2, .inertia = {1e-3, 1e-3, 1e-3}, .position = {0.5, 0, 0}});
  const Marker middle = graph.ground().marker({0, 0, 0}, rotation_about({1, 0, 0}, -M_PI / 2));
  graph.add<CircularSlot>("slot", {middle, bob.marker()}, {.radius = 0.5});

  // 2. Let it go until it passes the lowest point.
  const System system = assemble(graph);
  State state = system.initial_state();
  ExplicitRungeKutta integrator{{.tolerance = {.relative = 1e-10, .absolute = 1e-10}}};
  Simulation simulation{system, integrator};
  simulation.on({.name = "lowest", .function = watch(position(bob.marker())), .action = Event::Action::stop});
  simulation.run(state, 5);

  // 3. Check the answer: all height has become speed, and half a level swing takes K(sin 45°) sqrt(r / g).
  const double speed = state.v.head<3>().norm(), exact = std::sqrt(2 * 9.81 * 0.5);
  const double time = std::comp_ellint_1(std::sqrt(0.5)) * std::sqrt(0.5 / 9.81);
  std::printf("lowest after %.9f s (exact %.9f) at %.9f m/s (exact %.9f)\n", state.time, time, speed, exact);
  return std::abs(speed / exact - 1) < 1e-8 && std::abs(state.time / time - 1) < 1e-8 ? 0 : 1;
}
