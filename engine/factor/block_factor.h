#pragma once

#include <complex>
#include <vector>

#include "engine/base/math.h"
#include "engine/factor/block_structure.h"
#include "engine/factor/graph_topology.h"
#include "engine/factor/linear_block.h"

namespace lithe {

class ThreadTeam;

/// Block LU of [S Gᵀ; G -C] in an order taken from the graph. First every body's linear coordinates (LinearBlock), then
/// frames and rows by a flat list of small fixed-size operations: linear cost for trees, no dense matrix of the
/// system's size, no allocation after construction. Of a plain frame (BlockStructure) the translations are a scalar,
/// eliminated before its turns, a 3 x 3: between ball joints 3 x 3 blocks are left. Branches of large systems may be
/// shared by threads (branches.h); the bits do not depend on their number.
template <class Scalar>
class BlockFactorOf {
 public:
  /// Borrows both; `team` may be null.
  explicit BlockFactorOf(const BlockStructure& structure, ThreadTeam* team = nullptr);

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
  /// `reference[row]` depends on rows eliminated before it. Drops those rows and returns them, sorted. Others whose
  /// pivot falls below `doubt` times it are added to `doubtful`.
  std::vector<int> factorize_revealing(const std::vector<Scalar>& values, const VectorX& reference, double tolerance,
                                       double doubt, std::vector<int>& doubtful);

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
    int target, row_block, column_block, m, d, n;
  };
  struct Step {
    int dimension, diagonal, x;
    int first_neighbour, last_within, last_neighbour;  // those of its own branch first
    int first_update, last_update;
    int first_row;  // number of the first row if this is a constraint, else -1
    void (*invert)(Scalar*, int);
    void (*apply)(const Scalar*, Scalar*, int);
    int first_copy, last_copy, first_cleared, last_cleared;  // blocks that this step is the first to touch
    int mass;              // index in masses_ if it is that of a plain frame's translations, else -1
    bool touches_dropped;  // it or a neighbour of it has a dropped row
  };
  /// The translations of a plain frame: a scalar, and rows that hold its points with ±E. They go first, as scalars.
  struct Mass {
    int value, x;  // where the scalar is among the values; its first unknown
    int first_pin, last_within, last_pin, first_pair, last_pair;  // pins of its own branch first
    Scalar inverse{};
  };
  struct Pin {
    int x, row, sign;  // unknowns and number of the first of three rows
  };
  struct Pair {  // of pins a, b: the block of their rows, of so many rows and columns
    int target, a, b, rows, columns;
    bool fresh;  // nothing is there yet
  };
  struct Copy {  // of a block of the values, m x n, columns `stride` apart, and its transpose (-1: not needed)
    void (*copy)(const Scalar*, Scalar*, Scalar*, int, int, int);
    int from, to, to_transposed, m, n, stride;
  };
  struct Cleared {
    int first, count;
  };
  /// Steps that threads may take together with other branches; or the trunk, which goes last.
  struct Branch {
    int first_step = 0, last_step = 0;
    int first_copy = 0, last_copy = 0, first_cleared = 0, last_cleared = 0;  // before its steps
    std::vector<int> linears;    // bodies whose frames and rows all belong to it
    std::vector<int> compliant;  // factor diagonal, values index, count: triples
    std::vector<int> weak_rows;
  };
  struct Crossing {
    int of, what;  // a step and a neighbour, or a mass and a pin or a pair of pins
  };

  void plan();
  std::vector<double> work(const Elimination& elimination, const std::vector<int>& dimension) const;
  bool is_small(std::size_t linear) const;
  Scalar& entry(int block, int row, int column, int rows);
  template <class Pivot>
  void eliminate_all(const std::vector<Scalar>& values, ThreadTeam* team, const Pivot& pivot);
  void load_first(const Branch& branch, const std::vector<Scalar>& values);
  void load(const Step& step, const std::vector<Scalar>& values);
  void drop(const Step& step);
  void eliminate_mass(const Step& step, const std::vector<Scalar>& values);
  void eliminate_pair(const Mass& mass, const Pair& pair);
  void eliminate(const Step& step);
  void update(int first, int last);
  void cross(const std::vector<Scalar>& values);
  void add_compliance(const Step& step, const Neighbour& neighbour);
  void add_compliance(const Mass& mass, const Pin& pin);
  void invert_guarded(const Step& step, std::vector<int>& weak_rows);
  void guard(const Step& step, std::vector<int>& weak_rows);
  void forward(const Branch& branch, Scalar* x) const;
  void cross_forward(Scalar* x) const;
  void backward(const Branch& branch, Scalar* x) const;
  template <class Job>
  void for_each_branch(ThreadTeam* team, const Job& job) const;

  const BlockStructure& structure_;
  ThreadTeam* team_;
  std::vector<LinearBlock<Scalar>> linear_;
  std::vector<Step> steps_;
  std::vector<Neighbour> neighbours_;
  std::vector<Update> updates_;
  std::vector<Copy> copies_;
  std::vector<Cleared> cleared_;
  std::vector<Branch> branches_;
  Branch trunk_;
  Step crossing_{};  // what branches owe to blocks of the trunk: its copies and updates
  std::vector<Crossing> crossing_neighbours_, crossing_pins_, crossing_pairs_;
  std::vector<Mass> masses_;
  std::vector<Pin> pins_;
  std::vector<Pair> pairs_;
  std::vector<std::vector<int>> schur_targets_;  // of each linear block, by pairs of its parts
  std::vector<Scalar> blocks_;
  bool guarded_ = false;
  VectorX compliance_;  // g S⁻¹ gᵀ of each row, while a guarded factor is made
  std::vector<int> weak_rows_;
  std::vector<int> dropped_;
  std::vector<char> is_dropped_;
};

using BlockFactor = BlockFactorOf<double>;
using ComplexBlockFactor = BlockFactorOf<std::complex<double>>;
extern template class BlockFactorOf<double>;
extern template class BlockFactorOf<std::complex<double>>;

}  // namespace lithe
