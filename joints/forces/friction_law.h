#pragma once

#include <cmath>

#include "engine/base/checks.h"

namespace lithe {

/// Coefficient of sliding friction over the speed s (m/s), with Stribeck's drop:
///   μ(s) = μ_k + (μ_s - μ_k) exp(-(s / v_s)²)
class StribeckLaw {
 public:
  struct Parameters {
    double coefficient;         // μ_k
    double static_coefficient;  // μ_s; 0: μ_k
    double stribeck_speed;      // v_s, m/s
  };
  /// Throws SceneError naming the parameter that is out of its bounds.
  explicit StribeckLaw(const Parameters& p)
      : kinetic_(p.coefficient),
        drop_(p.static_coefficient == 0 ? 0 : p.static_coefficient - p.coefficient),
        speed_(p.stribeck_speed) {
    require::not_negative(p.coefficient, "coefficient");
    require::not_negative(p.static_coefficient, "static_coefficient");
    require::positive(p.stribeck_speed, "stribeck_speed");
  }

  struct Value {
    double mu, slope;  // dμ/ds, s/m
  };
  Value at(double s) const {
    const double drop = drop_ * std::exp(-std::pow(s / speed_, 2));
    return {kinetic_ + drop, -2 * s / (speed_ * speed_) * drop};
  }

 private:
  double kinetic_, drop_, speed_;
};

/// The same, regularised: μ(s) tanh(3 s / v_c). It reaches 99.5 % of μ_s at the creep speed v_c; below it surfaces
/// creep: they hold no load at rest.
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
      : level_({p.coefficient, p.static_coefficient, p.stribeck_speed}), scale_(p.creep_speed / 3) {
    require::positive(p.creep_speed, "creep_speed");
  }

  using Value = StribeckLaw::Value;
  Value at(double s) const {
    const Value level = level_.at(s);
    const double step = std::tanh(s / scale_), step_slope = (1 - step * step) / scale_;
    return {level.mu * step, level.slope * step + level.mu * step_slope};
  }
  /// μ over a step in which the speed changes, for impulses: that of the mean speed, but creep as at the end, so that
  /// no step turns what stops the other way.
  double over_step(double before, double after) const {
    return level_.at((before + after) / 2).mu * std::tanh(after / scale_);
  }

 private:
  StribeckLaw level_;
  double scale_;  // v_c/3
};

}  // namespace lithe
