#pragma once

#include <Eigen/SparseCholesky>
#include <memory>
#include <vector>

#include "engine/block_structure.h"
#include "engine/math.h"

namespace lithe {

/// One body's linear coordinates, eliminated before all else: with D their block (diagonal, or sparse and positive
/// definite), Y the columns of everything they touch and X its rows, D goes out and -X D⁻¹ Y is left for the rest.
/// A reduced body costs O(n m²) here, m = 6 + rows at its markers: nothing that grows with the nodes of its mesh.
class LinearBlock {
 public:
  /// A neighbour's slice of x and its columns in Y.
  struct Part {
    int x, size, column;
  };

  LinearBlock(const BlockStructure& structure, int linear);

  const std::vector<int>& rows() const { return rows_; }  // rows vertices that the linear coordinates touch
  int neighbour_size() const { return static_cast<int>(schur_.rows()); }
  const std::vector<Part>& parts() const { return parts_; }

  /// Factorises D and forms schur() = -X D⁻¹ Y.
  void factorize(const std::vector<double>& values, const std::vector<char>& dropped_rows);
  const MatrixX& schur() const { return schur_; }
  void forward(double* x) const;   // x_l <- D⁻¹ x_l, x_i -= X_i x_l
  void backward(double* x) const;  // x_l -= D⁻¹ Y x_i

 private:
  void load(const std::vector<double>& values, const std::vector<char>& dropped_rows);
  void solve_linear(Eigen::Ref<MatrixX> columns) const;

  const BlockStructure& structure_;
  BlockStructure::Linear linear_;
  std::vector<int> rows_, jacobians_;
  std::vector<Part> parts_;
  MatrixX X_, T_, schur_;  // m x n, n x m = D⁻¹ Y, m x m
  VectorX inverse_diagonal_;
  struct Sparse {
    Eigen::SparseMatrix<double> matrix;
    std::vector<int> place;  // of each pattern entry in the matrix's values
    Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor;
    std::vector<double> last;  // values of the last factorisation: constant while the step is
  };
  std::unique_ptr<Sparse> sparse_;
  mutable MatrixX permuted_;
};

}  // namespace lithe
