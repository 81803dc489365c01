#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/gradient/gradient.h"

namespace lithe {

/// A parameter that may be chosen between bounds.
struct FreeParameter {
  std::string name;
  double value = 0;  // to begin with
  double lower = -1e300, upper = 1e300;
  double step = 0;  // of differences (DesignParameter)
};

/// Where a search is: `value` is half the sum of squares of a fit, or the objective.
struct SearchStep {
  int iteration = 0;
  double value = 0;
  VectorX parameters;
};

struct FitOptions {
  int max_iterations = 50;
  double tolerance = 1e-10;  // relative, of the sum of squares and of the parameters
  double deviation = 0;      // of one measurement, in the unit of its column; 0: from what the fit leaves over
  VectorX deviations{};      // of each column instead
  double confidence = 0.95;  // of the intervals
  std::function<void(const SearchStep&)> progress{};  // told of each iteration; may throw to end the search
};

struct Fit {
  std::vector<std::string> parameters;
  VectorX values;
  MatrixX covariance;    // of the values, by linear theory: σ² (JᵀJ)⁻¹
  VectorX deviations;    // square roots of its diagonal
  VectorX lower, upper;  // intervals that hold the true values with the asked confidence (Student's t)
  double deviation = 0;  // σ: given, or √(sum of squares / (measurements - parameters)); of scaled columns one
  int measurements = 0, iterations = 0, evaluations = 0;
  bool converged = false;
  std::string message;                // of the search
  std::vector<std::string> at_bound;  // parameters that end at a bound: their intervals do not hold

  double operator()(const Located& parameter) const;
  std::string text() const;  // "stiffness 249.6 ± 1.2 (95 %: 247.2 … 252.0)", a line a parameter
};

/// Parameters with which a run comes nearest to measurements, by least squares: Σ ((F(t) - measured)/σ)². `measured`: a
/// column "t", rising, in s, then columns named as those of the scene's sensors; a value that is not finite (an empty
/// cell of a CSV) is left out. Trust-region Levenberg-Marquardt (Ceres) with the derivatives of gradient().
///   Throws SceneError: no column "t", columns that the scene does not have, fewer measurements than parameters, a
///   value
/// outside its bounds; whatever gradient() throws.
Fit fit(const ParametricScene& scene, const Table& measured, const std::vector<FreeParameter>& parameters,
        const FitOptions& options = {});

}  // namespace lithe
