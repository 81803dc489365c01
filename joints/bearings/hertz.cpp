#include "joints/bearings/hertz.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lithe {

HertzPoint::HertzPoint(double curvature_a, double curvature_b, const BearingMaterial& material) {
  constexpr double pi = std::numbers::pi;
  const double sum = curvature_a + curvature_b;
  const double ratio = std::max(curvature_a, curvature_b) / std::min(curvature_a, curvature_b);
  double K = pi / 2, E = K;  // of a circle
  if (ratio > 1 + 1e-6) {
    // The ratio grows with κ: bisection of log κ.
    double low = 0, high = std::log(1e6);
    for (int i = 0; i < 100; ++i) {
      const double middle = 0.5 * (low + high), kappa = std::exp(middle), k = std::sqrt(1 - 1 / (kappa * kappa));
      K = std::comp_ellint_1(k), E = std::comp_ellint_2(k);
      ellipticity = kappa;
      (kappa * kappa * E - K < ratio * (K - E) ? low : high) = middle;
    }
  }
  const double deflection = 2 * K / pi * std::cbrt(pi / (2 * ellipticity * ellipticity * E));  // δ*
  const double eta = 2 * (1 - material.poissons_ratio * material.poissons_ratio) / material.youngs_modulus;
  stiffness = 2 * sum / (3 * eta) * std::pow(2 / (deflection * sum), 1.5);
}

}  // namespace lithe
