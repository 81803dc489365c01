#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace lithe::lab {

/// Extrapolation of the explicit midpoint rule in numbers of 80 bits (Gragg, Bulirsch & Stoer; Hairer, Nørsett & Wanner
/// I, II.9), columns fixed: order 2 `columns`; ẏ = f(t, y) for n components. f is never asked at a step's end: a kink
/// between the last inner point and there is not seen by the error estimate.
template <int n>
class Extrapolation {
 public:
  using Number = long double;
  using Vector = std::array<Number, n>;
  struct Parameters {
    int columns = 9;
    double tolerance = 1e-16;   // of the largest component's difference of the last two columns, over `scale`
                                // and over y
    double longest = INFINITY;  // s
    std::array<double, n> scale;
  };
  explicit Extrapolation(Parameters parameters) : parameters_(parameters) {}

  /// Moves y from `begin` to `end`, s. False where the step falls below the spacing of numbers.
  template <class Rates>
  bool run(const Rates& f, Number begin, Number end, Vector& y) {
    Number t = begin;
    if (h_ == 0) h_ = 1e-3L * (end - begin);
    while (t < end) {
      Number h = std::min({h_, static_cast<Number>(parameters_.longest), end - t});
      for (;; h *= 0.3L) {
        if (t + h == t) return false;
        if (const Number error = step(f, t, h, y); error <= 1) {
          const Number wished = error == 0 ? 3 : 0.9L * std::pow(error, -1.0L / (2 * parameters_.columns - 1));
          h_ = h * std::min(3.0L, wished);
          y = best_;
          break;
        }
      }
      t = end - t <= h * (1 + 1e-12L) ? end : t + h;
    }
    return true;
  }

 private:
  /// The step's result in best_; the error over the tolerance.
  template <class Rates>
  Number step(const Rates& f, Number t, Number h, const Vector& y) {
    std::vector<Vector> row, last;
    Number error = INFINITY;
    const Vector rate = f(t, y);
    for (int j = 1; j <= parameters_.columns; ++j) {
      const int parts = 2 * j;
      const Number part = h / parts;
      Vector before = y, now = y;
      for (int i = 0; i < n; ++i) now[i] += part * rate[i];
      for (int k = 1; k < parts; ++k) {
        const Vector slope = f(t + k * part, now);
        for (int i = 0; i < n; ++i) {
          const Number next = before[i] + 2 * part * slope[i];
          before[i] = now[i], now[i] = next;
        }
      }
      row.assign(1, now);
      for (int m = 1; m < j; ++m) {
        const Number ratio = static_cast<Number>(j) / (j - m), weight = ratio * ratio - 1;
        Vector finer = row[m - 1];
        for (int i = 0; i < n; ++i) finer[i] += (row[m - 1][i] - last[m - 1][i]) / weight;
        row.push_back(finer);
      }
      if (j > 1) {
        error = 0;
        for (int i = 0; i < n; ++i)
          error = std::max(
              error, std::abs(row[j - 1][i] - row[j - 2][i]) / std::max<Number>(parameters_.scale[i], std::abs(y[i])));
        if (!(error < std::numeric_limits<Number>::max())) return INFINITY;
      }
      last = row;
    }
    best_ = row.back();
    return error / parameters_.tolerance;
  }

  Parameters parameters_;
  Number h_ = 0;
  Vector best_{};
};

}  // namespace lithe::lab
