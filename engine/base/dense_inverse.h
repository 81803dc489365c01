#pragma once

#include <Eigen/Householder>

#include "engine/base/math.h"

/// Inverses and factors compiled once. Written as an expression, A.inverse() or A.pseudoInverse() costs each source that has it one
/// to five seconds, since Eigen makes the decomposition anew for the type of the expression. The bits are the same.
namespace lithe {

/// A⁻¹ of a square matrix by LU factors with partial pivoting; not finite if A is singular.
MatrixX inverse_of(const MatrixX& A);
/// Moore-Penrose inverse by a complete orthogonal decomposition.
MatrixX pseudo_inverse_of(const MatrixX& A);
/// Q of a QR factorisation in full: qr.householderQ(), written out.
MatrixX written_out(const Eigen::HouseholderSequence<MatrixX, VectorX>& Q);

}  // namespace lithe
