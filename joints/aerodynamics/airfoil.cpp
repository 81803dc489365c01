#include "joints/aerodynamics/airfoil.h"

#include <algorithm>

#include "engine/base/checks.h"
#include "engine/base/spline.h"

namespace lithe {

AirfoilLaw airfoil_table(const std::vector<double>& angles, const std::vector<double>& lift, std::vector<double> drag,
                         std::vector<double> moment) {
  if (drag.empty()) drag.assign(angles.size(), 0);
  if (moment.empty()) moment.assign(angles.size(), 0);
  return [first = angles.empty() ? 0 : angles.front(), last = angles.empty() ? 0 : angles.back(),
          c_l = CubicSpline(angles, lift, "the lift of an airfoil"),
          c_d = CubicSpline(angles, std::move(drag), "the drag of an airfoil"),
          c_m = CubicSpline(angles, std::move(moment), "the moment of an airfoil")](double angle) {
    const double at = std::clamp(angle, first, last);
    return AirfoilCoefficients{c_l(at).value, c_d(at).value, c_m(at).value};
  };
}

AirfoilLaw linear_airfoil(double slope, double zero_lift, double drag, double moment) {
  require::finite(slope, "the lift slope of an airfoil");
  require::finite(zero_lift, "the zero-lift angle of an airfoil");
  require::finite(drag, "the drag of an airfoil");
  require::finite(moment, "the moment of an airfoil");
  return [=](double angle) { return AirfoilCoefficients{slope * (angle - zero_lift), drag, moment}; };
}

}  // namespace lithe
