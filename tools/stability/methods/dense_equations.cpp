#include "tools/stability/methods/dense_equations.h"

#include <Eigen/SVD>
#include <algorithm>

namespace lithe::lab {

MatrixX dense_matrix(const EquationsOfMotion& equations) {
  int size = equations.layout().v_count() + equations.layout().row_count();
  equations.visit_blocks([&](int row, int column, ConstMatrixRef block) {
    size = std::max({size, row + static_cast<int>(block.rows()), column + static_cast<int>(block.cols())});
  });
  MatrixX A = MatrixX::Zero(size, size);
  equations.visit_blocks(
      [&](int row, int column, ConstMatrixRef block) { A.block(row, column, block.rows(), block.cols()) += block; });
  return A;
}

DenseParts dense_parts(EquationsOfMotion& equations, ConstVectorRef v_dot, ConstVectorRef lambda) {
  const int nv = equations.layout().v_count(), rows = equations.layout().row_count();
  const auto with = [&](const TangentWeights& weights) {
    equations.factorize(weights, v_dot, lambda, nullptr);
    return dense_matrix(equations);
  };
  // A share of M keeps each factor regular; it is taken out again.
  const MatrixX mass = with({0, 0, 1});
  DenseParts parts;
  parts.M = mass.topLeftCorner(nv, nv);
  parts.G = mass.block(nv, 0, rows, nv);
  parts.D = with({0, 1, 1}).topLeftCorner(nv, nv) - parts.M;
  parts.K = with({1, 0, 1}).topLeftCorner(nv, nv) - parts.M;
  return parts;
}

LeastNorm least_norm(const MatrixX& A, const VectorX& b, double cut) {
  Eigen::JacobiSVD<MatrixX> svd(A, Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(cut);
  return {svd.solve(b), static_cast<int>(svd.rank())};
}

double condition(const MatrixX& A) {
  const VectorX s = Eigen::JacobiSVD<MatrixX>(A).singularValues();
  return s[0] / s[s.size() - 1];
}

}  // namespace lithe::lab
