#include "engine/base/spline.h"

#include <algorithm>

#include "engine/base/checks.h"

namespace lithe {

CubicSpline::CubicSpline(std::vector<double> x, std::vector<double> y, const std::string& what)
    : x_(std::move(x)), y_(std::move(y)), m_(x_.size(), 0), integral_(x_.size(), 0) {
  const std::size_t n = x_.size();
  if (n < 2 || y_.size() != n)
    throw SceneError("it has " + std::to_string(n) + " abscissae and " + std::to_string(y_.size()) + " values", what,
                     "give two lists of one length, two points at least");
  require::at(what, [&] {
    for (std::size_t i = 0; i < n; ++i) {
      require::finite(x_[i], "point " + std::to_string(i + 1));
      require::finite(y_[i], "value " + std::to_string(i + 1));
      if (i > 0 && !(x_[i] > x_[i - 1]))
        throw SceneError("point " + std::to_string(i + 1) + " (" + std::to_string(x_[i]) + ") does not come after " +
                             std::to_string(x_[i - 1]),
                         what, "sort the points, each once");
    }
  });
  // Tridiagonal system of the second derivatives, zero at both ends.
  std::vector<double> diagonal(n, 1), right(n, 0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double a = x_[i] - x_[i - 1], b = x_[i + 1] - x_[i];
    const double f = i > 1 ? a / diagonal[i - 1] : 0;
    diagonal[i] = 2 * (a + b) - f * (i > 1 ? a : 0);
    right[i] = 6 * ((y_[i + 1] - y_[i]) / b - (y_[i] - y_[i - 1]) / a) - f * right[i - 1];
  }
  for (std::size_t i = n - 1; i-- > 1;) m_[i] = (right[i] - (x_[i + 1] - x_[i]) * m_[i + 1]) / diagonal[i];
  for (std::size_t i = 1; i < n; ++i) {
    const double h = x_[i] - x_[i - 1];
    integral_[i] = integral_[i - 1] + h * (y_[i - 1] + y_[i]) / 2 - h * h * h * (m_[i - 1] + m_[i]) / 24;
  }
}

CubicSpline::Value CubicSpline::operator()(double x) const {
  const std::size_t n = x_.size();
  const auto above = std::upper_bound(x_.begin() + 1, x_.end() - 1, x);
  const std::size_t i = static_cast<std::size_t>(above - x_.begin());  // between points i - 1 and i
  const double h = x_[i] - x_[i - 1], chord = (y_[i] - y_[i - 1]) / h;
  if (x < x_[0] || x > x_[n - 1]) {
    const bool before = x < x_[0];
    const double slope = before ? chord - h * (2 * m_[0] + m_[1]) / 6 : chord + h * (m_[n - 2] + 2 * m_[n - 1]) / 6;
    const double from = before ? x_[0] : x_[n - 1], y = before ? y_[0] : y_[n - 1], d = x - from;
    return {y + slope * d, slope, 0, (before ? 0 : integral_[n - 1]) + d * (y + slope * d / 2)};
  }
  const double p = x_[i] - x, q = x - x_[i - 1], M = m_[i - 1], N = m_[i];
  const double value =
      (M * p * p * p + N * q * q * q) / (6 * h) + (y_[i - 1] / h - M * h / 6) * p + (y_[i] / h - N * h / 6) * q;
  const double integral = integral_[i - 1] + (M * (h * h * h * h - p * p * p * p) + N * q * q * q * q) / (24 * h) +
                          (y_[i - 1] / h - M * h / 6) * (h * h - p * p) / 2 + (y_[i] / h - N * h / 6) * q * q / 2;
  return {value, (N * q * q - M * p * p) / (2 * h) + chord + h * (M - N) / 6, (M * p + N * q) / h, integral};
}

}  // namespace lithe
