#pragma once

#include "engine/motion/equations_of_motion.h"

namespace lithe::lab {

/// [S Gᵀ; G 0] of the last factorize() as a dense matrix; compliant rows of force elements, if any, come last.
MatrixX dense_matrix(const EquationsOfMotion& equations);

/// M, D = ∂r/∂v, K = ∂r/∂q (in the chart at q) and G at the state evaluated last.
struct DenseParts {
  MatrixX M, D, K, G;
};
DenseParts dense_parts(EquationsOfMotion& equations, ConstVectorRef v_dot, ConstVectorRef lambda);

/// The least-norm solution of A x = b, singular values below `cut` times the largest taken for zero; its rank.
struct LeastNorm {
  VectorX x;
  int rank;
};
LeastNorm least_norm(const MatrixX& A, const VectorX& b, double cut);

/// Largest over smallest singular value.
double condition(const MatrixX& A);

}  // namespace lithe::lab
