#pragma once

#include <memory>
#include <vector>

#include "engine/gradient/parameter_derivative.h"
#include "engine/gradient/unreached_directions.h"
#include "engine/motion/step_derivative.h"
#include "engine/observe/snapshot.h"
#include "engine/run/kinks.h"

namespace lithe {

/// Turns, velocities, history and memory, one below the other; and back, where vectors of `count` are followed by
/// `history` more of them and the memory.
MatrixX stacked(const Variation& x);
void unstack(const MatrixX& all, Eigen::Index count, std::size_t history, Variation& x);

/// The derivative of steps by steps taken again: from states on both sides of the step's start along a direction (six,
/// error h⁶), and with the drawings at parameter ± step and ± 2 step from the start itself. Whatever a method does
/// within a step is in it: forward dynamics of trees, restarts, kinks of force laws, each at its own time, contacts
/// with the set of points, sticking and sliding, that the run found. The lengths of the steps are those of the run.
/// Forwards a direction is a parameter's change of the state; backwards there is one for each number of the state.
///   At kinks and with contacts, whose laws bend within the depth of an overlap, states are moved by less until the
/// orders of differences agree.
class RepeatedSteps {
 public:
  /// `parameters` are moved apart (ParameterDerivative::Grouping::apart).
  RepeatedSteps(const DifferentiableSteps& method, const Drawing& nominal, ParameterDerivative& parameters);

  /// Both throw SimulationError where a step fails, was not the method's own, or where contacts are about to change.
  void tangent(const TakenStep& step, Variation& x);
  void adjoint(const TakenStep& step, Variation& x, MatrixX& gradient);
  /// Backwards, where the run begins with these changes, and where steps of other kinds, or events, come before those
  /// taken again: throws SimulationError where what leads there has no derivative.
  void begin_at(const Variation& start) const;
  void leave() const;

 private:
  struct Equations {
    Evaluator* evaluator;
    std::unique_ptr<RepeatedStep> step;
    double weight;                       // of the parameter's difference
    std::unique_ptr<Snapshot> now = {};  // once a kink is passed
    std::vector<Kink> kinks = {};
  };
  void begin(const TakenStep& step);
  bool take(Equations& equations, const State& from, MatrixX history, VectorX& change);
  void pass(Equations& equations, double time, const StepRecord* record, MatrixX& history);
  void land(Equations& equations, const PassedKink& kink, MatrixX& history);
  bool along(const VectorX& direction, VectorX& change);
  VectorX by_parameter(std::size_t k);
  double noise(std::size_t k) const;
  [[noreturn]] void refuse(const char* why) const;

  Evaluator evaluator_;
  const bool forward_;  // the method may take forward dynamics, not its own equations of multipliers
  Equations nominal_;
  std::vector<std::vector<Equations>> moved_;  // of each parameter
  // Of the present step.
  const TakenStep* step_ = nullptr;  // until the next one begins, or the run is left
  MatrixX history_, end_history_;
  State end_;  // of the step begun last, as it is taken again
  VectorX memory_;
  UnreachedDirections unreached_;  // backwards: at the step's end
  ContactMemory end_contacts_;
  State near_, reached_, start_, at_kink_;
};

}  // namespace lithe
