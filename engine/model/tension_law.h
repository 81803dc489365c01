#pragma once

#include <functional>
#include <vector>

namespace lithe {

/// Force of a spring at one stretch and speed: the tension σ that pulls back, ∂σ/∂stretch, ∂σ/∂speed, stored energy.
struct Tension {
  double force = 0, stiffness = 0, damping = 0, energy = 0;
};
/// A spring's law; stretch in m or rad, from the natural length on, speed its rate. Newton's method uses the
/// derivatives.
using TensionLaw = std::function<Tension(double stretch, double speed)>;

/// Natural cubic spline through a table of tension over stretch, and a linear damper; its energy counts from the first
/// point. Throws SceneError as engine/base/spline.h says.
TensionLaw tabulated_spring(std::vector<double> stretch, std::vector<double> force, double damping = 0);

}  // namespace lithe
