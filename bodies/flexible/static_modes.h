#pragma once

#include "bodies/flexible/eigen_modes.h"
#include "bodies/flexible/elastic_problem.h"

namespace lithe {

/// Those of the shapes that store energy: rigid motions, up to rounding noise of K, are left out.
MatrixX straining(const ElasticProblem& problem, MatrixX shapes);

/// What `shapes` (n x k, without rigid content) add to the M-orthonormal columns `known`, M-orthonormal. Shapes are
/// taken with unit strain energy; a pivoted Cholesky factor of their energies drops those of which less than 1e-10 is
/// new (docs/equations.md 6).
MatrixX added_directions(const ElasticProblem& problem, const MatrixX& known, MatrixX shapes);

/// `modes` and what `shapes` add to them, as Ritz vectors of both: M-orthonormal, K diagonal, ascending.
EigenModes joined(const ElasticProblem& problem, const EigenModes& modes, const MatrixX& shapes);

/// Block Krylov space of the loads about s = 0: K⁻¹ F, K⁻¹ M K⁻¹ F, ..., each block orthonormal to those before.
/// 2 `blocks` moments of the compliance Fᵀ (K - ω² M)⁻¹ F are those of the whole mesh (Bai, Krylov subspace techniques
/// for reduced-order modeling, 2002).
MatrixX krylov_shapes(const ElasticProblem& problem, const MatrixX& loads, int blocks);

/// Craig-Bampton shapes of the problem with its held means: the lowest `count` modes of fixed interfaces, then the
/// constraint modes (Craig & Bampton 1968). Rigid motions are among their combinations.
MatrixX craig_bampton_shapes(const ElasticProblem& problem, int count);

}  // namespace lithe
