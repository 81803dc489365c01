#include "engine/model/tension_law.h"

#include "engine/base/spline.h"

namespace lithe {

TensionLaw tabulated_spring(std::vector<double> stretch, std::vector<double> force, double damping) {
  return [spline = CubicSpline(std::move(stretch), std::move(force), "tabulated_spring"), damping](double x, double v) {
    const auto at = spline(x);
    return Tension{at.value + damping * v, at.slope, damping, at.integral};
  };
}

}  // namespace lithe
