#pragma once

namespace lithe {

struct State;

/// Equations of motion whose integrator is to look at the states that it reaches: at what no method sees of them.
class StateCheck {
 public:
  virtual ~StateCheck() = default;
  /// Throws SimulationError where constraint rows that are left out contradict those that they repeat, or a joint is
  /// beyond its limits. Evaluates the state.
  virtual void check(const State& state) = 0;
};

}  // namespace lithe
