#pragma once

#include <functional>

#include "engine/cones/dense_cones.h"

namespace lithe {

/// Semismooth Newton method on the natural map of all contacts (Alart and Curnier, 1991): a step takes each as
/// separate, sticking or sliding by where it is, and solves those equations. Exact in its last step; far from a
/// solution it may fail. A compliance of 1e-9 of the contacts' own makes its steps those of least norm where contacts
/// are redundant.
class ConeNewton {
 public:
  /// At most so many steps, until `solved(x)`. Returns how many; x: the best point of all, of least |map|.
  int solve(const DenseCones& cones, int most, const std::function<bool(const VectorX&)>& solved, VectorX& x);
  /// Of all impulses with the velocities and the sets of x, a solution: those of least Σ W_ii r_i². They may lie
  /// outside the cones where x lies inside.
  VectorX least_norm(const DenseCones& cones, const VectorX& x);

 private:
  Eigen::Vector2d way_in(const DenseCones::Disc& disc, const VectorX& x) const;
  double evaluate(const DenseCones& cones, const VectorX& x);
  void linearize(const DenseCones& cones, const VectorX& x);

  VectorX y_, map_;  // of the point evaluated last
  MatrixX J_;
};

}  // namespace lithe
