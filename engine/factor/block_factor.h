#pragma once

#include <complex>
#include <vector>

#include "engine/base/math.h"
#include "engine/factor/block_structure.h"
#include "engine/factor/linear_block.h"

namespace lithe {

/// Block LU of [S Gᵀ; G -C] in an order taken from the graph. First every body's linear coordinates (LinearBlock), then
/// frames and rows by a flat list of small fixed-size operations: linear cost for trees, no dense matrix of the
/// system's size, no allocation after construction.
template <class Scalar>
class BlockFactorOf {
 public:
  explicit BlockFactorOf(const BlockStructure& structure);

  /// Leaves rows (by number) out from the next factorisation on: their solution is zero.
  void drop_rows(const std::vector<int>& rows);
  /// Where branches of the motion of closed loops meet, rows whose pivot is near round-off yield: the motion continues
  /// along its velocity, and the next step, away from that position, satisfies the constraints again.
  void factorize(const std::vector<Scalar>& values);
  /// Whether joints close loops: rows may lose rank on the way.
  bool guarded() const { return guarded_; }
  /// Rows whose pivot in the last factorisation was small beside their compliance: they nearly depend on other rows
  /// that are kept. Found only where loops close and rows are dropped.
  const std::vector<int>& weak_rows() const { return weak_rows_; }
  /// In place; x holds velocities, then rows.
  void solve(Scalar* x) const;

  /// Factorises with the rows tested one by one: a row whose pivot falls below `tolerance` times its compliance
  /// `reference[row]` depends on rows eliminated before it. Drops those rows and returns them, sorted.
  std::vector<int> factorize_revealing(const std::vector<Scalar>& values, const VectorX& reference, double tolerance);

 private:
  struct Neighbour {
    int row_block, column_block;  // A_ip and A_pi; the latter becomes P⁻¹ A_pi
    int x, dimension;
    void (*apply)(const Scalar*, Scalar*, int, int);
    void (*forward)(Scalar*, const Scalar*, const Scalar*, int, int);
    void (*backward)(Scalar*, const Scalar*, const Scalar*, int, int);
  };
  struct Update {
    void (*product)(Scalar*, const Scalar*, const Scalar*, int, int, int);
    int target, row_block, column_block, m, n;
  };
  struct Step {
    int dimension, diagonal, x;
    int first_neighbour, last_neighbour, first_update, last_update;
    int first_row;  // number of the first row if this is a constraint, else -1
    void (*invert)(Scalar*, int);
    void (*apply)(const Scalar*, Scalar*, int);
  };
  struct Copy {  // of a block of the values: rows x 6 at `to`, its transpose at `to_transposed` (-1: not needed)
    int from, to, to_transposed, rows;
  };

  struct RowCopy {  // of a coupling of rows: `count` values
    int from, to, count;
  };

  void plan();
  void load(const std::vector<Scalar>& values);
  void clear_dropped();
  void eliminate(const Step& step);
  void add_compliances(const Step& step);
  void invert_guarded(const Step& step);
  void guard(const Step& step);

  const BlockStructure& structure_;
  std::vector<LinearBlock<Scalar>> linear_;
  std::vector<Step> steps_;
  std::vector<Neighbour> neighbours_;
  std::vector<Update> updates_;
  std::vector<Copy> copies_;
  std::vector<std::pair<int, int>> cleared_;  // first, count: what no copy fills
  std::vector<RowCopy> row_coupling_copies_;
  std::vector<int> compliant_;                   // factor diagonal, values index, count: triples
  std::vector<std::vector<int>> schur_targets_;  // of each linear block, by pairs of its parts
  std::vector<Scalar> blocks_;
  bool guarded_ = false;
  VectorX compliance_;  // g S⁻¹ gᵀ of each row, while a guarded factor is made
  std::vector<int> weak_rows_;
  std::vector<int> dropped_;
  std::vector<char> is_dropped_;
  std::vector<int> diagonal_;                  // of each vertex
  std::vector<std::vector<Copy>> row_copies_;  // of each rows vertex, to drop rows
};

using BlockFactor = BlockFactorOf<double>;
using ComplexBlockFactor = BlockFactorOf<std::complex<double>>;
extern template class BlockFactorOf<double>;
extern template class BlockFactorOf<std::complex<double>>;

}  // namespace lithe
