#include "joints/hydraulics/oil.h"

#include <algorithm>
#include <cmath>

#include "engine/base/checks.h"

namespace lithe {

void HydraulicOil::check() const {
  require::positive(bulk_modulus, "oil.bulk_modulus");
  require::positive(density, "oil.density");
  require::not_negative(air, "oil.air");
  require::positive(atmosphere, "oil.atmosphere");
  if (air >= 1) throw SceneError("oil.air is " + std::to_string(air), "", "give the part of the volume: 0.005");
  if (!(polytropic > 1)) throw SceneError("oil.polytropic is not above 1", "", "give 1.4 for quick changes");
}

HydraulicOil::At HydraulicOil::at(double p) const {
  const double E = bulk_modulus, squeezed = std::exp(-p / E);
  double v = squeezed, slope = squeezed / E, energy = E * (-std::expm1(-p / E)) - p * squeezed;
  if (air > 0) {
    const double n = polytropic, a = air * std::pow(atmosphere, 1 / n);
    const auto work = [&](double P) {
      return std::pow(P, 1 - 1 / n) / (1 - 1 / n) + n * atmosphere * std::pow(P, -1 / n);
    };
    const double P = std::max(p + atmosphere, 1e3);
    v += a * std::pow(P, -1 / n);
    slope += a / n * std::pow(P, -1 / n - 1);
    energy += a / n * (work(P) - work(atmosphere));
  }
  return {v / slope, energy / v};
}

}  // namespace lithe
