#include "engine/model/motion_law.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/spline.h"

namespace lithe {

MotionLaw constant(double value) {
  return [=](double) { return Motion{value, 0, 0}; };
}

MotionLaw ramp(double start, double rate) {
  return [=](double t) { return Motion{start + rate * t, rate, 0}; };
}

MotionLaw harmonic(double amplitude, double angular_frequency, double phase, double offset) {
  return [=](double t) {
    const double w = angular_frequency, s = amplitude * std::sin(w * t + phase);
    return Motion{offset + s, amplitude * w * std::cos(w * t + phase), -w * w * s};
  };
}

namespace {

void check_end(const char* law, double begin, double end) {
  if (!(end > begin))
    throw SceneError(std::string(law) + " begins at " + std::to_string(begin) + " and ends at " + std::to_string(end),
                     law, "give an end after the begin, s");
}

}  // namespace

MotionLaw smooth_step(double from, double to, double begin, double end) {
  check_end("smooth_step", begin, end);
  return [=](double t) { return smooth_step_at(from, to, begin, end, t); };
}

Motion smooth_step_at(double from, double to, double begin, double end, double time) {
  const double T = end - begin, s = std::clamp((time - begin) / T, 0.0, 1.0), rise = to - from;
  return {from + rise * s * s * s * (10 + s * (6 * s - 15)), rise * 30 * s * s * (1 - s) * (1 - s) / T,
          rise * 60 * s * (1 - s) * (1 - 2 * s) / (T * T)};
}

MotionLaw run_up(double rate, double begin, double end) {
  check_end("run_up", begin, end);
  return [=](double t) {
    const Motion speed = smooth_step_at(0, rate, begin, end, t);
    const double T = end - begin, s = std::clamp((t - begin) / T, 0.0, 1.0);
    const double turn = rate * T * s * s * s * s * (2.5 + s * (s - 3)) + rate * std::max(0.0, t - end);
    return Motion{turn, speed.value, speed.rate};
  };
}

MotionLaw tabulated(std::vector<double> times, std::vector<double> values) {
  return [spline = CubicSpline(std::move(times), std::move(values), "tabulated")](double t) {
    const auto at = spline(t);
    return Motion{at.value, at.slope, at.curvature};
  };
}

MotionLaw operator+(MotionLaw a, MotionLaw b) {
  return [a = std::move(a), b = std::move(b)](double t) {
    const Motion x = a(t), y = b(t);
    return Motion{x.value + y.value, x.rate + y.rate, x.acceleration + y.acceleration};
  };
}

}  // namespace lithe
