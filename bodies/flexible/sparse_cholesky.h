#pragma once

#include <memory>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// L Lᵀ of a sparse symmetric positive definite matrix (both triangles stored, the lower one is read). The one home of
/// CHOLMOD: supernodal factor, nested-dissection ordering. The matrix itself is not kept.
class SparseCholesky {
 public:
  explicit SparseCholesky(const SparseMatrix& matrix);
  ~SparseCholesky();
  SparseCholesky(const SparseCholesky&) = delete;
  SparseCholesky& operator=(const SparseCholesky&) = delete;

  bool positive_definite() const { return positive_definite_; }
  /// A⁻¹ b, column by column. Only for a positive definite matrix.
  MatrixX solve(const MatrixX& b) const;

 private:
  struct Factor;
  std::unique_ptr<Factor> factor_;
  bool positive_definite_ = false;
};

/// Negative eigenvalues of a symmetric matrix by Sylvester's law: the signs of D in L D Lᵀ. Slower than a Cholesky
/// factor, and unpivoted: for a diagnosis after that has failed.
int count_negative_eigenvalues(const SparseMatrix& matrix);

}  // namespace lithe
