// 04_write_a_joint: a bob on a massless rod circles as a conical pendulum; the rod is a joint of our own.
//
// Shows: a joint is one class with one function: its residual, the wrench of a unit multiplier, the velocity terms.
// Expect: the bob comes back after 2π √(ℓ cos θ / g), to 1e-6 m, and the rod pulls with m g / cos θ.
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

/// Massless rod with a ball at each end.
///   g = ½ (d·d − ℓ²),   ġ = d·ḋ,   bias = ḋ·ḋ,   where d = p_B − p_A
class MasslessRod final : public Joint</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    double length = 1.0;  // ℓ, metres
  };
  explicit MasslessRod(Parameters parameters) : length_(parameters.length) {}

  void evaluate(double /*time*/, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    const Vector3 d = B.p - A.p, d_dot = B.v - A.v;
    rows.add(0.5 * (d.dot(d) - length_ * length_), {force(-d), force(d)}, d_dot.dot(d_dot));
  }

 private:
  const double length_;
};

int main() {
  // 1. A cone of 30 degrees: the bob's speed is what keeps it there.
  const double length = 0.5, mass = 2, angle = M_PI / 6, g = 9.81;
  const double rate = std::sqrt(g / (length * std::cos(angle))), radius = length * std::sin(angle);

  // 2. Draw it. Our joint is added as the built-in ones are, and runs in the same typed loops.
  SystemGraph graph{{.gravity = {0, 0, -g}}};
  auto& bob = graph.add<RigidBody>("bob", {.mass = mass,
                                           .inertia = {1e-3, 1e-3, 1e-3},
                                           .position = {radius, 0, -length * std::cos(angle)},
                                           .velocity = {0, rate * radius, 0}});
  graph.add<MasslessRod>("rod", {graph.ground().marker(), bob.marker()}, {.length = length});

  // 3. Once round.
  const System system = assemble(graph);
  const State start = system.initial_state();
  State state = start;
  ExplicitRungeKutta integrator{{.tolerance = {.relative = 1e-9, .absolute = 1e-9}}};
  Simulation{system, integrator}.run(state, 2 * M_PI / rate);

  // 4. Check the answer. The multiplier is the tension over ℓ; a rod that pulls has a positive one.
  const double gap = (state.q - start.q).head<3>().norm(), tension = state.lambda[0] * length;
  std::printf("after one turn %.1e m from the start; tension %.6f N, exact %.6f N\n", gap, tension,
              mass * g / std::cos(angle));
  return gap < 1e-6 && std::abs(tension * std::cos(angle) / (mass * g) - 1) < 1e-6 ? 0 : 1;
}
