#include "tests/joints/friction_checks.h"

#include <gtest/gtest.h>

#include "engine/assembly/evaluator.h"
#include "tests/support/dense.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/motion.h"

namespace lithe::test {
namespace {

void expect_close(const MatrixX& actual, const MatrixX& expected, double tolerance, const char* what) {
  Eigen::Index row, column;
  const double error = (actual - expected).cwiseAbs().maxCoeff(&row, &column) / (1 + expected.cwiseAbs().maxCoeff());
  EXPECT_LT(error, tolerance) << what << " at (" << row << ", " << column << "): " << actual(row, column)
                              << " instead of " << expected(row, column);
}

}  // namespace

void check_friction_tangent(SystemGraph& graph, double tolerance) {
  const System system = assemble(graph);
  Evaluator evaluator(system);
  const Layout& layout = system.layout();
  const int nv = layout.v_count(), rows = layout.row_count();
  RandomNumbers random(17);
  const VectorX still = VectorX::Zero(nv);
  VectorX mask = VectorX::Zero(nv);  // loads have derivatives by frames, not by linear coordinates
  for (const auto& b : layout.bodies())
    if (b.frame) mask.segment<6>(b.v).setOnes();
  for (int k = 0; k < 3; ++k) {
    VectorX q(layout.q_count()), v = random.vector(nv, 2), lambda = random.vector(rows, 5);
    layout.retract(system.initial_state().q, random.vector(nv, 0.4), q);
    const auto residual = [&](const VectorX& moving, const VectorX& multipliers) -> VectorX {
      VectorX out = still;
      evaluator.evaluate(0.1, q, moving, Level::velocity);
      evaluator.residual(still, multipliers, out);
      return out;
    };
    const auto matrix = [&](const TangentWeights& weights) {
      residual(v, lambda);  // tensions belong to these multipliers
      evaluator.factorize(weights, still, lambda, nullptr);
      return dense(evaluator);
    };
    const DenseMatrix moving = matrix({0, 1, 1});
    const MatrixX damping = moving.condensed_S() - matrix({0, 0, 1}).condensed_S();
    MatrixX by_velocity(nv, nv), by_lambda(nv, rows);
    for (int j = 0; j < nv; ++j)
      by_velocity.col(j) = derivative([&](double h) { return residual(v + h * VectorX::Unit(nv, j), lambda); }, 1e-4);
    for (int j = 0; j < rows; ++j)
      by_lambda.col(j) = derivative([&](double h) { return residual(v, lambda + h * VectorX::Unit(rows, j)); }, 1e-4);
    expect_close(mask.asDiagonal() * damping * mask.asDiagonal(), mask.asDiagonal() * by_velocity * mask.asDiagonal(),
                 tolerance, "residual by velocities");
    const int c = moving.compliant();
    const MatrixX C = moving.all.bottomRightCorner(c, c), B = moving.all.block(nv + rows, nv, c, rows);
    expect_close(moving.G().transpose() - product(moving.compliant_G().transpose(), solve(C, B)), by_lambda, tolerance,
                 "residual by multipliers");
  }
}

}  // namespace lithe::test
