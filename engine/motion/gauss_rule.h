#pragma once

#include "engine/base/math.h"

namespace lithe {

/// Collocation at the nodes of Gauss on (0, 1): exact to order 2 n at the end of a step, to order n within (Hairer &
/// Wanner II, IV.5).
class GaussRule {
 public:
  explicit GaussRule(int nodes);

  int count() const { return static_cast<int>(nodes.size()); }
  /// Values at x of the polynomials of degree n - 1 that are 1 at one node and 0 at the others.
  VectorX basis(double x) const;
  /// Their integrals from 0 to x.
  VectorX integrals(double x) const;

  VectorX nodes, weights;
  MatrixX stages;  // integrals up to each node, a row a node
};

}  // namespace lithe
