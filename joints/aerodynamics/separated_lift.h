#pragma once

#include "joints/aerodynamics/airfoil.h"

namespace lithe {

/// A section's steady lift taken apart at the point f of the chord, from its leading edge, where the flow leaves the
/// upper side (Kirchhoff's flow about a flat plate):
///   c_l = c_l' (α - α₀) f + c_s (1 - f),   f = (2 √(c_l / (c_l' (α - α₀))) - 1)²,   0 where the root is below ½
/// c_s: the lift of the flow that is separated everywhere. α₀ and c_l' are found in the law: its zero next to α = 0,
/// and the largest c_l / (α - α₀) within 0.35 rad of it, so that f is at most 1.
class SeparatedLift {
 public:
  struct At {
    double point;                // f
    double attached, separated;  // c_l' (α - α₀); c_s
  };

  /// Throws SceneError for a lift that does not rise through zero between -0.5 and 0.5 rad.
  explicit SeparatedLift(const AirfoilLaw& law);

  double zero_lift() const { return zero_lift_; }  // α₀, rad
  double slope() const { return slope_; }          // c_l', 1/rad
  /// `lift`: the law's there.
  At at(double angle, double lift) const;

 private:
  double zero_lift_ = 0, slope_ = 0, ratio_at_zero_ = 1;  // ratio: of c_l and c_l' (α - α₀)
};

}  // namespace lithe
