#pragma once

#include <complex>

#include "engine/base/math.h"
#include "engine/factor/linear_pattern.h"

namespace lithe {

/// D = L diag(d) Lᵀ of a symmetric matrix whose entries lie within a few subdiagonals, as those of a cable do: in its
/// own order, O(n band²), without pivots. For a real positive definite D, and for a complex combination of two real
/// ones that are semidefinite (Higham, Accuracy and Stability of Numerical Algorithms, 2002, 10.4).
template <class Scalar>
class BandedCholesky {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  BandedCholesky(int size, const LinearPattern& pattern);

  /// Of a pattern: its subdiagonals are few beside its entries, so that a band is no waste.
  static bool suits(int size, const LinearPattern& pattern);

  /// False: a pivot is no larger than what rounding left of its diagonal entry or, of a real D, negative.
  bool factorize(const Scalar* entries);
  void solve(Eigen::Ref<Matrix> columns) const;

 private:
  static int band_of(const LinearPattern& pattern);

  const int size_, band_;
  Eigen::VectorXi place_;  // of each entry of the pattern in values_
  Matrix values_;          // column j: D_jj … D_j+band,j, then 1 / d_j and L below it
  VectorX diagonal_;       // |D_jj|
};

extern template class BandedCholesky<double>;
extern template class BandedCholesky<std::complex<double>>;

}  // namespace lithe
