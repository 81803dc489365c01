#include <Eigen/Eigenvalues>

#include "engine/page/run_record_internal.h"

namespace lithe {

BestFit best_fit(const Matrix3X& from, const Matrix3X& to) {
  const Vector3 a = from.rowwise().mean(), b = to.rowwise().mean();
  const Matrix3 S = (from.colwise() - a) * (to.colwise() - b).transpose();
  // The quaternion is the eigenvector of the largest eigenvalue.
  MatrixX N(4, 4);
  const Vector3 twist(S(1, 2) - S(2, 1), S(2, 0) - S(0, 2), S(0, 1) - S(1, 0));
  N(0, 0) = S.trace();
  N.block<3, 1>(1, 0) = twist;
  N.block<1, 3>(0, 1) = twist.transpose();
  N.block<3, 3>(1, 1) = S + S.transpose() - S.trace() * Matrix3::Identity();
  const Vector4 e = Eigen::SelfAdjointEigenSolver<MatrixX>(N).eigenvectors().col(3);
  const Matrix3 R = rotation_matrix(e);
  return {R, b - R * a};
}

/// First a basis that leaves no entry by more than half the tolerance: frame by frame the worst, orthogonal to those
/// before. Then the principal directions within that basis (left singular vectors, from its small matrix of squares),
/// so many of the largest as keep the tolerance.
FittedShapes fit_shapes(const MatrixX& displacements, double tolerance) {
  MatrixX rest = displacements, basis(displacements.rows(), 0);
  while (basis.cols() < displacements.cols()) {
    Eigen::Index row = 0, worst = 0;
    if (rest.cwiseAbs().maxCoeff(&row, &worst) <= tolerance / 2) break;
    VectorX direction = rest.col(worst);
    direction -= basis * (basis.transpose() * direction);  // once more: against round-off
    direction.normalize();
    rest.noalias() -= direction * (direction.transpose() * rest).eval();
    basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
    basis.rightCols<1>() = direction;
  }
  if (basis.cols() == 0) return {basis, MatrixX(0, displacements.cols())};  // it hardly deforms
  const MatrixX within = basis.transpose() * displacements;
  const Eigen::SelfAdjointEigenSolver<MatrixX> squares(MatrixX(within * within.transpose()));  // smallest first
  const MatrixX all = basis * squares.eigenvectors().rowwise().reverse();
  const MatrixX amplitudes = all.transpose() * displacements;
  FittedShapes fitted;
  rest = displacements;
  Eigen::Index count = 0;
  while (count < all.cols() && rest.cwiseAbs().maxCoeff() > tolerance) {
    rest.noalias() -= all.col(count) * amplitudes.row(count);
    ++count;
  }
  fitted.shapes = all.leftCols(count);
  fitted.coordinates = amplitudes.topRows(count);
  return fitted;
}

}  // namespace lithe
