#pragma once

#include <functional>

namespace lithe {

/// A prescribed quantity at one time: value, first and second derivative.
struct Motion {
  double value = 0, rate = 0, acceleration = 0;
};
/// Motion as a function of time; the derivatives must be those of the value.
using MotionLaw = std::function<Motion(double time)>;

}  // namespace lithe
