#pragma once

#include "engine/analysis/linearization.h"
#include "engine/gradient/parameter_derivative.h"
#include "engine/gradient/tangent_equations.h"

namespace lithe {

/// The equilibrium of a drawing and how it changes with parameters:
///   K δq + Gᵀ δλ + ∂F/∂p δp = 0,   G δq + ∂g/∂p δp = 0,   F = Gᵀ λ - f(q, 0, t)
/// K as differences have it; solved with the elements' own tangents, refined.
class StaticDerivative {
 public:
  StaticDerivative(const ParametricScene& scene, const std::vector<DesignParameter>& parameters, const Drawing& nominal,
                   const std::vector<Drawing::Place>& columns);

  const State& state() const { return state_; }
  ParameterDerivative& parameters() { return parameters_; }
  /// δq, a column a parameter.
  const MatrixX& turns() const { return turns_; }

  /// Hz of the undamped oscillation of that number, and its derivatives: differences of the frequencies at the
  /// equilibria of drawings on both sides, with modes refined to round-off from that of the drawing. (Perturbation
  /// formulas need dK along the path of equilibria, which stiff bodies drown in round-off.) Throws SceneError for a
  /// number that there is not, for a frequency that another one shares, and for one of zero.
  double frequency(int number, VectorX& derivatives);

 private:
  void solve();
  VectorX mode(int number, double& omega_squared);

  const ParametricScene& scene_;
  const std::vector<DesignParameter> drawn_;
  const Drawing& nominal_;
  State state_;
  ParameterDerivative parameters_;
  TangentEquations equations_;
  MatrixX turns_;
};

}  // namespace lithe
