#include "engine/cones/joint_friction_problem.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

namespace lithe {
namespace {

constexpr int kMaxSweeps = 1000;
constexpr double kRoundOff = 1e-13;   // of the largest impulse
constexpr double kRestSpeed = 1e-15;  // m/s: of what sticks; friction of a coordinate that is driven is undetermined

/// One surface while the others are held. Its impulses by κ >= 0, a friction that grows with speed, u = -κ p:
///   p(κ) = -(W + κ)⁻¹ q
/// κ = 0 holds it; where that is more than friction gives, the κ with |p| = μ N.
class OneSurface {
 public:
  OneSurface(const JointFrictionProblem& problem, const JointFrictionProblem::Surface& surface, const VectorX& p)
      : surface_(surface) {
    const int first = surface.first, n = surface.count;
    W_.topLeftCorner(n, n) = problem.W.block(first, first, n, n);
    own_.head(n) = p.segment(first, n);
    q_.head(n) = problem.free.segment(first, n);
    q_.head(n).noalias() += problem.W.middleRows(first, n) * p;
    q_ -= W_ * own_;
    scale_ = std::max(std::abs(W_.trace()) / n, std::numeric_limits<double>::min());
    for (int k = n; k < 3; ++k) W_(k, k) = scale_;  // directions that it has not
    const Vector3 before = padded(problem.before.segment(first, n));
    before_ = before.dot(q_) > 0 ? before.norm() : 0;
    for (const auto& press : surface.presses) {
      auto& [constant, by] = presses_[press_count_++];
      by.setZero();
      by.leftCols(n) = press.by.middleCols(first, n);
      constant = press.constant + press.by * p - by * own_;
    }
  }

  Vector3 solve(char& sticks) const {
    sticks = true;
    if (q_.isZero(0)) return Vector3::Zero();
    const double mu = std::max(surface_.friction(before_, 0), surface_.friction(before_, q_.norm()));
    const double limit = mu * normal(Vector3::Zero());
    const double least = std::max(1e-16 * scale_, limit > 0 ? kRestSpeed / limit : 0);
    if (const Vector3 held = impulse(least); reserve(held, 0) >= 0) return held;
    sticks = false;
    constexpr double kWider = 64, kMost = 1e300;
    double low = std::max(least, scale_), high = low;
    while (low > least && slides(low) >= 0) low = std::max(least, low / kWider);
    while (slides(high) < 0) {
      low = high, high *= kWider;
      if (high > kMost) return Vector3::Zero();  // nothing presses
    }
    while (high - low > 1e-15 * high) {
      const double middle = (low + high) / 2;
      (slides(middle) < 0 ? low : high) = middle;
    }
    return impulse(high);
  }

 private:
  static Vector3 padded(ConstVectorRef x) {
    Vector3 all = Vector3::Zero();
    all.head(x.size()) = x;
    return all;
  }
  double normal(const Vector3& p) const {
    double sum = surface_.load;
    for (const auto& [constant, by] : std::span(presses_).first(press_count_)) sum += (constant + by * p).norm();
    return sum;
  }
  Vector3 impulse(double kappa) const { return -(W_ + kappa * Matrix3::Identity()).partialPivLu().solve(q_); }
  /// What friction could give beyond p, after which it slides with `speed`.
  double reserve(const Vector3& p, double speed) const {
    return surface_.friction(before_, speed) * normal(p) - p.norm();
  }
  double slides(double kappa) const {
    const Vector3 p = impulse(kappa);
    return reserve(p, kappa * p.norm());
  }

  const JointFrictionProblem::Surface& surface_;
  Matrix3 W_ = Matrix3::Zero();
  Vector3 q_ = Vector3::Zero(), own_ = Vector3::Zero();
  double scale_, before_;
  std::array<std::pair<Vector3, Matrix3>, JointFrictionProblem::kMostPresses> presses_;
  std::size_t press_count_ = 0;
};

}  // namespace

JointFrictionProblem::Result JointFrictionProblem::solve(VectorX& p, std::vector<char>& sticks) const {
  Result result{false, 0, 0};
  sticks.assign(surfaces.size(), 0);
  while (!result.converged && result.sweeps < kMaxSweeps) {
    ++result.sweeps;
    result.change = 0;
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      const Surface& surface = surfaces[i];
      auto now = p.segment(surface.first, surface.count);
      const Vector3 next = OneSurface(*this, surface, p).solve(sticks[i]);
      result.change = std::max(result.change, (next.head(surface.count) - now).norm());
      now = next.head(surface.count);
    }
    result.converged = result.change <= kRoundOff * p.lpNorm<Eigen::Infinity>();
  }
  return result;
}

}  // namespace lithe
