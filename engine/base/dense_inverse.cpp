#include "engine/base/dense_inverse.h"

#include "engine/base/dense.h"

namespace lithe {

MatrixX inverse_of(const MatrixX& A) {
  const MatrixX unit = MatrixX::Identity(A.rows(), A.rows());
  return Eigen::PartialPivLU<MatrixX>(A).solve(unit);
}

MatrixX pseudo_inverse_of(const MatrixX& A) {
  const MatrixX unit = MatrixX::Identity(A.rows(), A.rows());
  return Eigen::CompleteOrthogonalDecomposition<MatrixX>(A).solve(unit);
}

MatrixX written_out(const Eigen::HouseholderSequence<MatrixX, VectorX>& Q) { return Q; }

}  // namespace lithe
