#pragma once

#include <complex>
#include <type_traits>
#include <vector>

#include "engine/base/math.h"
#include "engine/factor/linear_pattern.h"

namespace lithe {

/// D = L diag(d) Lᵀ of a symmetric matrix whose entries lie within a few subdiagonals, as those of a cable do: O(n
/// band²), without pivots. Eliminated from both ends at once, which wait for nothing of each other, to a full block in
/// the middle (van der Vorst 1987, "twisted"). For a real positive definite D, and for a complex combination of two
/// real ones that are semidefinite (Higham, Accuracy and Stability of Numerical Algorithms, 2002, 10.4).
template <class Scalar>
class BandedCholesky {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  BandedCholesky(int size, const LinearPattern& pattern);
  BandedCholesky(const BandedCholesky&) = delete;

  /// Of a pattern: its subdiagonals are few beside its entries, so that a band is no waste.
  static bool suits(int size, const LinearPattern& pattern);

  /// False: a pivot is no larger than what rounding left of its diagonal entry or, of a real D, negative.
  bool factorize(const Scalar* entries);
  void solve(Eigen::Ref<Matrix> columns) const;

 private:
  /// One value of the front's row j, one of the back's, in one register where they are real.
  using Register = double __attribute__((vector_size(16)));
  using Ends = std::conditional_t<std::is_same_v<Scalar, double>, Register, Eigen::Array<Scalar, 2, 1>>;

  static int band_of(const LinearPattern& pattern);
  static Ends ends(Scalar front, Scalar back);
  template <int B>
  bool eliminate_ends();
  bool eliminate_middle();
  template <int B, int Columns>
  void solve(Scalar* x, Eigen::Index stride) const;
  void solve_middle(Scalar* x) const;

  const int size_, band_;
  const int outer_, inner_;          // rows of each end and of the middle, no fewer than the band
  std::vector<int> places_, empty_;  // in values_: of each entry of the pattern; what no entry fills
  std::vector<Ends> values_;  // column j < outer: D_jj … D_j+band,j, then 1 / d_j and L below it; the back mirrored
  Scalar* const middle_;      // behind them: its lower triangle by rows, the same
  std::vector<Scalar> middle_diagonal_;  // its D_jj
  mutable std::vector<Ends> y_;          // of a solution: outer + band rows, a row's columns side by side
};

extern template class BandedCholesky<double>;
extern template class BandedCholesky<std::complex<double>>;

}  // namespace lithe
