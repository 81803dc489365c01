#pragma once

#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <complex>
#include <memory>
#include <optional>
#include <type_traits>
#include <vector>

#include "engine/base/math.h"
#include "engine/factor/banded_cholesky.h"
#include "engine/factor/block_structure.h"

namespace lithe {

/// One body's linear coordinates, eliminated first: with D their block (diagonal, full, or sparse), Y the columns of
/// everything they couple to and X its rows, eliminating D adds -X D⁻¹ Y to the rest. A reduced body costs
/// O(n m²) here, m = 6 + rows at its markers: nothing that grows with the nodes of its mesh.
///
/// Load and spin may soften D = K + M/h² until it is indefinite: a sparse D then goes to LU with pivots instead of
/// Cholesky. A narrow D has a factor of its band. If D is singular to round-off, every solution is NaN, which an
/// integrator treats as a failed step.
template <class Scalar>
class LinearBlock {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  /// A neighbour's slice of x and its columns in Y.
  struct Part {
    int x, size, column;
  };

  LinearBlock(const BlockStructure& structure, int linear);

  const std::vector<int>& rows() const { return rows_; }  // rows vertices that the linear coordinates touch
  int neighbour_size() const { return static_cast<int>(schur_.rows()); }
  const std::vector<Part>& parts() const { return parts_; }

  /// Factorises D and forms schur() = -X D⁻¹ Y.
  void factorize(const std::vector<Scalar>& values, const std::vector<char>& dropped_rows);
  const Matrix& schur() const { return schur_; }
  void forward(Scalar* x) const;   // x_l <- D⁻¹ x_l, x_i -= X_i x_l
  void backward(Scalar* x) const;  // x_l -= D⁻¹ Y x_i

 private:
  void load(const std::vector<Scalar>& values, const std::vector<char>& dropped_rows);
  void solve_linear(Eigen::Ref<Matrix> columns) const;
  void factorize_full();
  void factorize_sparse();
  bool has_sound_pivots() const;
  bool full() const { return full_.cols() > 0; }

  const BlockStructure& structure_;
  BlockStructure::Linear linear_;
  std::vector<int> rows_, jacobians_;
  std::vector<Part> parts_;
  Matrix X_, T_, schur_;           // m x n, n x m = D⁻¹ Y, m x m
  int used_ = 0, used_count_ = 0;  // columns of X_ from the first to the last that is not zero: few of a long cable
  Vector inverse_diagonal_;
  struct Sparse {
    using Entries = Eigen::SparseMatrix<Scalar>;
    static constexpr bool kReal = std::is_same_v<Scalar, double>;
    Entries matrix;          // lower triangle; complex: all, for Cholesky would take it for Hermitian
    std::vector<int> place;  // of each pattern entry in the matrix's values; complex: and of its mirror image
    std::conditional_t<kReal, Eigen::SimplicialLLT<Entries, Eigen::Lower>, Eigen::SparseLU<Entries>> factor;
    std::optional<BandedCholesky<Scalar>> band;         // takes the place of `factor`
    std::unique_ptr<Eigen::SparseLU<Entries>> pivoted;  // made where these fail first
    bool is_pivoted = false;                            // who solves
    std::vector<Scalar> last;                           // values of the last factorisation: constant while the step is
  };
  std::unique_ptr<Sparse> sparse_;
  Matrix full_;  // D where every entry of its pattern is there: may be indefinite, beyond a buckling load
  Eigen::PartialPivLU<Matrix> full_factor_;
  bool singular_ = false;
  mutable Matrix permuted_;
};

extern template class LinearBlock<double>;
extern template class LinearBlock<std::complex<double>>;

}  // namespace lithe
