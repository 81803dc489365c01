#pragma once

#include <string>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// Eigenpairs of K a = λ M a, ascending; vectors M-orthonormal, n x count, the largest component of each positive.
struct EigenModes {
  VectorX eigenvalues;  // λ = ω², rad²/s²
  MatrixX vectors;
};

enum class EigenMethod { automatic, dense, lanczos };

/// The lowest `count` eigenpairs that are M-orthogonal to the `rigid` columns (n x k, motions known to be free of
/// force; may have no column). K may be singular along those columns only; M is positive definite.
/// Shift-invert Lanczos (Spectra) over one Cholesky factor of K + shift M, the rigid motions and every pair found so
/// far projected out; a second search in the complement makes sure that no multiple eigenvalue was left behind.
/// Problems of a few degrees of freedom, or most of the spectrum, go to Eigen's dense solver.
/// `where` names model and support in errors: SceneError if K + shift M is not positive definite (a mechanism).
EigenModes lowest_modes(const SparseMatrix& K, const SparseMatrix& M, const MatrixX& rigid, int count,
                        const std::string& where, EigenMethod method = EigenMethod::automatic);

/// Deflections X, K X = P loads (n x k): the loads rid of what moves the body along `rigid` (inertia relief), X
/// M-orthogonal to it. Accurate to round-off.
MatrixX static_deflections(const SparseMatrix& K, const SparseMatrix& M, const MatrixX& rigid, const MatrixX& loads,
                           const std::string& where);

/// `modes` (eigenpairs as above) and the static deflections under `loads` (n x k), as Ritz vectors of both together:
/// M-orthonormal, K diagonal, ascending. The loads are first rid of what moves the body along `rigid` (inertia relief);
/// deflections that add less than 1e-12 of a load's compliance to the others are left out.
EigenModes with_static_modes(const SparseMatrix& K, const SparseMatrix& M, const MatrixX& rigid,
                             const EigenModes& modes, const MatrixX& loads, const std::string& where);

/// Below this, λ is rounding noise of K: the motion meets no stiffness (1e-12 tr K / tr M).
double eigenvalue_noise(const SparseMatrix& K, const SparseMatrix& M);

}  // namespace lithe
