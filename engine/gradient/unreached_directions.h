#pragma once

#include "engine/assembly/evaluator.h"
#include "engine/model/state.h"

namespace lithe {

/// Changes of a state that no parameter of a run may make, since steps from there have no derivative along them: what
/// contacts block, and whatever leads there. Kept as orthonormal rows over the numbers of a state.
class UnreachedDirections {
 public:
  explicit UnreachedDirections(Eigen::Index numbers = 0) : rows_(0, numbers) {}

  bool empty() const { return rows_.rows() == 0; }
  const MatrixX& rows() const { return rows_; }
  /// One more row; nothing, where it is as good as zero or those that there are have it.
  void add(VectorX row);
  /// The change without its part along the rows; exactly zero, where little is left.
  VectorX leave_out(VectorX change) const;
  /// Whether a change, known up to some noise, has a part along the rows.
  bool lead(ConstVectorRef change, double noise) const;

 private:
  MatrixX rows_;
};

/// Points of rigid surfaces, by turns and velocities of the state.
struct TouchingPoints {
  /// Of those that touch and neither close nor part: gaps, their rates and, where they stick, velocities across. The
  /// step that led there left them at zero.
  MatrixX blocked;
  /// How the velocities that contacts remember (contact_numbers()) change with those of their points.
  MatrixX carried;
};
TouchingPoints touching_points(Evaluator& equations, const State& state);

}  // namespace lithe
