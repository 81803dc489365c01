#include "engine/base/math.h"

namespace lithe {

RotationSeries::RotationSeries(const Vector3& phi) {
  const double t = phi.squaredNorm();
  if (t < 1.0) {
    // Ten terms each; the closed form of db would lose eps/|phi|⁴.
    a = b = da = db = 0;
    double term_a = 0.5, term_b = 1.0 / 6;  // (-t)^k / (2k+2)!, / (2k+3)!
    for (int k = 0; k < 10; ++k) {
      a += term_a;
      b += term_b;
      da -= 2 * (k + 1) * term_a / ((2 * k + 3) * (2 * k + 4));
      db -= 2 * (k + 1) * term_b / ((2 * k + 4) * (2 * k + 5));
      term_a *= -t / ((2 * k + 3) * (2 * k + 4));
      term_b *= -t / ((2 * k + 4) * (2 * k + 5));
    }
    return;
  }
  const double p = std::sqrt(t), s = std::sin(p), c = std::cos(p);
  a = (1 - c) / t;
  b = (p - s) / (t * p);
  da = (p * s - 2 * (1 - c)) / (t * t);
  db = (3 * s - 2 * p - p * c) / (t * t * p);
}

Matrix3 rotation_exp(const Vector3& phi) {
  const RotationSeries f(phi);
  const Matrix3 P = skew(phi);
  return Matrix3::Identity() + (1 - f.b * phi.squaredNorm()) * P + f.a * P * P;
}

Vector3 rotation_log(const Matrix3& R) {
  const Eigen::AngleAxisd turn{Eigen::Quaterniond(R)};
  return turn.angle() * turn.axis();
}

Matrix3 left_jacobian(const Vector3& phi) {
  const RotationSeries f(phi);
  const Matrix3 P = skew(phi);
  return Matrix3::Identity() + f.a * P + f.b * P * P;
}

Vector3 left_jacobian_rate(const Vector3& phi, const Vector3& phi_dot) {
  const RotationSeries f(phi);
  const double d = phi.dot(phi_dot);
  const Vector3 c = phi.cross(phi_dot);
  return d * f.da * c + d * f.db * phi.cross(c) + f.b * phi_dot.cross(c);
}

Matrix3 right_jacobian_inverse(const Vector3& psi) {
  const double t = psi.squaredNorm();
  const double k = chart_coefficient(t);
  Matrix3 J = (k * psi) * psi.transpose();  // psi~² = psi psiᵀ - t E
  J.diagonal().array() += 1 - k * t;
  return J + skew(0.5 * psi);
}

Vector4 quaternion_of(const Matrix3& R) {
  const Eigen::Quaterniond e(R);
  return Vector4(e.w(), e.x(), e.y(), e.z()).normalized();
}

Matrix3 rotation_about(const Vector3& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

}  // namespace lithe
