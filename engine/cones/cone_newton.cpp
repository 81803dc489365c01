#include "engine/cones/cone_newton.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>

namespace lithe {

/// x - y in a disc; the second component is zero in one of a single row.
Eigen::Vector2d ConeNewton::way_in(const DenseCones::Disc& disc, const VectorX& x) const {
  Eigen::Vector2d way = Eigen::Vector2d::Zero();
  for (int i = 0; i < disc.count; ++i) way[i] = x[disc.first + i] - y_[disc.first + i];
  return way;
}

/// |map|: x - P(x - y), its discs of radius limit * max(0, x_n - y_n).
double ConeNewton::evaluate(const DenseCones& cones, const VectorX& x) {
  y_.noalias() = cones.W * x;
  y_ += cones.free;
  map_.resize(x.size());
  for (const int n : cones.normals) map_[n] = x[n] - std::max(0.0, x[n] - y_[n]);
  for (const auto& disc : cones.discs) {
    const double radius = disc.limit * std::max(0.0, x[disc.normal] - y_[disc.normal]);
    const Eigen::Vector2d way = way_in(disc, x);
    const double length = way.norm();
    for (int i = 0; i < disc.count; ++i) {
      const int row = disc.first + i;
      map_[row] = length > radius ? x[row] - radius / length * way[i] : y_[row];
    }
  }
  return map_.norm();
}

void ConeNewton::linearize(const DenseCones& cones, const VectorX& x) {
  // One element of the generalised Jacobian. A row that sticks or presses asks for zero velocity (row of W); one that
  // is held asks for zero impulse (row of the identity).
  J_ = cones.W;
  const auto hold = [&](int row) {
    J_.row(row).setZero();
    J_(row, row) = 1;
  };
  // Closed too where it neither presses nor parts: bodies laid on each other, at the first step.
  for (const int n : cones.normals)
    if (!(x[n] >= y_[n])) hold(n);
  for (const auto& disc : cones.discs) {
    const int n = disc.normal;
    if (!(x[n] >= y_[n])) {
      for (int i = 0; i < disc.count; ++i) hold(disc.first + i);
      continue;
    }
    const Eigen::Vector2d way = way_in(disc, x);
    const double length = way.norm(), radius = disc.limit * (x[n] - y_[n]);
    if (length <= radius) continue;  // sticks: its velocities are zero
    // Slides: x_d = limit (x_n - y_n) d, d = way / |way|.
    const Eigen::Vector2d d = way / length;
    const auto turn = [&](int i, int j) { return radius / length * ((i == j) - d[i] * d[j]); };
    std::array<Eigen::RowVectorXd, 2> rows;
    for (int i = 0; i < disc.count; ++i) {
      rows[i] = disc.limit * d[i] * cones.W.row(n);
      rows[i][n] -= disc.limit * d[i];
      rows[i][disc.first + i] += 1;
      for (int j = 0; j < disc.count; ++j) {
        rows[i] += turn(i, j) * cones.W.row(disc.first + j);
        rows[i][disc.first + j] -= turn(i, j);
      }
    }
    for (int i = 0; i < disc.count; ++i) J_.row(disc.first + i) = rows[i];
  }
}

int ConeNewton::solve(const DenseCones& cones, int most, const std::function<bool(const VectorX&)>& solved,
                      VectorX& x) {
  constexpr double kCompliance = 1e-9;
  constexpr int kMemory = 5, kLeaps = 2, kHalvings = 12;
  // |map| may rise above the last but not above the last few; where no fraction of a step keeps to that, a whole step
  // all the same: its sets are new ones. Found on random heaps: fails a third as often as with descent alone.
  double best = evaluate(cones, x);
  std::array<double, kMemory> recent;
  recent.fill(best);
  VectorX best_point = x, point = x, step;
  int leaps = 0, steps = 0;
  while (steps < most) {
    linearize(cones, point);
    J_.diagonal().array() += kCompliance;
    // The compliance above keeps dependent rows solvable; LU, since sliding rows make J unsymmetric.
    step = J_.partialPivLu().solve(map_);
    ++steps;
    if (!step.allFinite()) break;
    // Non-monotone line search (Grippo, Lampariello, Lucidi 1986) over the last few values.
    const double bound = *std::max_element(recent.begin(), recent.end());
    double length = 1, size = 0;
    for (int k = 0; k < kHalvings; ++k, length *= 0.5) {
      x = point - length * step;
      size = evaluate(cones, x);
      if (size <= (1 - 1e-4 * length) * bound) break;
    }
    if (!(size < bound)) {
      if (leaps++ == kLeaps) break;
      x = point - step;
      size = evaluate(cones, x);
      recent.fill(size);
    }
    point = x;
    recent[steps % kMemory] = size;
    if (size < best) {
      best = size;
      best_point = x;
    }
    if (solved(x)) return steps;
  }
  x = best_point;
  return steps;
}

VectorX ConeNewton::least_norm(const DenseCones& cones, const VectorX& x) {
  evaluate(cones, x);
  linearize(cones, x);
  // Of all impulses that satisfy the linearised conditions, the shortest: which of a table's four legs carries how much
  // is not determined by rigid bodies, and should not depend on their order.
  Eigen::CompleteOrthogonalDecomposition<MatrixX> decomposition;
  decomposition.setThreshold(1e-11);
  decomposition.compute(J_);
  if (decomposition.rank() == J_.rows()) return x;
  return decomposition.solve(VectorX(J_ * x - map_));
}

}  // namespace lithe
