#pragma once

#include <vector>

#include "engine/gradient/moved_drawing.h"

namespace lithe {

/// The event's change, at a state at its time, which is then moved onto the constraints as Simulation does it. Nothing
/// where the event has no change.
void apply_event(const ParametricEvent& event, const Drawing& drawing, Evaluator& equations, State& state);

/// What small changes of the state and of the parameters come to across an event: the saltation matrix. The event's
/// function φ passes its level at another time, at which another state jumps; beside the run at one and the same time
///   δt = -(φ_x δx + φ_p δp)/φ̇,   δx⁺ = J (δx + ẋ δt) + J_t δt + J_p δp - ẋ⁺ δt
/// Changes are those of Variation: turns, then velocities; behind the event also the vectors that the method carries,
/// as it starts there.
class EventDerivative {
 public:
  /// All are borrowed.
  EventDerivative(const ParametricScene& scene, const std::vector<DesignParameter>& parameters, const Drawing& drawing);
  ~EventDerivative();

  struct Jump {
    MatrixX by_state, by_parameters;            // of the state behind the event
    VectorX time_by_state, time_by_parameters;  // of the event's time, s
  };
  /// Throws SimulationError where the function touches its level without passing it.
  Jump at(int event, const State& before, const State& after);

 private:
  VectorX rate(const State& state);
  void add_start(const State& behind, Jump& jump);
  template <class Look>
  void visit(int k, const Look& look);

  const ParametricScene& scene_;
  const std::vector<DesignParameter>& parameters_;
  const Drawing& drawing_;
  Evaluator equations_;
  std::vector<std::unique_ptr<MovedDrawing>> few_;  // of few parameters, four each; else drawn at each event
};

}  // namespace lithe
