#include "joints/aerodynamics/separated_lift.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr double kSearched = 0.5, kStep = 1e-3;  // rad
constexpr double kNear = 0.02, kFar = 0.35;      // rad from α₀: where the slope is looked for

/// The zero next to 0 at which the lift rises.
double find_zero_lift(const AirfoilLaw& law) {
  const int steps = static_cast<int>(kSearched / kStep);
  for (int i = 0; i < steps; ++i)
    for (const double side : {1.0, -1.0}) {
      double low = side * i * kStep, high = side * (i + 1) * kStep;
      if (low > high) std::swap(low, high);
      if (!(law(low).lift <= 0 && law(high).lift > 0)) continue;
      while (true) {
        const double middle = 0.5 * (low + high);
        if (middle <= low || middle >= high) return high;
        (law(middle).lift > 0 ? high : low) = middle;
      }
    }
  throw SceneError("its lift does not rise through zero between -0.5 and 0.5 rad", "",
                   "give an airfoil that does; sections of another kind are for add_airfoil_load()");
}

}  // namespace

SeparatedLift::SeparatedLift(const AirfoilLaw& law) : zero_lift_(find_zero_lift(law)) {
  if (std::abs(law(0).lift) == 0) zero_lift_ = 0;
  for (double away = kNear; away <= kFar; away += kStep)
    for (const double side : {1.0, -1.0}) slope_ = std::max(slope_, law(zero_lift_ + side * away).lift / (side * away));
  ratio_at_zero_ = (law(zero_lift_ + kStep).lift - law(zero_lift_ - kStep).lift) / (2 * kStep * slope_);
}

SeparatedLift::At SeparatedLift::at(double angle, double lift) const {
  const double attached = slope_ * (angle - zero_lift_);
  // α₀ is known to round-off alone.
  const double ratio = std::abs(angle - zero_lift_) < 1e-9 ? ratio_at_zero_ : lift / attached;
  if (!(ratio > 0.25)) return {0, attached, lift};
  const double root = std::sqrt(ratio), open = 2 * root - 1;
  // (c_l - attached f) / (1 - f), its factor 1 - root divided out.
  return {open * open, attached, attached * (3 * root - 1) / (4 * root)};
}

}  // namespace lithe
