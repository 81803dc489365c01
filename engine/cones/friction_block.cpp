#include "engine/cones/friction_block.h"

#include <Eigen/LU>

namespace lithe::friction_block {
namespace {

/// W⁻¹ x; where W is singular, with a compliance of round-off in all directions.
Vector3 solve_linear(const Matrix3& W, const Vector3& x) {
  const double size = W(0, 0) * W(1, 1) * W(2, 2);
  if (const double determinant = W.determinant(); std::abs(determinant) > 1e-12 * size) return W.inverse() * x;
  const double compliance = 1e-13 * W.diagonal().maxCoeff();
  return (W + compliance * Matrix3::Identity()).inverse() * x;
}

/// Sliding with u_n = 0 and r = r_n (1, μ c), |c| = 1: r_n = -q_n / D, D = W_nn + μ W_nt c, and D u_t = a + B c must
/// point against c.
struct Slide {
  Vector2 a;
  Matrix2 B;
  Vector2 coupling;  // μ W_nt
  double W_nn, scale;

  Slide(const Matrix3& W, const Vector3& q, double friction)
      : a(q.tail<2>() * W(0, 0) - q[0] * W.block<2, 1>(1, 0)),
        B(friction * (q.tail<2>() * W.block<1, 2>(0, 1) - q[0] * W.block<2, 2>(1, 1))),
        coupling(friction * W.block<1, 2>(0, 1).transpose()),
        W_nn(W(0, 0)),
        scale(a.lpNorm<Eigen::Infinity>() + B.lpNorm<Eigen::Infinity>()) {}

  static Vector2 across(const Vector2& c) { return {-c[1], c[0]}; }
  double off(const Vector2& c) const { return (a + B * c).dot(across(c)); }  // zero: parallel
  bool valid(const Vector2& c) const {
    return (a + B * c).dot(c) <= 1e-14 * scale && W_nn + coupling.dot(c) > 1e-12 * W_nn;
  }
  Vector3 impulse(const Vector3& q, double friction, const Vector2& c) const {
    const double normal = -q[0] / (W_nn + coupling.dot(c));
    return {normal, friction * normal * c[0], friction * normal * c[1]};
  }

  /// Newton's method on the angle, from the direction in which friction of vanishing W_tt would act.
  bool find_near(Vector2& c) const {
    for (int k = 0; k < 12; ++k) {
      const Vector2 side = across(c), N = a + B * c;
      const double g = N.dot(side);
      if (std::abs(g) <= 1e-15 * scale) return valid(c);
      const double slope = side.dot(B * side) - N.dot(c);
      if (!(slope > 0)) return false;
      c = (c + std::clamp(-g / slope, -0.5, 0.5) * side).normalized();
    }
    return std::abs(off(c)) <= 1e-13 * scale && valid(c);
  }

  /// All around: of the up to four directions the valid one nearest to `start`.
  bool find_any(const Vector2& start, Vector2& c) const {
    constexpr int kSectors = 32, kHalvings = 52;
    const Vector2 turn(std::cos(2 * M_PI / kSectors), std::sin(2 * M_PI / kSectors));
    double best = -2;
    Vector2 left = start;
    for (int k = 0; k < kSectors; ++k) {
      const Vector2 right = turn[0] * left + turn[1] * across(left);
      const double g = off(left);
      if (g * off(right) <= 0) {
        Vector2 low = left, high = right;
        for (int halving = 0; halving < kHalvings; ++halving) {
          const Vector2 middle = (low + high).normalized();
          (off(middle) * g > 0 ? low : high) = middle;
        }
        const Vector2 root = (low + high).normalized();
        if (valid(root) && root.dot(start) > best) {
          best = root.dot(start);
          c = root;
        }
      }
      left = right;
    }
    return best > -2;
  }
};

}  // namespace

Vector3 solve(const Matrix3& W, const Vector3& q, double friction) {
  if (q[0] >= 0 || !(W(0, 0) > 0)) return Vector3::Zero();
  if (friction <= 0) return {-q[0] / W(0, 0), 0, 0};
  // Part, stick, slide: the three cases of a contact exclude each other, and the cheap ones are tried first.
  const Vector3 stick = solve_linear(W, -q);
  if (stick[0] > 0 && stick.tail<2>().squaredNorm() <= friction * friction * stick[0] * stick[0]) return stick;

  const Slide slide(W, q, friction);
  const double length = slide.a.norm();
  const Vector2 start = length > 0 ? Vector2(-slide.a / length) : Vector2(1, 0);
  Vector2 c = start;
  if (slide.find_near(c) || slide.find_any(start, c)) return slide.impulse(q, friction, c);
  return project_on_cone(stick, friction);
}

Vector2 solve_disc(const Matrix2& W, const Vector2& q, double limit) {
  if (limit <= 0) return Vector2::Zero();
  // A disc of given radius is an associated law: the minimum of ½ mᵀ W m + qᵀ m, which needs a symmetric matrix.
  const Matrix2 A = 0.5 * (W + W.transpose());
  const double size = A.trace();
  if (!(size > 0)) return q.norm() > 0 ? Vector2(-limit * q.normalized()) : Vector2::Zero();
  // (W + s E) m = -q, with the least s >= 0 that brings |m| down to the limit: Newton's method on 1/limit - 1/|m|.
  double s = A.determinant() > 1e-12 * size * size ? 0 : 1e-13 * size;
  Vector2 m;
  for (int k = 0; k < 30; ++k) {
    const Matrix2 inverse = (A + s * Matrix2::Identity()).inverse();
    m = -(inverse * q);
    const double length = m.norm();
    if (length <= limit * (1 + 1e-15)) break;
    // Newton on 1/|m|, nearly linear in s, converges from below in a few steps (Moré & Sorensen 1983).
    const double bend = m.dot(inverse * m) / (length * length);
    s += (length / limit - 1) / bend;
  }
  return project_on_disc(m, limit);
}

}  // namespace lithe::friction_block
