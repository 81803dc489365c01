#include "tests/support/linear_algebra.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <Eigen/SparseCholesky>

namespace lithe::test {

MatrixX product(const MatrixX& A, const MatrixX& B) { return A * B; }

MatrixX congruence(const MatrixX& T, const MatrixX& A) { return product(T.transpose(), product(A, T)); }

MatrixX solve(const MatrixX& A, const MatrixX& B) { return A.partialPivLu().solve(B); }

MatrixX solve_positive(const MatrixX& A, const MatrixX& B) { return A.llt().solve(B); }

VectorX solve_sparse(const Eigen::SparseMatrix<double>& A, const VectorX& b) {
  return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(A).solve(b);
}

VectorX least_norm(const MatrixX& A, const VectorX& b, double tolerance) {
  Eigen::JacobiSVD<MatrixX> svd(A, Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(tolerance);
  return svd.solve(b);
}

VectorX singular_values(const MatrixX& A) { return Eigen::JacobiSVD<MatrixX>(A).singularValues(); }

int rank(const MatrixX& A, double tolerance) {
  if (A.size() == 0) return 0;
  const VectorX s = singular_values(A);
  return static_cast<int>((s.array() > tolerance * s[0]).count());
}

Eigen::VectorXcd eigenvalues(const MatrixX& A) { return A.eigenvalues(); }

VectorX symmetric_eigenvalues(const MatrixX& K, const MatrixX& M) {
  return Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX>(K, M, Eigen::EigenvaluesOnly).eigenvalues();
}

MatrixX complement(const MatrixX& A) {
  const MatrixX Q = A.householderQr().householderQ();
  return Q.rightCols(A.rows() - A.cols());
}

}  // namespace lithe::test
