#pragma once

#include <cmath>

namespace lithe {

/// A viscous force that is at most as large as the elastic one beside it, so that their sum never turns its sign and
/// sets in without a jump:  D = F_e tanh(c ẋ/F_e), which is c ẋ where that is small.
struct LimitedDamping {
  double force = 0, damping = 0;  // D; ∂D/∂ẋ
  double by_elastic = 1;          // 1 + ∂D/∂F_e

  LimitedDamping(double c, double speed, double elastic) {
    if (!(elastic > 0)) return;
    const double x = c * speed / elastic, limited = std::tanh(x), slope = 1 - limited * limited;
    force = elastic * limited, damping = c * slope, by_elastic = 1 + limited - x * slope;
  }
};

}  // namespace lithe
