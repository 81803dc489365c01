#pragma once

#include <memory>

#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"

/// The library's own methods with their defaults, but for the step or the tolerance.
namespace lithe::lab {

using Method = std::unique_ptr<Integrator>;

inline Method runge_kutta(double tolerance) {
  return std::make_unique<ExplicitRungeKutta>(
      ExplicitRungeKutta::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
}
inline Method runge_kutta_step(double step) {
  return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{.step = step});
}
inline Method alpha_index3(double step) {
  return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = step});
}
inline Method alpha_index2(double step) {
  return std::make_unique<GeneralizedAlpha>(
      GeneralizedAlpha::Parameters{.step = step, .form = GeneralizedAlpha::Form::stabilized_index2});
}

}  // namespace lithe::lab
