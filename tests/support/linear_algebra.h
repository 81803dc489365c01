#pragma once

#include <Eigen/SparseCore>

#include "engine/base/math.h"

/// Dense linear algebra for comparisons, compiled once: each of Eigen's decompositions takes seconds to compile.
namespace lithe::test {

MatrixX product(const MatrixX& A, const MatrixX& B);
/// Tᵀ A T.
MatrixX congruence(const MatrixX& T, const MatrixX& A);

/// A⁻¹ B: by LU factors, or by Cholesky's for a positive definite A.
MatrixX solve(const MatrixX& A, const MatrixX& B);
MatrixX solve_positive(const MatrixX& A, const MatrixX& B);
/// A⁻¹ b of a sparse, symmetric A, by its factors L D Lᵀ.
VectorX solve_sparse(const Eigen::SparseMatrix<double>& A, const VectorX& b);

/// The solution x of A x ≈ b of least norm, by a singular value decomposition.
VectorX least_norm(const MatrixX& A, const VectorX& b, double tolerance = 1e-10);
/// Largest first.
VectorX singular_values(const MatrixX& A);
/// How many of them exceed `tolerance` times the largest.
int rank(const MatrixX& A, double tolerance = 1e-10);

Eigen::VectorXcd eigenvalues(const MatrixX& A);
/// Ascending, of K x = λ M x, symmetric.
VectorX symmetric_eigenvalues(const MatrixX& K, const MatrixX& M);
/// An orthonormal basis of what is perpendicular to the columns of A, which are independent.
MatrixX complement(const MatrixX& A);

}  // namespace lithe::test
