#include "engine/cones/cone_interior.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

namespace lithe {
namespace {

double determinant(const Vector3& a) {
  // (a - b)(a + b) instead of a² - b²: near the cone's surface the difference of squares would lose all its digits.
  const double across = a.tail<2>().norm();
  return (a[0] - across) * (a[0] + across);
}

/// Jordan product.
Vector3 product(const Vector3& a, const Vector3& b) {
  Vector3 c;
  c << a.dot(b), a[0] * b.tail<2>() + b[0] * a.tail<2>();
  return c;
}

/// x of product(a, x) = b.
Vector3 quotient(const Vector3& b, const Vector3& a) {
  const double first = (a[0] * b[0] - a.tail<2>().dot(b.tail<2>())) / determinant(a);
  Vector3 x;
  x << first, (b.tail<2>() - first * a.tail<2>()) / a[0];
  return x;
}

Vector3 reflected(const Vector3& a) { return {a[0], -a[1], -a[2]}; }

/// V(w) a, with V(w)² = 2 w wᵀ - diag(1, -1, -1).
Vector3 scaled_by(const Vector3& w, const Vector3& a) {
  Vector3 b;
  b << w.dot(a), a.tail<2>() + (a[0] + w.tail<2>().dot(a.tail<2>()) / (1 + w[0])) * w.tail<2>();
  return b;
}

/// Largest α for which z + α d stays in the cone.
double reach(const Vector3& z, const Vector3& d) {
  const double a = d[0] * d[0] - d.tail<2>().squaredNorm(), b = z[0] * d[0] - z.tail<2>().dot(d.tail<2>());
  const double c = determinant(z), under_root = b * b - a * c;
  // Leaving by the apex, or through the surface: the smaller positive root, written without cancellation.
  double longest = d[0] < 0 ? -z[0] / d[0] : 1e30;
  if (a < 0 || (b < 0 && under_root >= 0)) {  // a α² + 2 b α + c = 0
    const double denominator = std::sqrt(std::max(0.0, under_root)) - b;
    if (denominator > 0) longest = std::min(longest, c / denominator);
  }
  return longest;
}

}  // namespace

Vector3 ConeInterior::Cone::gather(const VectorX& x) const {
  Vector3 a = Vector3::Zero();
  a[0] = disc.limit * x[disc.normal];
  for (int i = 0; i < disc.count; ++i) a[1 + i] = x[disc.first + i];
  return a;
}

void ConeInterior::Cone::scatter(const Vector3& a, VectorX& x) const {
  x[disc.normal] += disc.limit * a[0];
  for (int i = 0; i < disc.count; ++i) x[disc.first + i] += a[1 + i];
}

void ConeInterior::Cone::scale() {
  constexpr double kLeast = 1e-300;
  // Nesterov and Todd's scaling point: the w for which stretching y and shrinking z give the same vector λ. Products of
  // z and y become products of λ with itself, so that primal and dual steps are treated alike.
  const double size_z = std::sqrt(std::max(kLeast, determinant(z)));
  const double size_y = std::sqrt(std::max(kLeast, determinant(y)));
  const Vector3 unit_z = z / size_z, unit_y = y / size_y;
  w = (unit_z + reflected(unit_y)) / std::sqrt(2 * (1 + unit_z.dot(unit_y)));
  eta = std::sqrt(size_z / size_y);
  lambda = stretched(y);
}

Vector3 ConeInterior::Cone::stretched(const Vector3& a) const { return eta * scaled_by(w, a); }
Vector3 ConeInterior::Cone::shrunk(const Vector3& a) const { return scaled_by(reflected(w), a) / eta; }

void ConeInterior::Cone::add_barrier(MatrixX& M) const {
  // Second derivative of the barrier at the scaling point, V(w)⁻² / η² with V(w)⁻¹ = V(reflected w).
  const Vector3 g = reflected(w);
  Matrix3 V = 2 * g * g.transpose();
  V.diagonal() += Vector3(-1, 1, 1);
  V /= eta * eta;
  M(disc.normal, disc.normal) += disc.limit * disc.limit * V(0, 0);
  for (int i = 0; i < disc.count; ++i) {
    M(disc.normal, disc.first + i) += disc.limit * V(0, 1 + i);
    M(disc.first + i, disc.normal) += disc.limit * V(0, 1 + i);
    for (int j = 0; j < disc.count; ++j) M(disc.first + i, disc.first + j) += V(1 + i, 1 + j);
  }
}

/// Start: on the axes of the cones.
void ConeInterior::place(const DenseCones& cones, double size, VectorX& x) {
  x.setZero(cones.free.size());
  cones_.clear();
  std::size_t k = 0;
  for (const int normal : cones.normals) {
    x[normal] = size;
    const std::size_t first = k;
    for (; k < cones.discs.size() && cones.discs[k].normal == normal; ++k) cones_.push_back({.disc = cones.discs[k]});
    // A contact without friction keeps its half-line: a cone of no width.
    if (k == first) cones_.push_back({.disc = {normal, 0, 0, 1.0}});  // no friction: the half-line
  }
  for (Cone& cone : cones_) {
    cone.z = cone.gather(x);
    cone.y = {size, 0, 0};
  }
}

double ConeInterior::slip(const Cone& cone) const { return u_.segment(cone.disc.first, cone.disc.count).norm(); }

/// M = W + Σ V⁻² (+ derivative of Σ limit |y_d|).
void ConeInterior::build(const DenseCones& cones, SlipTerm slip_term) {
  M_ = cones.W;
  // Dependent contact rows (four corners of a box) leave W singular; rows are scaled to one, so this is relative.
  M_.diagonal().array() += 1e-10;
  for (Cone& cone : cones_) {
    cone.scale();
    cone.add_barrier(M_);
    const double speed = slip_term == SlipTerm::linearized && cone.disc.count > 0 ? slip(cone) : 0;
    // d(μ |u_t|)/dx turns the associated cone of an optimisation into Coulomb's law; M is then no longer symmetric.
    for (int i = 0; speed > 0 && i < cone.disc.count; ++i)
      M_.row(cone.disc.normal) +=
          (cone.disc.limit * u_[cone.disc.first + i] / speed) * cones.W.row(cone.disc.first + i);
  }
}

/// Newton's direction to each cone's aim; returns how far it may be followed.
template <class Factor>
double ConeInterior::find_direction(const Factor& factor) {
  right_ = -residual_;
  for (const Cone& cone : cones_) cone.scatter(cone.shrunk(cone.aim), right_);
  dx_ = factor.solve(right_);
  double longest = 1e30;
  for (Cone& cone : cones_) {
    cone.dz = cone.gather(dx_);
    cone.dy = cone.shrunk(cone.aim - cone.shrunk(cone.dz));
    longest = std::min({longest, reach(cone.z, cone.dz), reach(cone.y, cone.dy)});
  }
  return longest;
}

template <class Factor>
bool ConeInterior::advance(const Factor& factor, double gap, VectorX& x) {
  // Mehrotra's predictor: straight at the solution, λ∘λ = 0. How far it gets tells how much centring is needed.
  for (Cone& cone : cones_) cone.aim = -cone.lambda;
  double length = std::min(1.0, find_direction(factor)), gap_ahead = 0;
  for (const Cone& cone : cones_) gap_ahead += (cone.z + length * cone.dz).dot(cone.y + length * cone.dy);
  // Back to the middle by what the predictor could not reach, its second-order error taken off.
  const double centre = std::clamp(gap_ahead / gap, 0.0, 1.0) * gap / static_cast<double>(cones_.size());
  for (Cone& cone : cones_) {
    Vector3 target = -product(cone.lambda, cone.lambda) - product(cone.shrunk(cone.dz), cone.stretched(cone.dy));
    target[0] += centre;
    cone.aim = quotient(target, cone.lambda);
  }
  // Never onto the surface: the next scaling point would not exist.
  length = std::min(1.0, 0.99 * find_direction(factor));
  if (!dx_.allFinite() || !(length > 1e-8)) return false;
  x += length * dx_;
  for (Cone& cone : cones_) {
    cone.z = cone.gather(x);
    cone.y += length * cone.dy;
  }
  return true;
}

int ConeInterior::solve(const DenseCones& cones, SlipTerm slip_term, int most, double accuracy, VectorX& x,
                        double start) {
  const double size = cones.free.lpNorm<Eigen::Infinity>();
  if (!(size > 0)) {
    x.setZero(cones.free.size());
    return 0;
  }
  place(cones, start * size, x);
  for (int steps = 0; steps < most; ++steps) {
    u_.noalias() = cones.W * x;
    u_ += cones.free;
    residual_ = u_;
    double gap = 0;
    for (const Cone& cone : cones_) {
      if (cone.disc.count > 0) residual_[cone.disc.normal] += cone.disc.limit * slip(cone);
      cone.scatter(-cone.y, residual_);
      gap += cone.z.dot(cone.y);
    }
    // Complementarity zᵀ y is a product of two small quantities, hence the square of the accuracy.
    if (gap <= accuracy * accuracy * size * size * static_cast<double>(cones_.size()) &&
        residual_.lpNorm<Eigen::Infinity>() <= accuracy * size)
      return steps;
    build(cones, slip_term);
    const bool advanced =
        slip_term == SlipTerm::linearized ? advance(M_.partialPivLu(), gap, x) : advance(M_.llt(), gap, x);
    if (!advanced) return steps;
  }
  return most;
}

}  // namespace lithe
