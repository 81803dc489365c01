#include "tests/support/dense.h"

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

DenseMatrix dense(const Evaluator& evaluator) {
  const Layout& layout = evaluator.layout();
  const int size = layout.v_count() + layout.row_count() + static_cast<int>(evaluator.workspace().tension.size());
  DenseMatrix out{MatrixX::Zero(size, size), layout.v_count(), layout.row_count()};
  evaluator.visit_blocks([&](int row, int column, ConstMatrixRef block) {
    out.all.block(row, column, block.rows(), block.cols()) += block;
  });
  return out;
}

}  // namespace lithe::test
