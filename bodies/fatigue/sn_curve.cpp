#include "bodies/fatigue/sn_curve.h"

#include <limits>

#include "engine/base/checks.h"
#include "engine/base/number_text.h"

namespace lithe {

void SnCurve::check() const {
  require::positive(range, "range of the S-N curve");
  require::positive(cycles, "cycles of the S-N curve");
  require::positive(exponent, "exponent of the S-N curve");
  require::not_negative(exponent_below, "exponent_below of the S-N curve");
  require::not_negative(cut_off, "cut_off of the S-N curve");
  require::not_negative(tensile_strength, "tensile_strength of the S-N curve");
}

double SnCurve::endured(double stress_range) const {
  if (stress_range < cut_off || stress_range <= 0) return std::numeric_limits<double>::infinity();
  const bool below = stress_range < range && exponent_below > 0;
  return cycles * std::pow(range / stress_range, below ? exponent_below : exponent);
}

double SnCurve::damage(const LoadCycle& cycle) const {
  double effective = cycle.range;
  if (tensile_strength > 0) {
    const double highest = cycle.mean + 0.5 * cycle.range;
    if (highest >= tensile_strength)
      throw SceneError("a cycle reaches " + number_text(highest) + " Pa, the tensile strength is " +
                           number_text(tensile_strength) + " Pa",
                       "", "it breaks at once: make the part stronger, or leave a place of singular stress out");
    if (cycle.mean > 0) effective /= 1 - cycle.mean / tensile_strength;
  }
  return cycle.count / endured(effective);
}

double miner_sum(std::span<const LoadCycle> cycles, const SnCurve& curve) {
  curve.check();
  double sum = 0;
  for (const LoadCycle& cycle : cycles) sum += curve.damage(cycle);
  return sum;
}

}  // namespace lithe
