#pragma once

#include "engine/assembly/evaluator.h"

/// The blocks of an assembled system as dense matrices: slow, obvious, for comparison.
namespace lithe::test {

/// The last [S Gᵀ; G -C] formed by factorize(); rows beyond the constraints are the compliant rows of force elements.
struct DenseMatrix {
  MatrixX all;
  int velocities, rows;  // rows of constraints; what is left over is compliant

  MatrixX S() const { return all.topLeftCorner(velocities, velocities); }
  MatrixX G() const { return all.block(velocities, 0, rows, velocities); }
  int compliant() const { return static_cast<int>(all.rows()) - velocities - rows; }
  MatrixX compliant_G() const { return all.bottomLeftCorner(compliant(), velocities); }
  /// S with the compliant rows eliminated: what they add to the bodies, S + G_cᵀ C⁻¹ G_c.
  MatrixX condensed_S() const;
};
DenseMatrix dense(const Evaluator& evaluator);

}  // namespace lithe::test
