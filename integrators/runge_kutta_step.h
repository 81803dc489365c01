#pragma once

#include <string>

#include "engine/motion/integrator.h"
#include "engine/motion/projection.h"
#include "integrators/runge_kutta_tableau.h"

namespace lithe {

/// One step of an explicit Runge-Kutta method on the index-1 form, in the chart of its start (explicit_runge_kutta.h),
/// its error estimate, stiffness estimate and dense output. Everything told refers to the step tried last.
class RungeKuttaStep {
 public:
  enum class Outcome { taken, no_number, off_constraints };

  RungeKuttaStep(const RungeKuttaTableau& tableau, EquationsOfMotion& equations);

  const EquationsOfMotion& equations() const { return equations_; }
  /// The length of an explicit Euler step that would err by a hundredth of the allowance, from the size of the first
  /// and second derivatives (Hairer, Nørsett & Wanner I, II.4).
  double first_step(const State& start, const Tolerance& tolerance, double max_step);
  /// Makes v_dot and lambda of the state consistent.
  void accelerations(State& state);

  /// From `start`, whose v_dot is consistent, by h to `time`.
  Outcome attempt(const State& start, double h, double time);
  /// Root mean square of error over allowance; component() is then the velocity with the largest share in it.
  double error(const State& start, double h, const Tolerance& tolerance);
  int component() const { return component_; }
  /// First velocity whose acceleration is not finite; -1: none.
  int broken() const;
  /// Hands out q, v, v_dot and lambda at the end of the step; without lambda if it may come later and is not there.
  void finish(State& state, Multipliers multipliers);
  /// h |λ| of the fastest motion that the last two stages, both at the end of the step, tell apart; 0: they do not
  /// differ. As in Hairer's codes (Hairer & Wanner II, IV.2), but in the terms of a system of second order: with d' =
  /// v, |λ|² = |Δv̇| / |Δd| is right for oscillators and dampers alike, whatever the units of v.
  double stiffness() const { return stiffness_; }

  /// The method's own dense output of order 7 within the step from `from` to `to`; false if it has none. Constraints
  /// hold to its error. The first call of a step evaluates three more stages.
  bool interpolate(const State& from, const State& to, double time, State& out);

  void history(Archive& archive);

  long evaluations = 0, factorizations = 0;

 private:
  void stage(const State& start, double h, int i);
  void accelerate(double time, int i, Projector::Factor factor = Projector::Factor::fresh);
  void estimate_stiffness();
  bool prepare_dense(const State& from, const State& to);

  const RungeKuttaTableau& tableau_;
  EquationsOfMotion& equations_;
  const Layout& layout_;
  int refusals_ = 0;          // of forward_ to project, in a row
  ForwardDynamics* forward_;  // null: by the projector, with multipliers
  Projector projector_;
  MatrixX d_dot_, v_dot_;       // a column a stage
  VectorX q_, d_, v_, lambda_;  // of the stage being computed
  VectorX d_before_;            // of the stage before the last
  VectorX d_error_, v_error_, d_second_, v_second_, d_size_, v_size_;
  int component_ = -1;
  double begin_ = 0, end_ = 0, h_ = 0, stiffness_ = 0;
  bool dense_ready_ = false;
  MatrixX d_dense_, v_dense_;  // a column a coefficient of the nested polynomial
  MatrixX lambda_dense_;       // at the times of lambda_time_
  VectorX d_rate_;
};

}  // namespace lithe
