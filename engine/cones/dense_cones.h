#pragma once

#include <vector>

#include "engine/cones/cone_problem.h"

namespace lithe {

/// A small contact problem by its dense operator, its rows scaled so that the largest diagonal entry of every normal
/// and of every disc is 1: impulses r = scale * x. Friction, rolling and spinning friction are all discs: |x_d| <=
/// limit x_n. Rows across without friction carry nothing and are left out.
struct DenseCones {
  struct Disc {
    int normal, first, count;
    double limit;
  };
  MatrixX W;
  VectorX free, scale;
  int problem_rows = 0;
  std::vector<int> rows;     // of the problem
  std::vector<int> normals;  // rows here
  std::vector<Disc> discs;   // in the order of the normals

  explicit DenseCones(const ConeProblem& problem);

  /// x of the impulses of the problem, and back; rows left out are zero.
  VectorX scaled(const VectorX& r) const;
  void unscale(const VectorX& x, VectorX& r) const;
};

}  // namespace lithe
