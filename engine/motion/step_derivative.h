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
};

/// The equations of motion near one state, differentiated to round-off by q, v, v_dot, λ and the parameters of a scene:
///   r = M v̇ + Gᵀλ - f;   g, or G v + ∂g/∂t for rows on velocities alone
/// What a StepDerivative is given. Turns are those of the state itself, in body axes.
class LinearEquations {
 public:
  virtual ~LinearEquations() = default;
  virtual const Layout& layout() const = 0;
  virtual const std::vector<int>& velocity_rows() const = 0;
  /// The state that the rest refers to.
  virtual void at(const State& state) = 0;

  struct Direction {
    VectorX turn, velocity, acceleration, multipliers;
  };
  /// The derivatives of r and of the rows along a direction.
  virtual void along(const Direction& direction, VectorX& force, VectorX& rows) = 0;
  /// ∂r/∂p and ∂g/∂p, a column a parameter.
  virtual void parameter_columns(MatrixX& force, MatrixX& rows) = 0;

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
  /// out += μᵀ ∂r/∂p + νᵀ ∂g/∂p
  virtual void add_parameter_products(const VectorX& mu, const VectorX& nu, VectorX& out) = 0;
};

/// The derivative of the very steps that an integrator took: of state and history at a step's end by those at its begin
/// and by the parameters. Each step is the solution of equations, x' = x'(x, p); how they were solved does not matter.
class StepDerivative {
 public:
  virtual ~StepDerivative() = default;
  /// The vectors of length v_count that the method carries besides q and v, as its last step or start() left them; a
  /// column each.
  virtual MatrixX history(const State& state) const = 0;
  /// Why the step between these states cannot be differentiated; empty: it can.
  virtual std::string refuse(const State& from, const State& to) const = 0;
  /// From the changes at `from` to those at `to`, a column a parameter. Throws SimulationError where the linear
  /// equations cannot be solved.
  virtual void tangent(LinearEquations& equations, const State& from, const State& to, Variation& x) = 0;
  /// Backwards: from what is wanted of the changes at `to` to the same of those at `from`; a column a want. Adds what
  /// the parameters do within the step to `gradient`, a column a want.
  virtual void adjoint(LinearEquations& equations, const State& from, const State& to, Variation& x,
                       MatrixX& gradient) = 0;
};

/// An integrator whose steps can be differentiated.
class DifferentiableSteps {
 public:
  virtual ~DifferentiableSteps() = default;
  /// Refers to the integrator. Null: its parameters ask for a variant that cannot be differentiated.
  virtual std::unique_ptr<StepDerivative> step_derivative() const = 0;
};

}  // namespace lithe
