#pragma once

#include <string>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

class ElasticProblem;

/// Eigenpairs of K a = λ M a, ascending; vectors M-orthonormal, n x count, the largest component of each positive.
struct EigenModes {
  VectorX eigenvalues;  // λ = ω², rad²/s²
  MatrixX vectors;
};

enum class EigenMethod { automatic, dense, lanczos };

/// The lowest `count` eigenpairs that are M-orthogonal to the rigid motions of the problem and keep its held means.
/// Shift-invert Lanczos (Spectra) over the problem's Cholesky factor, the rigid motions and every pair found so far
/// projected out; a second search in the complement makes sure that no multiple eigenvalue was left behind.
/// Problems of a few degrees of freedom, or most of the spectrum, go to Eigen's dense solver.
EigenModes lowest_modes(const ElasticProblem& problem, int count, EigenMethod method = EigenMethod::automatic);

/// The same from the matrices: `rigid` (n x k, may have no column) holds the motions that are known to be free of
/// force; K may be singular along those columns only; M is positive definite. `where` names model and support in
/// errors: SceneError if K + shift M is not positive definite (a mechanism).
EigenModes lowest_modes(const SparseMatrix& K, const SparseMatrix& M, const MatrixX& rigid, int count,
                        const std::string& where, EigenMethod method = EigenMethod::automatic);

/// Ritz vectors and values of K, M in the span of independent columns X.
EigenModes ritz_modes(const SparseMatrix& K, const SparseMatrix& M, MatrixX X);

/// Below this, λ is rounding noise of K: the motion meets no stiffness (1e-12 tr K / tr M).
double eigenvalue_noise(const SparseMatrix& K, const SparseMatrix& M);

}  // namespace lithe
