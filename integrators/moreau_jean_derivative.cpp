#include "engine/base/error.h"
#include "engine/cones/direct_cone_solver.h"
#include "integrators/moreau_jean.h"

namespace lithe {

/// With impulses to round-off. What joints make of the method's matrix depends on the last v̇ and on the multipliers of
/// the start: where there are joints both are history, the multipliers in as many columns as they fill.
class RepeatedMoreauJean final : public RepeatedStep {
 public:
  RepeatedMoreauJean(const MoreauJean& method, EquationsOfMotion& equations)
      : equations_(equations),
        method_(exact(method.parameters_), std::make_unique<DirectConeSolver>()),
        lambda_(method.lambda_) {}

  MatrixX history(const State& from, const StepRecord* /*record*/) const override {
    return packed(from.v_dot, lambda_);
  }

  void take(const State& from, const StepRecord* /*record*/, MatrixX& history, State& to) override {
    now_ = from;
    method_.start(equations_, now_);
    now_ = from;
    if (history.cols() > 0) {
      now_.v_dot = history.col(0);
      now_.lambda = history.rightCols(history.cols() - 1).reshaped().head(lambda_.size());
      method_.lambda_ = now_.lambda;
    }
    while (now_.time < to.time) {
      const StepResult result = method_.step(equations_, now_, to.time, Multipliers::later);
      if (!result.ok())
        throw SimulationError(
            "the step to t = " + std::to_string(to.time) + " s cannot be taken again nearby: " + result.why,
            "Moreau-Jean, derivative of a step", "look for what is not smooth there");
    }
    history = packed(now_.v_dot, method_.lambda_);
    to = now_;
  }

 private:
  static MoreauJean::Parameters exact(MoreauJean::Parameters parameters) {
    parameters.contact.tolerance = 1e-15;
    return parameters;
  }
  static MatrixX packed(const VectorX& v_dot, const VectorX& lambda) {
    const Eigen::Index n = v_dot.size(), rows = lambda.size(), columns = rows > 0 ? 1 + (rows + n - 1) / n : 0;
    MatrixX history = MatrixX::Zero(n, columns);
    if (columns > 0) history.col(0) = v_dot, history.rightCols(columns - 1).reshaped().head(rows) = lambda;
    return history;
  }

  EquationsOfMotion& equations_;
  MoreauJean method_;
  const VectorX lambda_;  // as the run's method has it
  State now_;
};

std::unique_ptr<RepeatedStep> MoreauJean::repeated_step(EquationsOfMotion& equations) const {
  return std::make_unique<RepeatedMoreauJean>(*this, equations);
}

std::string MoreauJean::refuse_repetition(EquationsOfMotion& equations) const {
  for (const auto& body : equations.layout().bodies())
    if ((body.frame ? 6 : 0) + body.linear > 6)
      return "Moreau-Jean solves steps of bodies that deform to 1e-8 only, which cannot be differentiated";
  return "";
}

bool MoreauJean::within_step(const State& state) const {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  return impulses_.next_stop(state.time, kAny) < kAny;
}

}  // namespace lithe
