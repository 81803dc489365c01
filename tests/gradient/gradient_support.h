#pragma once

#include <gtest/gtest.h>

#include <functional>

#include "engine/gradient/gradient.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"

namespace lithe::test {

/// Generalized-alpha that solves its steps to round-off, so that differences of runs are as good as they can be.
inline MakeIntegrator exact_alpha(double step) {
  return [step] {
    return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = step, .newton_tolerance = 1e-13});
  };
}

/// The gradient of a scene against differences of its runs, extrapolated (Richardson), relative to the largest
/// derivative of the quantity in units of the parameters' values; in tangent and in adjoint mode.
void expect_gradient(const ParametricScene& scene, const std::vector<Quantity>& quantities,
                     const std::vector<DesignParameter>& parameters, double tolerance = 1e-8, bool has_adjoint = true);

/// The same against differences of fourth order of runs so near that they have the same contacts, which stick and slide
/// alike; with the mode that gradient() chooses and, where there is one, the adjoint.
void expect_of_near_runs(const ParametricScene& scene, const std::vector<Quantity>& quantities,
                         const std::vector<DesignParameter>& parameters, double tolerance = 1e-8,
                         bool has_adjoint = true);

/// Two gradients by the same parameters, likewise relative.
void expect_close(const Gradient& found, const Gradient& expected, const std::vector<DesignParameter>& parameters,
                  double tolerance = 1e-8);

/// What gradient() reads at the end of its run is, to the bit, what these columns of the scene's sensors read at the
/// end of the run alone.
void expect_bits_of_the_run(const ParametricScene& scene, const std::vector<DesignParameter>& parameters,
                            const std::vector<std::string>& columns);

}  // namespace lithe::test
