#pragma once

#include <string>
#include <vector>

namespace lithe {

/// Natural cubic spline through points; beyond them a straight line with the slope of the end.
class CubicSpline {
 public:
  /// `what` is named in errors. Throws SceneError for fewer than two points, lists of different lengths, x that do not
  /// grow, and a value that is not finite.
  CubicSpline(std::vector<double> x, std::vector<double> y, const std::string& what);

  struct Value {
    double value, slope, curvature;
    double integral;  // from the first point
  };
  Value operator()(double x) const;

 private:
  std::vector<double> x_, y_, m_;  // m: second derivatives
  std::vector<double> integral_;   // up to each point
};

}  // namespace lithe
