#pragma once

#include <string>

#include "bodies/flexible/finite_element_model.h"
#include "bodies/flexible/sparse_cholesky.h"

namespace lithe {

/// An oblique projection x → x - D (Lᵀ x), Lᵀ D = E. Along rigid motions D and L = M D: x becomes M-orthogonal to them.
struct Deflation {
  MatrixX D, L;
  void clean(Eigen::Ref<MatrixX> x) const {
    if (D.cols() > 0) x -= D * (L.transpose() * x);
  }
  /// The same of forces: f → f - L (Dᵀ f), inertia relief.
  void relieve(Eigen::Ref<MatrixX> f) const {
    if (D.cols() > 0) f -= L * (D.transpose() * f);
  }
};

/// Dᵀ M D = E, L = M D, the span of D that of X.
Deflation deflate(const SparseMatrix& M, MatrixX X);
/// X ← X L⁻ᵀ with Xᵀ M X = L Lᵀ, twice: M-orthonormal to round-off. The columns are independent.
void orthonormalise(const SparseMatrix& M, MatrixX& X);
SparseMatrix diagonal_matrix(const VectorX& diagonal);
/// The columns of both.
MatrixX beside(const MatrixX& left, const MatrixX& right);

/// K x = f and K a = λ M a of a body whose `rigid` motions (n x k, maybe no column) alone have no stiffness: one sparse
/// factor of K + shift M, shift = 1e-10 tr K / tr M, serves all solutions. Refers to K and M.
/// SceneError if K + shift M is not positive definite (a mechanism); `where` names model and support.
/// With held means (docs/equations.md 6, fixed interfaces): the free coordinates have Fᵀ x = 0, and K x = f + F λ.
class ElasticProblem {
 public:
  ElasticProblem(const SparseMatrix& K, const SparseMatrix& M, const MatrixX& rigid, std::string where);

  const SparseMatrix& stiffness() const { return K_; }
  const SparseMatrix& mass() const { return M_; }
  const Deflation& rigid() const { return rigid_; }
  double shift() const { return shift_; }
  const std::string& where() const { return where_; }

  /// Holds Fᵀ x = 0 from now on, F (n x c) of full rank; the rigid motions must not be able to move it.
  void hold(MatrixX F);
  /// (K + shift M)⁻¹ b in the free coordinates: M-orthogonal to the rigid motions, or with the means held.
  MatrixX solve(MatrixX b) const;
  /// Takes the rigid motions out of x, or what would move the held means.
  void clean(Eigen::Ref<MatrixX> x) const;
  /// n x k: the free coordinates are those x with conditionsᵀ x = 0.
  const MatrixX& conditions() const { return held_.cols() > 0 ? held_ : rigid_.L; }
  int elastic_count() const { return static_cast<int>(K_.rows() - conditions().cols()); }
  /// Psi: the deflections that move one held mean by one and no other, K Psi = F λ, rigid motions among them.
  const MatrixX& constraint_modes() const { return constraint_modes_; }

  /// K x = f - M D Dᵀ f (inertia relief), x M-orthogonal to the rigid motions. The shift's error is iterated away.
  /// Without regard to held means.
  MatrixX static_deflections(const MatrixX& loads) const;
  /// With held means: K x = f + F λ, Fᵀ x = 0, their constraint forces carry the load. Without, the same as
  /// static_deflections.
  MatrixX deflections(const MatrixX& loads) const;

 private:
  const SparseMatrix& K_;
  const SparseMatrix& M_;
  std::string where_;
  Deflation rigid_;
  double shift_;
  SparseCholesky factor_;
  MatrixX held_;             // F
  MatrixX columns_, small_;  // A and S⁻¹: (K + shift M)⁻¹ with held means is G - A S⁻¹ Aᵀ
  MatrixX constraint_modes_;
};

}  // namespace lithe
