#include "integrators/hht.h"

#include "engine/base/error.h"

namespace lithe {
namespace {

GeneralizedAlpha::Coefficients coefficients(double alpha) {
  if (!(alpha >= -1.0 / 3 - 1e-12 && alpha <= 0))
    throw SceneError("alpha is " + std::to_string(alpha), "Hht",
                     "give -1/3 <= alpha <= 0; -0.05 keeps energy well, -0.3 damps most, 0 lets multipliers oscillate");
  return {0, -alpha};
}

}  // namespace

Hht::Hht(Parameters parameters)
    : method_({.step = parameters.step,
               .tolerance = parameters.tolerance,
               .first_step = parameters.first_step,
               .max_step = parameters.max_step,
               .newton_tolerance = parameters.newton_tolerance},
              coefficients(parameters.alpha)) {}

}  // namespace lithe
