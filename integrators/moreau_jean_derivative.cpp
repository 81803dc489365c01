#include "engine/base/error.h"
#include "engine/cones/direct_cone_solver.h"
#include "integrators/moreau_jean.h"

namespace lithe {

/// With impulses to round-off.
class RepeatedMoreauJean final : public RepeatedStep {
 public:
  RepeatedMoreauJean(const MoreauJean& method, EquationsOfMotion& equations)
      : equations_(equations),
        method_(exact(method.parameters_), std::make_unique<DirectConeSolver>()),
        lambda_(method.lambda_) {}

  void take(const State& from, const StepRecord* /*record*/, MatrixX& /*history*/, State& to) override {
    now_ = from;
    method_.start(equations_, now_);
    method_.lambda_ = lambda_;
    now_ = from;
    while (now_.time < to.time) {
      const StepResult result = method_.step(equations_, now_, to.time, Multipliers::later);
      if (!result.ok())
        throw SimulationError(
            "the step to t = " + std::to_string(to.time) + " s cannot be taken again nearby: " + result.why,
            "Moreau-Jean, derivative of a step", "look for what is not smooth there");
    }
    to = now_;
  }

 private:
  static MoreauJean::Parameters exact(MoreauJean::Parameters parameters) {
    parameters.contact.tolerance = 1e-15;
    return parameters;
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
      return "Moreau-Jean solves steps of bodies that deform to 1e-6 only, which cannot be differentiated";
  return "";
}

bool MoreauJean::within_step(const State& state) const {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  return impulses_.next_stop(state.time, kAny) < kAny;
}

}  // namespace lithe
