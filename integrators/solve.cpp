#include "integrators/solve.h"

#include "integrators/automatic.h"
#include "integrators/generalized_alpha.h"
#include "integrators/nonsmooth_generalized_alpha.h"

namespace lithe {

Solution solve(SystemGraph& graph, double duration, const std::vector<Want>& wants, const SolveOptions& options) {
  return solve(graph, duration, wants,
               {.by_tolerance =
                    [](const Tolerance& tolerance) {
                      return std::make_unique<Automatic>(Automatic::Parameters{.tolerance = tolerance});
                    },
                .by_step =
                    [](double step) {
                      return std::make_unique<GeneralizedAlpha>(
                          GeneralizedAlpha::Parameters{.step = step, .spectral_radius = 0.8});
                    },
                .by_step_with_impacts =
                    [](double step) {
                      return std::make_unique<NonsmoothGeneralizedAlpha>(
                          NonsmoothGeneralizedAlpha::Parameters{.step = step, .spectral_radius = 0.8});
                    }},
               options);
}

}  // namespace lithe
