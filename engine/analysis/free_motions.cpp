#include "engine/analysis/free_motions.h"

#include <Eigen/QR>
#include <algorithm>

#include "engine/base/dense_inverse.h"

namespace lithe {
namespace {

constexpr double kDependent = 1e-10;  // sine of the angle to the other rows

}  // namespace

MatrixX dense_jacobian(EquationsOfMotion& equations) {
  const int velocities = equations.layout().v_count(), rows = equations.layout().row_count();
  equations.factorize({0, 0, 1}, VectorX::Zero(velocities), VectorX::Zero(rows), nullptr);
  MatrixX G = MatrixX::Zero(rows, velocities);
  equations.visit_blocks([&](int row, int column, ConstMatrixRef block) {
    if (row >= velocities && row < velocities + rows && column < velocities)
      G.block(row - velocities, column, block.rows(), block.cols()) += block;
  });
  return G;
}

std::vector<int> independent_rows(const EquationsOfMotion& equations) {
  const std::vector<int>& redundant = equations.redundant_rows();
  std::vector<int> rows;
  for (int row = 0; row < equations.layout().row_count(); ++row)
    if (!std::binary_search(redundant.begin(), redundant.end(), row)) rows.push_back(row);
  return rows;
}

RowSpace::RowSpace(const MatrixX& G) : row_lengths_(G.rowwise().norm()) {
  const int n = static_cast<int>(G.cols());
  null_space_ = MatrixX::Identity(n, n);
  range_.resize(n, 0);
  triangle_.resize(0, 0);
  if (G.rows() == 0) return;
  for (double& length : row_lengths_)
    if (length == 0) length = 1;
  Eigen::ColPivHouseholderQR<MatrixX> qr((row_lengths_.cwiseInverse().asDiagonal() * G).transpose());
  qr.setThreshold(kDependent);
  rank_ = static_cast<int>(qr.rank());
  const MatrixX Q = written_out(qr.householderQ());
  range_ = Q.leftCols(rank_);
  null_space_ = Q.rightCols(n - rank_);
  triangle_ = qr.matrixR().topLeftCorner(rank_, rank_).template triangularView<Eigen::Upper>();
  for (int i = 0; i < rank_; ++i) rows_.push_back(qr.colsPermutation().indices()[i]);
}

VectorX RowSpace::shortest(ConstVectorRef b) const {
  VectorX y(rank_);
  for (int i = 0; i < rank_; ++i) y[i] = b[rows_[i]] / row_lengths_[rows_[i]];
  triangle_.triangularView<Eigen::Upper>().transpose().solveInPlace(y);
  return range_ * y;
}

std::vector<FreeMotion> free_motions(EquationsOfMotion& equations) {
  const RowSpace rows(dense_jacobian(equations)(independent_rows(equations), Eigen::all));
  const MatrixX& Z = rows.null_space();
  const int count = static_cast<int>(Z.cols());
  std::vector<FreeMotion> motions;
  if (count == 0) return motions;

  // The velocities that are most independent of each other, and the motions that each of them alone makes.
  const Eigen::ColPivHouseholderQR<MatrixX> qr(Z.transpose());
  const auto& order = qr.colsPermutation().indices();
  MatrixX chosen(count, count);
  for (int k = 0; k < count; ++k) chosen.row(k) = Z.row(order[k]);
  const MatrixX motion = Z * Eigen::ColPivHouseholderQR<MatrixX>(chosen).inverse();
  for (int k = 0; k < count; ++k)
    motions.push_back({order[k], equations.layout().velocity_name(order[k]), motion.col(k)});
  return motions;
}

}  // namespace lithe
