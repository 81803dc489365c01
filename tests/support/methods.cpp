#include "tests/support/methods.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

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

namespace lithe::test {

Method runge_kutta(double tolerance) {
  return std::make_unique<ExplicitRungeKutta>(
      ExplicitRungeKutta::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
}
Method runge_kutta_fixed(double step) {
  return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{.step = step});
}
Method runge_kutta8(double tolerance) {
  return std::make_unique<ExplicitRungeKutta>(
      ExplicitRungeKutta::Parameters{.method = ExplicitRungeKutta::Method::dormand_prince8,
                                     .tolerance = {.relative = tolerance, .absolute = tolerance}});
}
Method runge_kutta8_fixed(double step) {
  return std::make_unique<ExplicitRungeKutta>(
      ExplicitRungeKutta::Parameters{.method = ExplicitRungeKutta::Method::dormand_prince8, .step = step});
}
Method adams(double tolerance) {
  return std::make_unique<Adams>(Adams::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
}
Method automatic(double tolerance) {
  return std::make_unique<Automatic>(
      Automatic::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
}
Method ida(double tolerance) {
  return std::make_unique<Ida>(Ida::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
}
Method index3(double step, double spectral_radius) {
  return std::make_unique<GeneralizedAlpha>(
      GeneralizedAlpha::Parameters{.step = step, .spectral_radius = spectral_radius, .newton_tolerance = 1e-12});
}
Method index2(double step, double spectral_radius) {
  return std::make_unique<GeneralizedAlpha>(
      GeneralizedAlpha::Parameters{.step = step,
                                   .spectral_radius = spectral_radius,
                                   .form = GeneralizedAlpha::Form::stabilized_index2,
                                   .newton_tolerance = 1e-12});
}
Method rattle(double step) { return std::make_unique<Rattle>(Rattle::Parameters{.step = step}); }
Method radau(double tolerance) {
  return std::make_unique<Radau>(Radau::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
}
Method radau_fixed(double step) {
  return std::make_unique<Radau>(Radau::Parameters{.step = step, .newton_tolerance = 1e-14});
}
Method bdf(double tolerance, int max_order) {
  return std::make_unique<LieBdf>(
      LieBdf::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}, .max_order = max_order});
}
Method bdf_fixed(double step, int order) {
  return std::make_unique<LieBdf>(
      LieBdf::Parameters{.step = step, .tolerance = {.relative = 1e-12, .absolute = 1e-12}, .max_order = order});
}
Method hht(double step, double alpha) {
  return std::make_unique<Hht>(Hht::Parameters{.step = step, .alpha = alpha, .newton_tolerance = 1e-12});
}
Method linearly_implicit(double step, int order) {
  return std::make_unique<LinearlyImplicit>(LinearlyImplicit::Parameters{.step = step, .order = order});
}
Method energy_momentum(double step) {
  return std::make_unique<EnergyMomentum>(EnergyMomentum::Parameters{.step = step});
}

void expect_below(const std::string& what, double measured, double bound) {
  static const bool print = std::getenv("LITHE_PRINT") != nullptr;
  if (print)
    std::printf("  %-90s %10.2e  below %8.1e%s\n", what.c_str(), measured, bound, measured < bound ? "" : "  !");
  EXPECT_LT(measured, bound) << what;
}

}  // namespace lithe::test
