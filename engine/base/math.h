#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

/// Rotation formulas that Eigen does not provide. SI units, right-handed axes, quaternions stored w, x, y, z.
namespace lithe {

using Vector3 = Eigen::Vector3d;
using Vector4 = Eigen::Vector4d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using VectorX = Eigen::VectorXd;
using Matrix3 = Eigen::Matrix3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using MatrixX = Eigen::MatrixXd;
using Matrix3X = Eigen::Matrix<double, 3, Eigen::Dynamic>;
using Matrix6X = Eigen::Matrix<double, 6, Eigen::Dynamic>;
using VectorRef = Eigen::Ref<VectorX>;
using ConstVectorRef = const Eigen::Ref<const VectorX>&;
using MatrixRef = Eigen::Ref<MatrixX>;
using ConstMatrixRef = const Eigen::Ref<const MatrixX>&;

/// Cross-product matrix: skew(a) b = a × b.
inline Matrix3 skew(const Vector3& a) {
  Matrix3 s;
  s << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return s;
}

/// Rotation matrix of a unit quaternion (w, x, y, z): body components to world components.
inline Matrix3 rotation_matrix(const Vector4& e) {
  const double w = e[0], x = e[1], y = e[2], z = e[3];
  Matrix3 A;
  A << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z), 1 - 2 * (x * x + z * z),
      2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return A;
}

/// Quaternion product a ∘ b.
inline Vector4 quaternion_product(const Vector4& a, const Vector4& b) {
  Vector4 c;
  c[0] = a[0] * b[0] - a.tail<3>().dot(b.tail<3>());
  c.tail<3>() = a[0] * b.tail<3>() + b[0] * a.tail<3>() + a.tail<3>().cross(b.tail<3>());
  return c;
}

/// c = cos √t, s = sin √t / (2 √t): of half a rotation vector whose square is 4 t.
inline void half_angle(double t, double& c, double& s) {
  if (t < 0.1) {  // to round-off; the compiler may not turn divisions by constants into products
    constexpr double a2 = 1.0 / 2, a4 = a2 / 12, a6 = a4 / 30, a8 = a6 / 56, a10 = a8 / 90, a12 = a10 / 132;
    constexpr double b1 = 1.0 / 2, b3 = b1 / 6, b5 = b3 / 20, b7 = b5 / 42, b9 = b7 / 72, b11 = b9 / 110;
    c = 1 - t * (a2 - t * (a4 - t * (a6 - t * (a8 - t * (a10 - t * a12)))));
    s = b1 - t * (b3 - t * (b5 - t * (b7 - t * (b9 - t * b11))));
  } else {
    const double half = std::sqrt(t);
    c = std::cos(half);
    s = std::sin(half) / (2 * half);
  }
}

/// e ∘ exp(psi): turns by the rotation vector psi given in body axes. Renormalised, so the norm never drifts.
inline Vector4 rotated(const Vector4& e, const Vector3& psi) {
  double c, s;  // cos(|psi|/2), sin(|psi|/2)/|psi|
  half_angle(0.25 * psi.squaredNorm(), c, s);
  Vector4 turn;
  turn[0] = c;
  turn.tail<3>() = s * psi;
  const Vector4 product = quaternion_product(e, turn);
  return product * (1.5 - 0.5 * product.squaredNorm());  // one Newton step of 1/sqrt: exact to round-off here
}

/// exp(phi~), the rotation by the vector phi.
Matrix3 rotation_exp(const Vector3& phi);
/// Rotation vector of a rotation matrix, |phi| <= pi.
Vector3 rotation_log(const Matrix3& R);
/// Left Jacobian: d/dt exp(phi~) = (Jl phi_dot)~ exp(phi~). The right one is its transpose.
Matrix3 left_jacobian(const Vector3& phi);
/// (dJl/dt) phi_dot, the bias of the marker's angular acceleration.
Vector3 left_jacobian_rate(const Vector3& phi, const Vector3& phi_dot);
/// k(t) of Jr⁻¹(psi) = E + ½ psi~ + k psi~², t = |psi|² < 4 pi²:  k = 1/t - (1 + cos)/(2 |psi| sin).
inline double chart_coefficient(double t) {
  if (t < 0.5) {  // |B_2n| t^(n-1) / (2n)!, to round-off
    constexpr double c1 = 1.0 / 12, c2 = 1.0 / 720, c3 = 1.0 / 30240, c4 = 1.0 / 1209600, c5 = 1.0 / 47900160,
                     c6 = 691.0 / 1307674368000, c7 = 1.0 / 74724249600, c8 = 3617.0 / 10670622842880000;
    return c1 + t * (c2 + t * (c3 + t * (c4 + t * (c5 + t * (c6 + t * (c7 + t * c8))))));
  }
  const double half = std::sqrt(t) / 2;
  return (1 - half / std::tan(half)) / t;
}
/// Jr⁻¹(psi) omega, the rate of the rotation vector psi of a body that turns at omega (body axes).
inline Vector3 chart_rate(const Vector3& psi, const Vector3& omega) {
  const Vector3 c = psi.cross(omega);
  return omega + 0.5 * c + chart_coefficient(psi.squaredNorm()) * psi.cross(c);
}
/// Inverse of the right Jacobian: psi_dot = Jr⁻¹(psi) omega for exp(psi~) turning at body rate omega. |psi| < 2 pi.
Matrix3 right_jacobian_inverse(const Vector3& psi);

/// Quaternion (w, x, y, z) of a rotation matrix.
Vector4 quaternion_of(const Matrix3& R);
/// Rotation by `angle` (radians) about `axis` (any length but zero).
Matrix3 rotation_about(const Vector3& axis, double angle);

}  // namespace lithe
