// own_force: a ball falls through air whose drag grows with the square of its speed.
#include <cmath>
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

/// Drag of still air on a point: f = −c |v| v.
class Drag final : public Force</*markers=*/1, /*rows=*/0> {
 public:
  struct Parameters {
    double coefficient = 0;  // c = ½ ρ c_w A, kg/m
  };
  /// Throws SceneError for a coefficient below zero.
  explicit Drag(Parameters parameters) : coefficient_(parameters.coefficient) {
    require::not_negative(coefficient_, "coefficient");
  }

  void evaluate(double /*time*/, std::span<const MarkerView> markers, ForceRows& rows) const override {
    const MarkerView& point = markers[0];
    rows.add_load(point, force(-coefficient_ * point.v.norm() * point.v));
  }
  bool depends_on_time() const override { return false; }

 private:
  const double coefficient_;
};

int main() {
  // 1. A ball of 0.5 kg, let go at rest.
  const double mass = 0.5, g = 9.81, c = 0.02, duration = 3;
  SystemGraph graph{{.gravity = {0, 0, -g}}};
  auto& ball = graph.add<RigidBody>("ball", {.mass = mass, .inertia = {1e-3, 1e-3, 1e-3}});
  graph.add<Drag>("air", {ball.marker()}, {.coefficient = c});

  // 2. Three seconds of fall.
  const System system = assemble(graph);
  State state = system.initial_state();
  ExplicitRungeKutta integrator{{.tolerance = {.relative = 1e-10, .absolute = 1e-10}}};
  Simulation{system, integrator}.run(state, duration);

  // 3. Check the answer: v = v∞ tanh(g t / v∞), v∞ = sqrt(m g / c).
  const double last = std::sqrt(mass * g / c), exact = last * std::tanh(g * duration / last);
  std::printf("falls at %.9f m/s (exact %.9f), at most %.3f\n", -state.v[2], exact, last);
  return std::abs(-state.v[2] / exact - 1) < 1e-8 ? 0 : 1;
}
