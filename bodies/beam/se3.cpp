#include "bodies/beam/se3_internal.h"

namespace lithe::se3 {
namespace {

/// d²k/dt². With c = ½x cot ½x, x² = t:  k = (1 - c)/t,  c' = (c - c² - t/4)/(2t).
double k_second(double t) {
  if (t < 0.5)
    return 2.0 / 30240 +
           t * (6.0 / 1209600 +
                t * (12.0 / 47900160 + t * (20 * 691.0 / 1307674368000 +
                                            t * (30.0 / 74724249600 + t * (42 * 3617.0 / 10670622842880000 +
                                                                           t * 56 * 43867.0 / 5109094217170944000)))));
  const auto k = k_of(t);
  const double c = 1 - k.value * t, c_t = (c - c * c - t / 4) / (2 * t);
  const double c_tt = (c_t - 2 * c * c_t - 0.25) / (2 * t) - c_t / t;
  return -(c_tt + 2 * k.rate) / t;
}

}  // namespace

/// F = E + ½ φ~ + k φ~²,  G = ½ u~ + k (φ~ u~ + u~ φ~) + 2 k' (φ·u) φ~².
InverseBlocks inverse_blocks(const Vector6& d) {
  const Vector3 u = d.head<3>(), phi = d.tail<3>();
  const double t = phi.squaredNorm(), along = phi.dot(u);
  const auto k = k_of(t);
  Matrix3 twice = phi * phi.transpose(), mixed = phi * u.transpose();
  mixed += mixed.transpose().eval();
  twice.diagonal().array() -= t;
  mixed.diagonal().array() -= 2 * along;
  InverseBlocks out{k.value * twice + 0.5 * skew(phi), k.value * mixed + (2 * k.rate * along) * twice + 0.5 * skew(u)};
  out.F.diagonal().array() += 1;
  return out;
}

/// Of f = (n, m):  Fᵀ n = n - ½ φ~ n + k φ~² n, and Gᵀ n is its derivative along u; so D = D(n), E = D'(n) u + D(m).
InverseRates inverse_rates(const Vector6& d, const Vector6& f) {
  const Vector3 u = d.head<3>(), phi = d.tail<3>(), n = f.head<3>();
  const double t = phi.squaredNorm(), along = phi.dot(u);
  const auto k = k_of(t);
  const auto twice = [&](const Vector3& x) -> Matrix3 {  // ∂(φ~² x)/∂φ
    Matrix3 out = phi * x.transpose() - 2 * x * phi.transpose();
    out.diagonal().array() += phi.dot(x);
    return out;
  };
  const auto first = [&](const Vector3& x) -> Matrix3 {
    return 0.5 * skew(x) + k.value * twice(x) + (2 * k.rate) * phi.cross(Vector3(phi.cross(x))) * phi.transpose();
  };
  const Vector3 square = phi.cross(Vector3(phi.cross(n)));
  const Vector3 mixed = phi.cross(Vector3(u.cross(n))) + u.cross(Vector3(phi.cross(n)));
  Matrix3 E = k.value * (u * n.transpose() - 2 * n * u.transpose());
  E.diagonal().array() += k.value * u.dot(n);
  E += (2 * k.rate) * (mixed * phi.transpose() + square * u.transpose() + along * twice(n));
  E += (4 * k_second(t) * along) * square * phi.transpose();
  return {first(n), E + first(f.tail<3>())};
}

Vector6 log_between(const Vector3& p_A, const Matrix3& R_A, const Vector3& p_B, const Matrix3& R_B) {
  const Vector3 phi = rotation_log(R_A.transpose() * R_B), d = R_A.transpose() * (p_B - p_A);
  const Vector3 turned = phi.cross(d);
  Vector6 out;
  out << d - 0.5 * turned + chart_coefficient(phi.squaredNorm()) * phi.cross(turned), phi;
  return out;
}

}  // namespace lithe::se3
