#pragma once

#include <string>
#include <vector>

#include "engine/motion/equations_of_motion.h"

namespace lithe {

/// G of the state evaluated last as a dense matrix: all rows, v_count columns. Factorises M there.
MatrixX dense_jacobian(EquationsOfMotion& equations);
/// The numbers of the rows that repeat no others.
std::vector<int> independent_rows(const EquationsOfMotion& equations);

/// Null space and range of rows G, by a rank-revealing QR of Gᵀ with rows scaled to length 1.
class RowSpace {
 public:
  explicit RowSpace(const MatrixX& G);

  int rank() const { return rank_; }
  /// Orthonormal columns Z that span G Z = 0.
  const MatrixX& null_space() const { return null_space_; }
  /// The shortest x with G x = b (of a singular G: in its independent rows).
  VectorX shortest(ConstVectorRef b) const;

 private:
  int rank_ = 0;
  MatrixX null_space_, range_;  // orthonormal; Gᵀ P = range_ triangle_
  MatrixX triangle_;            // upper, rank x rank
  std::vector<int> rows_;       // independent ones, as pivoted
  VectorX row_lengths_;
};

/// One degree of freedom, named after a velocity that can be chosen freely.
struct FreeMotion {
  int velocity;      // index of that velocity
  std::string name;  // "rod: omega_y"
  VectorX motion;    // all velocities while that one is 1 and those of the other free motions are 0
};
/// The free motions at the state evaluated last, ordered by how well their velocities identify the motion. Dense: for
/// up to some thousand velocities.
std::vector<FreeMotion> free_motions(EquationsOfMotion& equations);

}  // namespace lithe
