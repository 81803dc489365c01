// own_integrator: the explicit midpoint rule, of order 2, with projection onto the joints.
#include <cmath>
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

/// Explicit midpoint rule: v̇ at the middle of the step, reached by half an Euler step, serves the whole of it. Turns
/// are increments d in the chart of the step's start, ḋ = Jr⁻¹(d) v. A step ends on g = 0 and ġ = 0.
class Midpoint final : public Integrator {
 public:
  struct Parameters {
    double step = 1e-3;  // s
  };
  /// Throws SceneError for a step that is not above zero.
  explicit Midpoint(Parameters parameters) : step_(parameters.step) { require::positive(step_, "step"); }

  std::string name() const override { return "explicit midpoint rule"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override {
    Projector(equations).accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
  }
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override {
    const Layout& layout = equations.layout();
    Projector projector(equations);
    // Equal steps up to t_stop, which is hit to the bit.
    const double left = t_stop - state.time, count = std::max(1.0, std::ceil(left / step_ - 1e-9)), h = left / count;
    const double end = count > 1 ? state.time + h : t_stop;

    VectorX d = h / 2 * state.v, v = state.v + h / 2 * state.v_dot, q = state.q, d_dot(v.size()), v_dot(v.size());
    layout.retract(state.q, d, q);
    layout.chart_rates(d, v, d_dot);
    projector.accelerations(state.time + h / 2, q, v, v_dot, state.lambda);

    layout.retract(state.q, h * d_dot, q);
    v = state.v + h * v_dot;
    if (!projector.position(end, q, 1e-12, 20).converged)
      return {StepResult::Outcome::failed, "the step leaves the constraints"};
    projector.velocity(end, q, v);
    state.time = end, state.q = q, state.v = v;
    projector.accelerations(end, state.q, state.v, state.v_dot, state.lambda);
    ++statistics_.steps;
    return {};
  }

 private:
  const double step_;
  IntegratorStatistics statistics_;
};

int main() {
  // 1. A rod on a hinge, let go level.
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  auto& rod = graph.add<RigidBody>("rod", {.mass = 1, .inertia = {1e-4, 1.0 / 12, 1.0 / 12}, .position = {0.5, 0, 0}});
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, along_y), rod.marker({-0.5, 0, 0}, along_y)});
  const System system = assemble(graph);
  const auto end = [&](Integrator& method) {
    State state = system.initial_state();
    Simulation{system, method}.run(state, 1);
    return state;
  };

  // 2. Steps of 2, 1 and 0.5 ms against a tight reference.
  ExplicitRungeKutta tight{{.tolerance = {.relative = 1e-12, .absolute = 1e-12}}};
  const State reference = end(tight);
  double error[3];
  for (int i = 0; i < 3; ++i) {
    Midpoint method{{.step = 2e-3 / (1 << i)}};
    error[i] = (end(method).q - reference.q).norm();
  }

  // 3. Check the answer: half the step, a quarter of the error.
  const double first = std::log2(error[0] / error[1]), second = std::log2(error[1] / error[2]);
  std::printf("errors %.2e, %.2e, %.2e: orders %.2f, %.2f\n", error[0], error[1], error[2], first, second);
  return std::abs(first - 2) < 0.2 && std::abs(second - 2) < 0.1 ? 0 : 1;
}
