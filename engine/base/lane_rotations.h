#pragma once

#include "engine/base/lanes.h"

/// The formulas of rotations of math.h in registers of four: quaternions as (w, x, y, z), one register.
namespace lithe::lanes {

/// rotation_matrix(e).
inline Columns rotation_columns(const double* e) {
  const double w = e[0], x = e[1], y = e[2], z = e[3];
  const double x2 = x + x, y2 = y + y, z2 = z + z;
  return {{of(1 - (y * y2 + z * z2), x * y2 + w * z2, x * z2 - w * y2),
           of(x * y2 - w * z2, 1 - (x * x2 + z * z2), y * z2 + w * x2),
           of(x * z2 + w * y2, y * z2 - w * x2, 1 - (x * x2 + y * y2))}};
}

/// rotated(e, psi).
inline Lanes rotated(const Lanes& e, const Lanes& psi) {
  double c, s;  // cos(|psi|/2), sin(|psi|/2)/|psi|
  half_angle(0.25 * dot(psi, psi), c, s);
  // (e_0 + e) ∘ (c + s psi), a sum of four products with the components of the turn
  const Lanes turn = s * psi;
  const Lanes product = e * c + __builtin_shufflevector(e, e, 1, 0, 3, 2) * (turn[0] * Lanes{-1, 1, 1, -1}) +
                        __builtin_shufflevector(e, e, 2, 3, 0, 1) * (turn[1] * Lanes{-1, -1, 1, 1}) +
                        __builtin_shufflevector(e, e, 3, 2, 1, 0) * (turn[2] * Lanes{-1, 1, -1, 1});
  const Lanes squares = product * product;
  const double norm = (squares[0] + squares[1]) + (squares[2] + squares[3]);
  return product * (1.5 - 0.5 * norm);  // one Newton step of 1/sqrt
}

/// chart_rate(psi, omega).
inline Lanes chart_rate(const Lanes& psi, const Lanes& omega) {
  const Lanes c = cross(psi, omega);
  return omega + 0.5 * c + chart_coefficient(dot(psi, psi)) * cross(psi, c);
}

/// K Jr⁻¹(psi):  Jr⁻¹ = E + ½ psi~ + k (psi psiᵀ - psi² E).
inline Columns times_chart(const Columns& K, const Lanes& psi) {
  const double t = dot(psi, psi), k = chart_coefficient(t);
  return K * (dyad(k * psi, psi) + skewed(0.5 * psi) + scalar(1 - k * t));
}

}  // namespace lithe::lanes
