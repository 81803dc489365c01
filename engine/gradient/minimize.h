#pragma once

#include "engine/gradient/fit.h"

namespace lithe {

/// A quantity that must not exceed `upper`, nor fall below `lower`.
struct Limit {
  Quantity quantity;
  double lower = -1e300, upper = 1e300;
};

struct MinimizeOptions {
  int max_evaluations = 200;
  double tolerance = 1e-8;                            // relative, of the objective and of the parameters
  double slack = 1e-8;                                // of limits, of their size
  std::function<void(const SearchStep&)> progress{};  // told of each evaluation; may throw to end the search
};

struct Optimum {
  std::vector<std::string> parameters;
  VectorX values;  // of the parameters
  double objective = 0;
  VectorX limited;            // of the quantities with limits, in their order
  double largest_excess = 0;  // over a limit, of its size
  int evaluations = 0;
  bool converged = false;
  std::string message;  // why the search ended
  std::vector<std::string> at_bound;

  double operator()(const Located& parameter) const;
};

/// The parameters between bounds that make a quantity as small as possible while others keep their limits, by
/// sequential quadratic programming (SLSQP: Kraft 1988; NLopt) with the derivatives of gradient(): a local minimum,
/// next to where the search begins. To make a quantity large, let a sensor give its negative; what is no result of a
/// run (a mass, a cost) is a sensor too. Throws SceneError for no parameter, bounds that do not enclose the first
/// value, and whatever gradient() throws.
Optimum minimize(const ParametricScene& scene, const Quantity& objective, const std::vector<FreeParameter>& parameters,
                 const std::vector<Limit>& limits = {}, const MinimizeOptions& options = {});

}  // namespace lithe
