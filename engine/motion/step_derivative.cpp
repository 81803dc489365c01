#include "engine/motion/step_derivative.h"

namespace lithe {

void LinearEquations::add_accelerations(MatrixX wanted, MatrixX& turn, MatrixX& velocity, MatrixX& gradient) {
  WeightedSum sum{.rows = WeightedSum::Rows::acceleration, .forces = true, .a = {}, .l = {}, .u = {}};
  accelerations(sum.a, sum.l);
  MatrixX nu = MatrixX::Zero(layout().row_count(), wanted.cols());
  solve_mass(wanted, nu);
  add_weighted(sum, wanted, nu, -1, turn, velocity, gradient);
}

void LinearEquations::add_rate_sums(const MatrixX& nu, MatrixX& turn, MatrixX& velocity, MatrixX& gradient) {
  const WeightedSum sum{.rows = WeightedSum::Rows::velocity, .forces = false, .a = {}, .l = {}, .u = {}};
  add_weighted(sum, MatrixX(turn.rows(), 0), nu, 1, turn, velocity, gradient);
}

}  // namespace lithe
