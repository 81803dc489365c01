#pragma once

#include <functional>
#include <vector>

#include "engine/base/math.h"

namespace lithe {

/// Of a section in steady plane flow, by ½ ρ W² and the chord: lift and drag per length over c, the moment about the
/// aerodynamic centre over c², nose up.
struct AirfoilCoefficients {
  double lift = 0, drag = 0, moment = 0;
};
/// By the angle of attack, -π to π.
using AirfoilLaw = std::function<AirfoilCoefficients(double angle)>;

/// Natural cubic splines through a table of angles (rad) and coefficients; beyond its ends, the values there. No drag
/// or moment: none. Throws SceneError for fewer than two angles, lists of different lengths, angles that do not grow,
/// and a value that is not finite.
AirfoilLaw airfoil_table(const std::vector<double>& angles, const std::vector<double>& lift,
                         std::vector<double> drag = {}, std::vector<double> moment = {});
/// Attached flow: c_l = slope (α - zero_lift), slope 2π of a thin section; constant drag and moment. It does not stall.
AirfoilLaw linear_airfoil(double slope = 2 * M_PI, double zero_lift = 0, double drag = 0, double moment = 0);

/// Velocity of the air (m/s) at a place (m) and time (s), world axes. None: still air.
using WindField = std::function<Vector3(const Vector3& position, double time)>;

}  // namespace lithe
