#include "tools/stability/methods/ordinary.h"

#include <algorithm>
#include <cmath>

namespace lithe::lab {
namespace {

double root_mean_square(const VectorX& x) { return x.norm() / std::sqrt(static_cast<double>(x.size())); }

/// Error over allowance of the step with the stages K.
double error_ratio(const RungeKuttaTableau& tableau, const MatrixX& K, const VectorX& scale, double h) {
  const Eigen::Map<const VectorX> e(tableau.error.data(), tableau.stages);
  const Eigen::Map<const VectorX> second(tableau.second_error.data(), tableau.stages);
  const VectorX first = (K * e).cwiseQuotient(scale);
  if (second.squaredNorm() == 0) return h * root_mean_square(first);
  const double squared = first.squaredNorm();
  const double both = squared + 0.01 * (K * second).cwiseQuotient(scale).squaredNorm();
  return both == 0 ? 0 : h * squared / std::sqrt(both * static_cast<double>(scale.size()));
}

}  // namespace

VectorX midpoint_step(const Rates& f, double t, const VectorX& y, double h) {
  VectorX middle = y + h / 2 * f(t, y);
  const double enough = 1e-13 * std::max(1.0, y.cwiseAbs().maxCoeff());
  for (int k = 0; k < 60; ++k) {
    const VectorX next = y + h / 2 * f(t + h / 2, middle);
    const double change = (next - middle).cwiseAbs().maxCoeff();
    middle = next;
    if (change < enough) break;
  }
  return 2 * middle - y;
}

AdaptiveRun run_as_scipy(const RungeKuttaTableau& tableau, const Rates& f, double begin, double end, VectorX y,
                         double relative, double absolute, long max_evaluations) {
  AdaptiveRun run;
  // The estimate's order: 4 of 5(4), 7 of 8(5,3).
  const double order = tableau.order - 1, exponent = -1 / (order + 1);
  double t = begin;
  VectorX rate = f(t, y);
  double h;
  {
    const VectorX scale = (relative * y.cwiseAbs()).array() + absolute;
    const double d0 = root_mean_square(y.cwiseQuotient(scale)), d1 = root_mean_square(rate.cwiseQuotient(scale));
    const double h0 = d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : 0.01 * d0 / d1;
    const VectorX change = f(t + h0, y + h0 * rate) - rate;
    const double d2 = root_mean_square(change.cwiseQuotient(scale)) / h0;
    const double h1 =
        d1 <= 1e-15 && d2 <= 1e-15 ? std::max(1e-6, 1e-3 * h0) : std::pow(0.01 / std::max(d1, d2), -exponent);
    h = std::min({100 * h0, h1, end - begin});
  }
  run.evaluations = 2;
  MatrixX K(y.size(), tableau.stages);
  bool rejected = false;
  while (t < end && run.evaluations < max_evaluations) {
    const double least = 10 * (std::nextafter(t, INFINITY) - t);
    if (rejected && h < least) return run;
    const double t_new = std::min(t + std::max(h, least), end);
    h = t_new - t;
    K.col(0) = rate;
    VectorX y_new = y;
    for (int i = 1; i < tableau.stages; ++i) {
      const Eigen::Map<const VectorX> a(tableau.a[i].data(), i);
      y_new = y + h * (K.leftCols(i) * a);
      K.col(i) = f(t + tableau.time[i] * h, y_new);
    }
    run.evaluations += tableau.stages - 1;
    const VectorX scale = (relative * y.cwiseAbs().cwiseMax(y_new.cwiseAbs())).array() + absolute;
    const double ratio = error_ratio(tableau, K, scale, h);
    if (ratio < 1) {
      const double grown = ratio == 0 ? 10 : std::min(10.0, 0.9 * std::pow(ratio, exponent));
      run.smallest_step = std::min(run.smallest_step, h);
      h *= rejected ? std::min(1.0, grown) : grown;
      t = t_new, y = y_new, rate = K.col(tableau.stages - 1);
      rejected = false;
    } else {
      h *= std::isnan(ratio) ? 0.2 : std::max(0.2, 0.9 * std::pow(ratio, exponent));
      rejected = true;
    }
  }
  run.y = y;
  run.reached = t >= end;
  return run;
}

}  // namespace lithe::lab
