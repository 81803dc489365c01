#include "integrators/catalogue.h"

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

namespace lithe {
namespace {

/// A method whose parameters have a tolerance, for a number.
template <class Method>
StudyMethod by_tolerance(const std::string& name, typename Method::Parameters parameters = {}) {
  return {name, StudyMethod::Setting::tolerance, [parameters](double tolerance) -> std::unique_ptr<Integrator> {
            auto chosen = parameters;
            chosen.tolerance = {.relative = tolerance, .absolute = tolerance};
            return std::make_unique<Method>(chosen);
          }};
}

/// A method whose parameters have a step, for seconds.
template <class Method>
StudyMethod by_step(const std::string& name, typename Method::Parameters parameters = {}) {
  return {name, StudyMethod::Setting::step, [parameters](double step) -> std::unique_ptr<Integrator> {
            auto chosen = parameters;
            chosen.step = step;
            return std::make_unique<Method>(chosen);
          }};
}

constexpr auto kOrder8 = ExplicitRungeKutta::Method::dormand_prince8;
constexpr auto kIndex2 = GeneralizedAlpha::Form::stabilized_index2;

}  // namespace

std::vector<StudyMethod> standard_methods() {
  return {
      by_tolerance<Automatic>("automatic"),
      by_tolerance<ExplicitRungeKutta>("explicit Runge-Kutta 5(4)"),
      by_tolerance<ExplicitRungeKutta>("explicit Runge-Kutta 8(5,3)", {.method = kOrder8}),
      by_tolerance<Adams>("Adams"),
      by_tolerance<Radau>("Radau IIA 5"),
      by_tolerance<LieBdf>("Lie-group BDF"),
      by_tolerance<Ida>("SUNDIALS IDA"),
      by_tolerance<GeneralizedAlpha>("generalized-alpha index 2", {.form = kIndex2}),
      by_step<GeneralizedAlpha>("generalized-alpha index 3, fixed step"),
      by_step<GeneralizedAlpha>("generalized-alpha index 2, fixed step", {.form = kIndex2}),
      by_step<Hht>("HHT-I3, fixed step"),
      by_step<Rattle>("RATTLE"),
      by_step<EnergyMomentum>("energy-momentum midpoint"),
      by_step<LinearlyImplicit>("linearly implicit Euler"),
      by_step<LinearlyImplicit>("linearly implicit Euler, extrapolated", {.order = 2}),
  };
}

std::vector<StudyMethod> reference_methods() {
  return {by_tolerance<ExplicitRungeKutta>("explicit Runge-Kutta 8(5,3)", {.method = kOrder8}),
          by_tolerance<Radau>("Radau IIA 5")};
}

}  // namespace lithe
