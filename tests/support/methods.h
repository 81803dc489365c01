#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "integrators/adams.h"
#include "integrators/automatic.h"
#include "integrators/energy_momentum.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "integrators/hht.h"
#include "integrators/ida.h"
#include "integrators/lie_bdf.h"
#include "integrators/linearly_implicit.h"
#include "integrators/radau.h"
#include "integrators/rattle.h"

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
inline Method runge_kutta8(double tolerance) {
  return std::make_unique<ExplicitRungeKutta>(
      ExplicitRungeKutta::Parameters{.method = ExplicitRungeKutta::Method::dormand_prince8,
                                     .tolerance = {.relative = tolerance, .absolute = tolerance}});
}
inline Method runge_kutta8_fixed(double step) {
  return std::make_unique<ExplicitRungeKutta>(
      ExplicitRungeKutta::Parameters{.method = ExplicitRungeKutta::Method::dormand_prince8, .step = step});
}
inline Method adams(double tolerance) {
  return std::make_unique<Adams>(Adams::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
}
inline Method automatic(double tolerance) {
  return std::make_unique<Automatic>(
      Automatic::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
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
inline Method rattle(double step) { return std::make_unique<Rattle>(Rattle::Parameters{.step = step}); }
inline Method radau(double tolerance) {
  return std::make_unique<Radau>(Radau::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
}
inline Method radau_fixed(double step) {
  return std::make_unique<Radau>(Radau::Parameters{.step = step, .newton_tolerance = 1e-14});
}

inline Method bdf(double tolerance, int max_order = 5) {
  return std::make_unique<LieBdf>(
      LieBdf::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}, .max_order = max_order});
}
inline Method bdf_fixed(double step, int order) {
  return std::make_unique<LieBdf>(
      LieBdf::Parameters{.step = step, .tolerance = {.relative = 1e-12, .absolute = 1e-12}, .max_order = order});
}
inline Method hht(double step, double alpha = -0.1) {
  return std::make_unique<Hht>(Hht::Parameters{.step = step, .alpha = alpha, .newton_tolerance = 1e-12});
}
inline Method linearly_implicit(double step, int order = 1) {
  return std::make_unique<LinearlyImplicit>(LinearlyImplicit::Parameters{.step = step, .order = order});
}
inline Method energy_momentum(double step) {
  return std::make_unique<EnergyMomentum>(EnergyMomentum::Parameters{.step = step});
}

/// A measured figure and the bound it has to keep; LITHE_PRINT=1 shows all of them.
inline void expect_below(const std::string& what, double measured, double bound) {
  static const bool print = std::getenv("LITHE_PRINT") != nullptr;
  if (print)
    std::printf("  %-90s %10.2e  below %8.1e%s\n", what.c_str(), measured, bound, measured < bound ? "" : "  !");
  EXPECT_LT(measured, bound) << what;
}

}  // namespace lithe::test
