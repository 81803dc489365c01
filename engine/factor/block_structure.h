#pragma once

#include <vector>

#include "engine/factor/graph_topology.h"
#include "engine/factor/linear_pattern.h"

namespace lithe {

/// Where each block of [S Gᵀ; G -C] lies in one contiguous array of values (C: compliance of force rows). Frozen by
/// assemble(); blocks are column-major. Constraint and compliant rows are numbered together, constraints first.
struct BlockStructure {
  struct Frame {
    int v;       // first velocity
    int values;  // 6 x 6
    /// Its block is a scalar times the unit matrix (translations) and a 3 x 3 (turns), its couplings know turns alone,
    /// and so do all rows on it but those that hold a point: true of rigid bodies between lower pairs that turn.
    bool plain = false;
  };
  struct Linear {
    int v, size;
    int frame, frames;               // the body's first, an index into frames, -1: none; how many follow each other
    int frame_linear, linear_frame;  // 6 x n, n x 6, one after the other where the body has several frames
    int values;                      // n, or one per entry of the pattern
    const LinearPattern* pattern;    // null: diagonal
  };
  struct Rows {
    int first, count;
    int compliant;  // index of the diagonal of -C in `values`; -1: a constraint
  };
  struct Jacobian {             // G of one constraint or force with respect to one body
    int rows;                   // index into rows
    int frame, values;          // r x 6; -1 without frame
    int linear, linear_values;  // r x n; -1 if the markers do not move with the linear coordinates, or if the row's
                                // Jacobian by another frame of the body has them, whose values then lie there
    int velocity;               // first velocity of the frame, of a body without of the body, for G v and Gᵀ lambda
    int point = 0;              // of a plain frame: G of its translations is ±E in rows 0 to 2, or zero
  };
  struct Coupling {
    int a, b;    // frames, a < b; the list is sorted
    int ab, ba;  // 6 x 6 each
  };
  /// What the tension of compliant rows owes to a joint's multipliers (friction), over the diagonal of C.
  struct RowCoupling {
    int rows, on;  // indices into rows
    int values;    // count of rows x count of on
  };
  std::vector<Frame> frames;
  std::vector<Linear> linears;
  std::vector<Rows> rows;
  std::vector<Jacobian> jacobians;
  std::vector<Coupling> couplings;
  std::vector<RowCoupling> row_couplings;
  int value_count = 0, velocity_count = 0, row_count = 0;

  int reserve(int count) {
    const int at = value_count;
    value_count += count;
    return at;
  }
};

}  // namespace lithe
