#pragma once

#include <functional>
#include <vector>

namespace lithe {

/// A prescribed quantity at one time: value, first and second derivative.
struct Motion {
  double value = 0, rate = 0, acceleration = 0;
};
/// Motion as a function of time; the derivatives must be those of the value.
using MotionLaw = std::function<Motion(double time)>;

MotionLaw constant(double value);
/// start + rate t
MotionLaw ramp(double start, double rate);
/// offset + amplitude sin(angular_frequency t + phase)
MotionLaw harmonic(double amplitude, double angular_frequency, double phase = 0, double offset = 0);
/// From one value to another between two times, at rest before and after: 10 s³ - 15 s⁴ + 6 s⁵, whose acceleration is
/// continuous. Throws SceneError for an end not after the begin.
MotionLaw smooth_step(double from, double to, double begin, double end);
/// The same at one time, unchecked.
Motion smooth_step_at(double from, double to, double begin, double end, double time);
/// A turn whose rate goes from zero to `rate` as smooth_step does, then stays: a drive that runs up. It starts from 0, and
/// is rate (end - begin) / 2 at its end. Throws like smooth_step.
MotionLaw run_up(double rate, double begin, double end);
/// Natural cubic spline through a table; beyond it a straight line. Throws SceneError for fewer than two points, lists
/// of different lengths, times that do not grow, and a value that is not finite.
MotionLaw tabulated(std::vector<double> times, std::vector<double> values);
/// Sum of two motions.
MotionLaw operator+(MotionLaw a, MotionLaw b);

}  // namespace lithe
