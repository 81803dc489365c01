#pragma once

#include <functional>
#include <string>

#include "tests/integrators/conserving_scenes.h"
#include "tests/support/methods.h"

/// Orders of convergence on the pendulum of 1 m released horizontally, whose motion is known.
namespace lithe::test {

inline constexpr double kPendulumPeriod = 2.36784194757623744930;  // of the pendulum released horizontally

/// Angle of that pendulum from the downward vertical (Jacobi functions by descending Landen steps).
double pendulum_angle(double t);

/// How often the errors halve when steps do.
Errors order(const Errors& coarse, const Errors& fine);

/// Largest errors of the pendulum over one second and a half, at the ends of all steps.
Errors pendulum_errors(Method method, const std::function<double(int)>& step_end);

void expect_order(const std::string& what, const Errors& measured, double expected, double tolerance);

}  // namespace lithe::test
