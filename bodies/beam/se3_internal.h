#pragma once

#include <complex>

#include "engine/base/math.h"

/// Maps of the group of rigid motions SE(3), for coordinates d = (u, phi): translation, rotation; so are twists and, by
/// duality, wrenches. Each is analytic in its arguments, so that complex steps differentiate it to round-off.
/// With dual numbers phi + ε u for phi they are functions of SO(3):  f(phi + ε u) = f(phi) + ε f'(phi) u.
/// V. Sonneville, A. Cardona, O. Brüls, Comput. Methods Appl. Mech. Engrg. 268 (2014) 451, appendix.
namespace lithe::se3 {

template <class S>
using Vector3Of = Eigen::Matrix<S, 3, 1>;
template <class S>
using Vector6Of = Eigen::Matrix<S, 6, 1>;

/// Eigen's conjugates complex products, and so do dot() and squaredNorm().
template <class S>
Vector3Of<S> cross(const Vector3Of<S>& a, const Vector3Of<S>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Functions of t = |phi|² and their derivatives by it:
///   a = (1 - cos x)/x²,  b = (x - sin x)/x³  of Jr = E - a phi~ + b phi~²,  exp = E + (1 - b t) phi~ + a phi~²
///   k of Jr⁻¹ = E + ½ phi~ + k phi~²
template <class S>
struct Coefficients {
  S value, rate;
};

template <class S>
Coefficients<S> a_of(const S& t) {
  if (std::real(t) < 0.5) {
    S value = 0, rate = 0;
    double c = 1.0 / 6402373705728000.0;  // 1/18!
    for (int n = 8; n >= 0; --n) {        // Σ (-t)^n / (2n + 2)!
      rate = value - t * rate;
      value = c - t * value;
      c *= (2 * n + 2) * (2 * n + 1);
    }
    return {value, -rate};
  }
  const S x = std::sqrt(t), a = (1.0 - std::cos(x)) / t;
  return {a, (0.5 * std::sin(x) / x - a) / t};
}

template <class S>
Coefficients<S> b_of(const S& t) {
  if (std::real(t) < 0.5) {
    S value = 0, rate = 0;
    double c = 1.0 / 121645100408832000.0;  // 1/19!
    for (int n = 8; n >= 0; --n) {          // Σ (-t)^n / (2n + 3)!
      rate = value - t * rate;
      value = c - t * value;
      c *= (2 * n + 3) * (2 * n + 2);
    }
    return {value, -rate};
  }
  const S x = std::sqrt(t), sine = std::sin(x) / x, b = (1.0 - sine) / t;
  return {b, (-0.5 * (std::cos(x) - sine) / t - b) / t};
}

template <class S>
Coefficients<S> k_of(const S& t) {
  if (std::real(t) < 0.5) {  // |B_2n| t^(n-1) / (2n)!
    constexpr double c[] = {1.0 / 12,
                            1.0 / 720,
                            1.0 / 30240,
                            1.0 / 1209600,
                            1.0 / 47900160,
                            691.0 / 1307674368000,
                            1.0 / 74724249600,
                            3617.0 / 10670622842880000,
                            43867.0 / 5109094217170944000};
    S value = 0, rate = 0;
    for (int n = 8; n >= 0; --n) {
      rate = value + t * rate;
      value = c[n] + t * value;
    }
    return {value, rate};
  }
  const S half = 0.5 * std::sqrt(t), sine = std::sin(half), k = (1.0 - half * std::cos(half) / sine) / t;
  return {k, ((half / sine - std::cos(half)) / (sine * 8.0 * half) - k) / t};
}

/// A rigid motion: place and axes.
template <class S>
struct Pose {
  Vector3Of<S> p;
  Eigen::Matrix<S, 3, 3> R;
};

/// |phi|².
template <class S>
S square(const Vector6Of<S>& d) {
  return d[3] * d[3] + d[4] * d[4] + d[5] * d[5];
}

template <class S>
Pose<S> exp(const Vector6Of<S>& d) {
  const Vector3Of<S> u = d.template head<3>(), phi = d.template tail<3>(), turned = cross<S>(phi, u);
  const S t = square<S>(d), a = a_of(t).value, b = b_of(t).value, sine = 1.0 - b * t;
  Pose<S> h;
  h.p = u + a * turned + b * cross<S>(phi, turned);
  // E + sine phi~ + a (phi phiᵀ - t E)
  h.R = (a * phi) * phi.transpose();
  h.R.diagonal().array() += 1.0 - a * t;
  const Vector3Of<S> s = sine * phi;
  h.R(0, 1) -= s[2], h.R(0, 2) += s[1], h.R(1, 2) -= s[0];
  h.R(1, 0) += s[2], h.R(2, 0) -= s[1], h.R(2, 1) += s[0];
  return h;
}

/// Ad(exp(d)⁻¹) x: a twist carried from the start of the motion to its end.
template <class S>
Vector6Of<S> carried(const Pose<S>& h, const Vector6Of<S>& x) {
  Vector6Of<S> out;
  const Vector3Of<S> w = x.template tail<3>(), v = x.template head<3>() - cross<S>(h.p, w);
  out.template head<3>() = h.R.transpose() * v;
  out.template tail<3>() = h.R.transpose() * w;
  return out;
}
/// Its transpose: a wrench carried back.
inline Vector6 carried_back(const Pose<double>& h, const Vector6& f) {
  Vector6 out;
  const Vector3 force = h.R * f.head<3>();
  out << force, h.p.cross(force) + h.R * f.tail<3>();
  return out;
}

/// [f(phi), f'(phi) u; 0, f(phi)] x for f = E + odd phi~ + even phi~²; odd_rate, even_rate by t.
template <class S>
Vector6Of<S> apply(const S& odd, const S& odd_rate, const S& even, const S& even_rate, const Vector6Of<S>& d,
                   const Vector6Of<S>& x) {
  const Vector3Of<S> u = d.template head<3>(), phi = d.template tail<3>();
  const Vector3Of<S> xu = x.template head<3>(), xw = x.template tail<3>();
  const S along = 2.0 * (phi[0] * u[0] + phi[1] * u[1] + phi[2] * u[2]);
  const Vector3Of<S> fu = cross<S>(phi, xu), fw = cross<S>(phi, xw), uw = cross<S>(u, xw), ffw = cross<S>(phi, fw);
  const Vector3Of<S> twice = cross<S>(phi, fu + uw) + cross<S>(u, fw);
  Vector6Of<S> out;
  out.template head<3>() = xu + odd * (fu + uw) + even * twice + along * (odd_rate * fw + even_rate * ffw);
  out.template tail<3>() = xw + odd * fw + even * ffw;
  return out;
}

/// T(d) x, the right Jacobian: exp(d) moves by the twist T(d) d_dot, in the axes of its end.
template <class S>
Vector6Of<S> right(const Vector6Of<S>& d, const Vector6Of<S>& x) {
  const S t = square<S>(d);
  const auto a = a_of(t), b = b_of(t);
  return apply<S>(-a.value, -a.rate, b.value, b.rate, d, x);
}
/// T(d)⁻¹ x.
template <class S>
Vector6Of<S> right_inverse(const Vector6Of<S>& d, const Vector6Of<S>& x) {
  const auto k = k_of(square<S>(d));
  return apply<S>(S(0.5), S(0), k.value, k.rate, d, x);
}

/// T(d)⁻¹ = [F, G; 0, F], in closed form; T(-d)⁻¹ has Fᵀ and Gᵀ.
struct InverseBlocks {
  Matrix3 F, G;
};
InverseBlocks inverse_blocks(const Vector6& d);
/// ∂(T(d)⁻ᵀ f)/∂d = [0, D; D, E] for a constant wrench f.
struct InverseRates {
  Matrix3 D, E;
};
InverseRates inverse_rates(const Vector6& d, const Vector6& f);

/// Transposes, of wrenches: those of [F, G; 0, F] by exchanging the halves, with -d for d.
template <class S>
Vector6Of<S> exchanged(const Vector6Of<S>& x) {
  Vector6Of<S> out;
  out << x.template tail<3>(), x.template head<3>();
  return out;
}
inline Vector6 right_transposed(const Vector6& d, const Vector6& f) {
  return exchanged<double>(right<double>(Vector6(-d), exchanged<double>(f)));
}
inline Vector6 right_inverse_transposed(const Vector6& d, const Vector6& f) {
  return exchanged<double>(right_inverse<double>(Vector6(-d), exchanged<double>(f)));
}

/// log(A⁻¹ B) of two poses, turned against each other by less than half a turn.
Vector6 log_between(const Vector3& p_A, const Matrix3& R_A, const Vector3& p_B, const Matrix3& R_B);

}  // namespace lithe::se3
