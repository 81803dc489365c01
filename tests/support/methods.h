#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "integrators/ida.h"

/// The integrators that scenes are run with, one line each.
namespace lithe::test {

using Method = std::unique_ptr<Integrator>;

inline Method runge_kutta(double tolerance) {
  return std::make_unique<ExplicitRungeKutta>(
      ExplicitRungeKutta::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
}
inline Method runge_kutta_fixed(double step) {
  return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{.step = step});
}
inline Method ida(double tolerance) {
  return std::make_unique<Ida>(Ida::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
}
inline Method index3(double step, double spectral_radius = 0.9) {
  return std::make_unique<GeneralizedAlpha>(
      GeneralizedAlpha::Parameters{.step = step, .spectral_radius = spectral_radius, .newton_tolerance = 1e-12});
}
inline Method index2(double step, double spectral_radius = 0.9) {
  return std::make_unique<GeneralizedAlpha>(
      GeneralizedAlpha::Parameters{.step = step,
                                   .spectral_radius = spectral_radius,
                                   .form = GeneralizedAlpha::Form::stabilized_index2,
                                   .newton_tolerance = 1e-12});
}

/// A measured figure and the bound it has to keep; LITHE_PRINT=1 shows all of them.
inline void expect_below(const std::string& what, double measured, double bound) {
  static const bool print = std::getenv("LITHE_PRINT") != nullptr;
  if (print)
    std::printf("  %-90s %10.2e  below %8.1e%s\n", what.c_str(), measured, bound, measured < bound ? "" : "  !");
  EXPECT_LT(measured, bound) << what;
}

}  // namespace lithe::test
