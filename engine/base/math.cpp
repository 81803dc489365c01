#include "engine/base/math.h"

namespace lithe {

namespace {

constexpr int kTerms = 10;  // to round-off for |phi| < 1

/// Coefficients c_k of Σ c_k (-t)^k: 1 / (2k + first)!, or that times k + 1.
struct Series {
  constexpr Series(int first, bool weighted) {
    double factorial = 1;
    for (int i = 2; i < first; ++i) factorial *= i;
    for (int k = 0; k < kTerms; ++k) {
      factorial *= k == 0 ? first : (2.0 * k + first - 1) * (2.0 * k + first);
      c[k] = (weighted ? k + 1 : 1) / factorial;
    }
  }
  double operator()(double minus_t) const {
    double sum = c[kTerms - 1];
    for (int k = kTerms - 2; k >= 0; --k) sum = sum * minus_t + c[k];
    return sum;
  }
  double c[kTerms] = {};
};
constexpr Series kA(2, false), kB(3, false), kDa(4, true), kDb(5, true);

/// Of the SO(3) series at t = |phi|² (docs/equations.md section 1): a = (1 - cos)/t, b = (|phi| - sin)/(t |phi|).
struct RotationSeries {
  explicit RotationSeries(double t) {
    if (t < 1.0) {
      a = kA(-t), b = kB(-t);
      return;
    }
    const double p = std::sqrt(t);
    a = (1 - std::cos(p)) / t;
    b = (p - std::sin(p)) / (t * p);
  }
  double a, b;
};

/// The derivatives of a and b with respect to |phi|, over |phi|. The closed form of db would lose eps/|phi|⁴ near zero.
struct RotationSeriesRate {
  explicit RotationSeriesRate(double t) {
    if (t < 1.0) {
      da = -2 * kDa(-t), db = -2 * kDb(-t);
      return;
    }
    const double p = std::sqrt(t), s = std::sin(p), c = std::cos(p);
    da = (p * s - 2 * (1 - c)) / (t * t);
    db = (3 * s - 2 * p - p * c) / (t * t * p);
  }
  double da, db;
};

}  // namespace

Matrix3 rotation_exp(const Vector3& phi) {
  const double t = phi.squaredNorm();
  const RotationSeries f(t);
  const Matrix3 P = skew(phi);
  return Matrix3::Identity() + (1 - f.b * t) * P + f.a * P * P;
}

Vector3 rotation_log(const Matrix3& R) {
  const Eigen::AngleAxisd turn{Eigen::Quaterniond(R)};
  return turn.angle() * turn.axis();
}

Matrix3 left_jacobian(const Vector3& phi) {
  const RotationSeries f(phi.squaredNorm());
  const Matrix3 P = skew(phi);
  return Matrix3::Identity() + f.a * P + f.b * P * P;
}

Vector3 left_jacobian_rate(const Vector3& phi, const Vector3& phi_dot) {
  const double t = phi.squaredNorm(), d = phi.dot(phi_dot);
  const RotationSeriesRate f(t);
  const Vector3 c = phi.cross(phi_dot);
  return d * f.da * c + d * f.db * phi.cross(c) + RotationSeries(t).b * phi_dot.cross(c);
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
