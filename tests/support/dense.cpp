#include "tests/support/dense.h"

#include <Eigen/SVD>

namespace lithe::test {

MatrixX DenseMatrix::condensed_S() const {
  MatrixX out = S();
  for (int i = 0; i < compliant(); ++i) {
    const int at = velocities + rows + i;
    const VectorX g = all.row(at).head(velocities);
    out -= g * g.transpose() / all(at, at);
  }
  return out;
}

DenseMatrix dense(const Assembler& assembler) {
  const Layout& layout = assembler.layout();
  const int size = layout.v_count() + layout.row_count() + static_cast<int>(assembler.workspace().tension.size());
  DenseMatrix out{MatrixX::Zero(size, size), layout.v_count(), layout.row_count()};
  assembler.visit_blocks([&](int row, int column, ConstMatrixRef block) {
    out.all.block(row, column, block.rows(), block.cols()) += block;
  });
  return out;
}

VectorX least_norm(const MatrixX& A, const VectorX& b, double tolerance) {
  Eigen::BDCSVD<MatrixX> svd(A, Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(tolerance);
  return svd.solve(b);
}

int rank(const MatrixX& A, double tolerance) {
  Eigen::BDCSVD<MatrixX> svd(A);
  svd.setThreshold(tolerance);
  return static_cast<int>(svd.rank());
}

}  // namespace lithe::test
