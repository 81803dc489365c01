#pragma once

#include <cmath>

#include "engine/base/checks.h"

namespace lithe {

/// Coefficient of dry friction over the sliding speed s (m/s), regularised, with Stribeck's drop:
///   μ(s) = (μ_k + (μ_s - μ_k) exp(-(s / v_s)²)) tanh(3 s / v_c)
/// It reaches 99.5 % of μ_s at the creep speed v_c; below it surfaces creep: they hold no load at rest.
class FrictionLaw {
 public:
  struct Parameters {
    double coefficient;         // μ_k
    double static_coefficient;  // μ_s; 0: μ_k
    double stribeck_speed;      // v_s, m/s
    double creep_speed;         // v_c, m/s
  };
  /// Throws SceneError naming the parameter that is out of its bounds.
  explicit FrictionLaw(const Parameters& p)
      : kinetic_(p.coefficient),
        drop_(p.static_coefficient == 0 ? 0 : p.static_coefficient - p.coefficient),
        stribeck_speed_(p.stribeck_speed),
        scale_(p.creep_speed / 3) {
    require::not_negative(p.coefficient, "coefficient");
    require::not_negative(p.static_coefficient, "static_coefficient");
    require::positive(p.stribeck_speed, "stribeck_speed");
    require::positive(p.creep_speed, "creep_speed");
  }

  struct Value {
    double mu, slope;  // dμ/ds, s/m
  };
  Value at(double s) const {
    const double drop = drop_ * std::exp(-std::pow(s / stribeck_speed_, 2));
    const double level = kinetic_ + drop, level_slope = -2 * s / (stribeck_speed_ * stribeck_speed_) * drop;
    const double step = std::tanh(s / scale_), step_slope = (1 - step * step) / scale_;
    return {level * step, level_slope * step + level * step_slope};
  }

 private:
  double kinetic_, drop_, stribeck_speed_, scale_;  // scale_: v_c/3
};

}  // namespace lithe
