#include "engine/plugin.h"

using namespace lithe;

/// Heun's method, explicit and of order 2, in the chart of the step's start; each step ends projected onto g = 0, ġ =
/// 0.
class Heun final : public Integrator {
 public:
  struct Parameters {
    double step = 1e-3;  // s
    std::string title = "Heun";
    int substeps = 1;
  };
  static constexpr Field<Parameters> kParameters[] = {
      {"step", &Parameters::step}, {"title", &Parameters::title}, {"substeps", &Parameters::substeps}};
  explicit Heun(Parameters parameters) : parameters_(std::move(parameters)) {
    require::positive(parameters_.step, "step");
  }

  std::string name() const override { return parameters_.title; }
  void prepare(EquationsOfMotion& equations, State& state) override {
    Projector(equations).accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
  }
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override {
    const Layout& layout = equations.layout();
    Projector projector(equations);
    const double count = std::ceil((t_stop - state.time) / (parameters_.step / parameters_.substeps) - 1e-9);
    const double h = (t_stop - state.time) / count, time = count > 1 ? state.time + h : t_stop;
    VectorX d = h * state.v, v = state.v + h * state.v_dot, q = state.q, d_dot(v.size()), v_dot(v.size());
    layout.retract(state.q, d, q);
    layout.chart_rates(d, v, d_dot);
    projector.accelerations(time, q, v, v_dot, state.lambda);
    d = h / 2 * (state.v + d_dot);
    layout.retract(state.q, d, q);
    v = state.v + h / 2 * (state.v_dot + v_dot);
    if (!projector.position(time, q, 1e-12, 20).converged)
      return {StepResult::Outcome::failed, "the step leaves the constraints"};
    projector.velocity(time, q, v);
    state.time = time, state.q = q, state.v = v;
    projector.accelerations(time, state.q, state.v, state.v_dot, state.lambda);
    ++statistics_.steps;
    return {};
  }
  const IntegratorStatistics& statistics() const override { return statistics_; }

 private:
  const Parameters parameters_;
  IntegratorStatistics statistics_;
};

LITHE_EXPORT_INTEGRATOR(Heun, "heun")
