#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/motion/equations_of_motion.h"

namespace lithe {

/// Small changes of the states between two steps, a column each; or, in adjoint mode, what is wanted by them.
struct Variation {
  MatrixX turn;                  // δq in the axes of velocities: δp, turn in body axes, δη
  MatrixX velocity;              // δv
  std::vector<MatrixX> history;  // of the vectors that a method carries along besides q and v
  MatrixX memory;                // of the numbers that contacts remember (contact_numbers()); often no rows
};

/// One of the equations near a state: r = M a + Gᵀ l - f or, without forces, M a + Gᵀ l; and rows at a level:
///   g,   G v + ∂g/∂t,   G a - γ,   or G u alone.
struct WeightedSum {
  enum class Rows { position, velocity, acceleration, product } rows = Rows::position;
  bool forces = true;
  VectorX a, l, u;
};

/// What the derivative of a step needs of it besides the states at its ends: the method's own.
class StepRecord {
 public:
  virtual ~StepRecord() = default;
  virtual std::size_t bytes() const = 0;
};

/// A kink of a force law within a step: a part of it ended there, and the method started anew.
struct PassedKink {
  int number;                                // engine/run/kinks.h; -1: the part ended on the way, without
  double stop, time;                         // s: that the step was to end at, and did
  std::shared_ptr<const StepRecord> record;  // of the part that led there
};

/// A step of a run.
struct TakenStep {
  const State& from;
  const State& to;
  const StepRecord* record;                        // of its last part; null: the method keeps none
  const std::vector<PassedKink>* kinks = nullptr;  // null or empty: a step without
};

/// The equations of motion near one state, differentiated to round-off by q, v, v_dot, λ and the parameters of a scene:
///   r = M v̇ + Gᵀλ - f;   g, or G v + ∂g/∂t for rows on velocities alone
/// What a StepDerivative is given. Turns are those of the state itself, in body axes.
class LinearEquations {
 public:
  virtual ~LinearEquations() = default;
  virtual const Layout& layout() const = 0;
  virtual const std::vector<int>& velocity_rows() const = 0;
  /// Undifferentiated. Who evaluates them comes back by at().
  virtual EquationsOfMotion& equations() = 0;
  /// The state that the rest refers to.
  virtual void at(const State& state) = 0;

  struct Direction {
    VectorX turn, velocity, acceleration, multipliers;
  };
  /// The derivatives of r and of the rows along a direction; where asked for, those of ġ = G v + ∂g/∂t too.
  virtual void along(const Direction& direction, VectorX& force, VectorX& rows, VectorX* rates = nullptr) = 0;
  /// ∂r/∂p, ∂g/∂p and, where asked for, ∂ġ/∂p; a column a parameter.
  virtual void parameter_columns(MatrixX& force, MatrixX& rows, MatrixX* rates = nullptr) = 0;

  /// An iteration matrix near [S Gᵀ; G 0], or near [Sᵀ Gᵀ; G 0], as EquationsOfMotion::factorize() has it.
  virtual void factorize(const TangentWeights& weights, const VectorX& increment, bool transposed) = 0;
  virtual void solve(VectorX& force, VectorX& rows) = 0;

  struct Pulled {
    VectorX turn;          // Kᵀμ + Gᵀν, K = ∂r/∂q
    VectorX velocity;      // Dᵀμ, D = ∂r/∂v
    VectorX acceleration;  // M μ
    VectorX rows;          // G μ
  };
  /// Products with the transposed derivatives.
  virtual void pull(const VectorX& mu, const VectorX& nu, Pulled& out) = 0;
  /// out += factor (μᵀ ∂r/∂p + νᵀ ∂g/∂p), a column a want.
  virtual void add_parameter_products(const MatrixX& mu, const MatrixX& nu, double factor, MatrixX& out) = 0;

  /// The transposed iteration matrix at complex weights, beside the real one; corrections are turns of the state.
  virtual void factorize_complex(const ComplexTangentWeights& weights) = 0;
  virtual void solve_complex(ComplexVectorX& force, ComplexVectorX& rows) = 0;

  // ---- what starts and methods of index 1 and 2 take, backwards; columns are wants ----
  /// Solves [M Gᵀ; G 0] (x, y) = (force, rows) at the state, in place.
  virtual void solve_mass(MatrixX& force, MatrixX& rows) = 0;
  /// v̇ and λ of the equations at the state's t, q, v: [M Gᵀ; G 0] (v̇, λ) = (f, γ).
  virtual void accelerations(VectorX& v_dot, VectorX& lambda) = 0;
  /// Adds factor times the derivatives of the sums μ · r + ν · row by q, v and the parameters; a and l do not change. A
  /// gradient without rows: not by the parameters.
  virtual void add_weighted(const WeightedSum& sum, const MatrixX& mu, const MatrixX& nu, double factor, MatrixX& turn,
                            MatrixX& velocity, MatrixX& gradient) = 0;
  /// From what is wanted of these v̇ to the same of q, v and the parameters, added.
  void add_accelerations(MatrixX wanted, MatrixX& turn, MatrixX& velocity, MatrixX& gradient);
  /// Adds the derivatives of the sums ν · (G v + ∂g/∂t).
  void add_rate_sums(const MatrixX& nu, MatrixX& turn, MatrixX& velocity, MatrixX& gradient);
};

/// The derivative of the very steps that an integrator took, backwards. Each step is the solution of equations, x' =
/// x'(x, p); how they were solved does not matter.
class StepAdjoint {
 public:
  virtual ~StepAdjoint() = default;
  /// From what is wanted of the changes at `to` to the same of those at `from`; a column a want. Adds what the
  /// parameters do within the step to `gradient`, a column a want. Throws SimulationError where the linear equations
  /// cannot be solved.
  virtual void adjoint(LinearEquations& equations, const TakenStep& step, Variation& x, MatrixX& gradient) = 0;
  /// Through the integrator's start() from this state, right after it: from what is wanted of the state and of the
  /// history that it left to what is wanted of q and v before.
  virtual void adjoint_start(LinearEquations& equations, const State& before, Variation& x, MatrixX& gradient) = 0;
  /// Whether adjoint() takes the parameters through add_weighted().
  virtual bool weighs_parameters() const { return true; }
  /// Why there is no adjoint with these equations; empty: there is.
  virtual std::string refuse(EquationsOfMotion& /*equations*/) const { return ""; }
};

/// Forwards too.
class StepDerivative : public StepAdjoint {
 public:
  /// The vectors of length v_count that the method carries besides q and v, as its last step or start() left them; a
  /// column each.
  virtual MatrixX history(const State& state) const = 0;
  /// Why the step between these states cannot be differentiated; empty: it can.
  virtual std::string refuse_step(const State& /*from*/, const State& /*to*/) const { return ""; }
  /// Whether the method's equations here are not those of this step: it is then taken again nearby (RepeatedStep).
  virtual bool by_repetition(const TakenStep& /*step*/) const { return false; }
  /// From the changes at `from` to those at `to`, a column a parameter. Throws as adjoint().
  virtual void tangent(LinearEquations& equations, const TakenStep& step, Variation& x) = 0;
};

/// Takes steps of one method again, from states near those of a run and with equations near those of the run: the
/// lengths of the steps are given, iterations are carried to round-off, nothing is remembered from step to step.
class RepeatedStep {
 public:
  virtual ~RepeatedStep() = default;
  /// What the method carries besides q and v (StepDerivative::history()) as a step from there with that record begins.
  virtual MatrixX history(const State& /*from*/, const StepRecord* /*record*/) const { return {}; }
  /// q, v and what contacts remember at to.time, from those of `from`; likewise the history, in place. The equations
  /// have recalled what `from` remembers. Throws SimulationError where the step fails.
  virtual void take(const State& from, const StepRecord* record, MatrixX& history, State& to) = 0;
  /// How far the iterations of a run may leave the end of a step from its solution.
  struct Rest {
    double turn, velocity;  // m, rad, modal; and of velocities
  };
  virtual Rest left_by_iterations(const State& /*from*/, const State& /*to*/) const { return {0, 0}; }
  /// Starts the method anew, for the next take().
  virtual void restart(State& /*state*/, MatrixX& /*history*/) {}
};

/// An integrator whose steps can be differentiated. What it gives refers to it; null: there is no such thing for its
/// parameters.
class DifferentiableSteps {
 public:
  virtual ~DifferentiableSteps() = default;
  virtual std::unique_ptr<StepDerivative> step_derivative() const { return nullptr; }
  virtual std::unique_ptr<StepAdjoint> step_adjoint() const { return step_derivative(); }
  /// Of the step taken last; null: states tell all.
  virtual std::shared_ptr<const StepRecord> step_record() const { return nullptr; }
  /// For derivatives by differences of steps: of methods without equations of their own here, of single steps
  /// (StepDerivative::by_repetition) and of all where contacts are beyond these equations.
  virtual std::unique_ptr<RepeatedStep> repeated_step(EquationsOfMotion& /*equations*/) const { return nullptr; }
  /// Why there is no such step with these equations; empty: there is, if at all.
  virtual std::string refuse_repetition(EquationsOfMotion& /*equations*/) const { return ""; }
  /// Whether the state is one between the ends of a step whose derivative there is: of a step that was cut in two.
  virtual bool within_step(const State& /*state*/) const { return false; }
};

}  // namespace lithe
