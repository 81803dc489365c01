#include "bodies/beam/se3_internal.h"

#include <array>
#include <cmath>

namespace lithe::se3 {
namespace {

/// A function of t with its first two derivatives.
struct Twice {
  double value, rate, second;
};

/// Σ c_n s^n and its derivatives by s.
template <std::size_t N>
Twice series(const std::array<double, N>& c, double s) {
  Twice p{0, 0, 0};
  for (std::size_t n = N; n-- > 0;) {
    p.second = 2 * p.rate + s * p.second;
    p.rate = p.value + s * p.rate;
    p.value = c[n] + s * p.value;
  }
  return p;
}

/// 1/(2n + first)!
template <std::size_t N>
constexpr std::array<double, N> inverse_factorials(int first) {
  std::array<double, N> c{};
  double factorial = 1;
  for (int i = 2; i < first; ++i) factorial *= i;
  for (std::size_t n = 0; n < N; ++n) {
    const int at = 2 * static_cast<int>(n) + first;
    factorial *= at;
    c[n] = 1 / factorial;
    factorial *= at + 1;
  }
  return c;
}

constexpr double kSeries = 0.5;  // up to this t

}  // namespace

Pose exp(const Vector6& d) {
  const Vector3 u = d.head<3>(), phi = d.tail<3>(), turned = phi.cross(u);
  const Analytic right = right_at(d);
  const double t = phi.squaredNorm(), a = -right.odd, b = right.even;
  return {u + a * turned + b * phi.cross(turned),
          (1 - a * t) * Matrix3::Identity() + a * phi * phi.transpose() + (1 - b * t) * skew(phi)};
}

/// With s = sin x / x, x² = t:  a = (1 - cos x)/t, b = (1 - s)/t, s' = (cos x - s)/(2t).
Analytic right_at(const Vector6& d) {
  const double t = d.tail<3>().squaredNorm();
  Twice a, b;
  if (t < kSeries) {
    static constexpr auto kA = inverse_factorials<9>(2), kB = inverse_factorials<9>(3);
    a = series(kA, -t), b = series(kB, -t);
    a.rate = -a.rate, b.rate = -b.rate;
  } else {
    const double x = std::sqrt(t), c = std::cos(x), s = std::sin(x) / x, s_t = (c - s) / (2 * t);
    const double s_tt = (-0.5 * s - 3 * s_t) / (2 * t);
    a.value = (1 - c) / t, a.rate = (0.5 * s - a.value) / t, a.second = (0.5 * s_t - 2 * a.rate) / t;
    b.value = (1 - s) / t, b.rate = (-s_t - b.value) / t, b.second = (-s_tt - 2 * b.rate) / t;
  }
  return {-a.value, -a.rate, -a.second, b.value, b.rate, b.second};
}

/// With c = ½x cot ½x, x² = t:  k = (1 - c)/t,  c' = (c - c² - t/4)/(2t).
Analytic right_inverse_at(const Vector6& d) {
  const double t = d.tail<3>().squaredNorm();
  Twice k;
  if (t < kSeries) {
    static constexpr std::array<double, 9> kK = {1.0 / 12,
                                                 1.0 / 720,
                                                 1.0 / 30240,
                                                 1.0 / 1209600,
                                                 1.0 / 47900160,
                                                 691.0 / 1307674368000,
                                                 1.0 / 74724249600,
                                                 3617.0 / 10670622842880000,
                                                 43867.0 / 5109094217170944000};
    k = series(kK, t);
  } else {
    const double half = 0.5 * std::sqrt(t), c = half * std::cos(half) / std::sin(half);
    const double c_t = (c - c * c - t / 4) / (2 * t), c_tt = (c_t - 2 * c * c_t - 0.25) / (2 * t) - c_t / t;
    k.value = (1 - c) / t, k.rate = -(c_t + k.value) / t, k.second = -(c_tt + 2 * k.rate) / t;
  }
  return {0.5, 0, 0, k.value, k.rate, k.second};
}

/// G is the derivative of F along u.
Blocks blocks(const Analytic& c, const Vector6& d) {
  const Vector3 u = d.head<3>(), phi = d.tail<3>();
  const double t = phi.squaredNorm(), along = phi.dot(u);
  Matrix3 twice = phi * phi.transpose(), mixed = phi * u.transpose();
  mixed += mixed.transpose().eval();
  twice.diagonal().array() -= t;
  mixed.diagonal().array() -= 2 * along;
  Blocks out{c.even * twice + c.odd * skew(phi), c.even * mixed + (2 * c.even_rate * along) * twice + c.odd * skew(u)};
  if (c.odd_rate != 0) out.G += (2 * c.odd_rate * along) * skew(phi);
  out.F.diagonal().array() += 1;
  return out;
}

/// Of x = (x_u, x_w), F' = ∂(F x_w)/∂φ; G' = ∂(F x_u)/∂φ + ∂(F' u)/∂φ.
Blocks rates(const Analytic& c, const Vector6& d, const Vector6& x) {
  const Vector3 u = d.head<3>(), phi = d.tail<3>(), w = x.tail<3>();
  const double along = phi.dot(u);
  const auto twice = [&](const Vector3& a, const Vector3& y) -> Matrix3 {  // ∂(a × (φ × y) + φ × (a × y))/∂φ, a fixed
    Matrix3 out = a * y.transpose() - 2 * y * a.transpose();
    out.diagonal().array() += a.dot(y);
    return out;
  };
  const auto first = [&](const Vector3& y) -> Matrix3 {
    const Vector3 once = phi.cross(y), square = phi.cross(once);
    return c.even * twice(phi, y) - c.odd * skew(y) +
           (2 * c.odd_rate * once + 2 * c.even_rate * square) * phi.transpose();
  };
  const Vector3 once = phi.cross(w), square = phi.cross(once);
  const Vector3 side = u.cross(w), mixed = phi.cross(side) + u.cross(once);
  const Vector3 by_u = 2 * c.odd_rate * once + 2 * c.even_rate * square;
  const Vector3 by_phi =
      2 * c.odd_rate * side + 2 * c.even_rate * mixed + (4 * along) * (c.odd_second * once + c.even_second * square);
  Matrix3 E = c.even * twice(u, w) + (2 * c.even_rate * along) * twice(phi, w) - (2 * c.odd_rate * along) * skew(w);
  E += by_u * u.transpose() + by_phi * phi.transpose();
  return {first(w), E + first(x.head<3>())};
}

Vector6 log_between(const Vector3& p_A, const Matrix3& R_A, const Vector3& p_B, const Matrix3& R_B) {
  const Vector3 phi = rotation_log(R_A.transpose() * R_B), d = R_A.transpose() * (p_B - p_A);
  const Vector3 turned = phi.cross(d);
  Vector6 out;
  out << d - 0.5 * turned + chart_coefficient(phi.squaredNorm()) * phi.cross(turned), phi;
  return out;
}

}  // namespace lithe::se3
