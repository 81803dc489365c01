#pragma once

#include <memory>
#include <vector>

#include "engine/gradient/parameter_derivative.h"
#include "engine/motion/step_derivative.h"

namespace lithe {

/// The derivative of steps forwards, by steps taken again: from states on both sides of the step's start along each
/// column (six, error h⁶), and with the drawings at parameter ± step and ± 2 step from the start itself. Whatever a
/// method does within a step is in it, forward dynamics of trees too; the lengths of the steps are those of the run.
class RepeatedSteps {
 public:
  /// `parameters` are moved apart (ParameterDerivative::Grouping::apart).
  RepeatedSteps(const DifferentiableSteps& method, const Drawing& nominal, ParameterDerivative& parameters);

  /// Throws SimulationError where a step fails, or was not the method's own.
  void tangent(const State& from, const State& to, Variation& x);

 private:
  struct Equations {
    Evaluator* evaluator;
    std::unique_ptr<RepeatedStep> step;
    double weight;  // of the parameter's difference
  };
  void take(Equations& equations, const State& from, const State& to, VectorX& turn, VectorX& velocity);

  Evaluator evaluator_;
  Equations nominal_;
  std::vector<std::vector<Equations>> moved_;  // of each parameter
  State near_, reached_, on_joints_;
};

}  // namespace lithe
