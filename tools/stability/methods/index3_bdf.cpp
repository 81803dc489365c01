#include "tools/stability/methods/index3_bdf.h"

#include <Eigen/LU>

#include "engine/motion/projection.h"
#include "tools/stability/methods/dense_equations.h"

namespace lithe::lab {
namespace {

constexpr int kMaxNewton = 30;
constexpr double kConverged = 1e-13;  // largest last correction of d and v

}  // namespace

double Index3Bdf::last_condition() const { return condition(matrix_); }

void Index3Bdf::prepare(EquationsOfMotion& equations, State& state) {
  const Layout& layout = equations.layout();
  const int nv = layout.v_count(), rows = layout.row_count();
  statistics_ = {};
  for (VectorX* x : {&d_, &v_dot_, &d_before_, &v_before_}) x->setZero(nv);
  state.v_dot.resize(nv);
  state.lambda.setZero(rows);
  Projector(equations).accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
  q_ = state.q, v_ = state.v, lambda_ = state.lambda;
  rhs_.setZero(2 * nv + rows);
  row_scale_.setOnes(2 * nv + rows);
  column_scale_.setOnes(2 * nv + rows);
  if (parameters_.order == 2) {
    layout.difference(before_.q, state.q, d_before_);
    v_before_ = before_.v;
  }
}

/// The derivative of (d/(b h) - v, r, g) by (d, v, λ), with v̇ = (v - ...)/(b h); b: `share`.
void Index3Bdf::form(EquationsOfMotion& equations, double h, double share) {
  const DenseParts parts = dense_parts(equations, v_dot_, lambda_);
  const int nv = static_cast<int>(v_.size()), rows = static_cast<int>(lambda_.size());
  const double rate = 1 / (share * h);
  matrix_.setZero(2 * nv + rows, 2 * nv + rows);
  matrix_.topLeftCorner(nv, nv) = rate * MatrixX::Identity(nv, nv);
  matrix_.block(0, nv, nv, nv) = -MatrixX::Identity(nv, nv);
  matrix_.block(nv, 0, nv, nv) = parts.K;
  matrix_.block(nv, nv, nv, nv) = rate * parts.M + parts.D;
  matrix_.block(nv, 2 * nv, nv, rows) = parts.G.transpose();
  matrix_.block(2 * nv, 0, rows, nv) = parts.G;
  if (!parameters_.scaled) return;
  // v as d/h, λ as d/h²; the equations likewise: nothing of h is left in the leading terms.
  row_scale_.head(nv).setConstant(h);
  row_scale_.segment(nv, nv).setConstant(h * h);
  column_scale_.segment(nv, nv).setConstant(1 / h);
  column_scale_.tail(rows).setConstant(1 / (h * h));
  matrix_ = (row_scale_.asDiagonal() * matrix_ * column_scale_.asDiagonal()).eval();
}

StepResult Index3Bdf::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  const Layout& layout = equations.layout();
  const int nv = layout.v_count(), rows = layout.row_count();
  const double h = next_step(parameters_.steps, parameters_.step, statistics_.steps, t_stop - state.time);
  const double time = h == t_stop - state.time ? t_stop : state.time + h;
  // d = carry d_before + b h v',  v' = v + carry (v - v_before) + b h v̇'
  const double carry = parameters_.order == 2 ? 1.0 / 3 : 0, share = parameters_.order == 2 ? 2.0 / 3 : 1;

  v_ = state.v;
  d_ = h * state.v;
  lambda_ = state.lambda;
  for (int k = 0; k < kMaxNewton; ++k) {
    layout.retract(state.q, d_, q_);
    v_dot_ = (v_ - state.v - carry * (state.v - v_before_)) / (share * h);
    equations.evaluate(time, q_, v_, Level::velocity);
    rhs_.head(nv) = v_ - (d_ - carry * d_before_) / (share * h);
    equations.residual(v_dot_, lambda_, rhs_.segment(nv, nv));
    equations.constraint(Level::position, rhs_.tail(rows));
    rhs_.tail(nv + rows) *= -1;
    form(equations, h, share);
    const VectorX x = column_scale_.asDiagonal() * matrix_.partialPivLu().solve(row_scale_.asDiagonal() * rhs_);
    d_ += x.head(nv);
    v_ += x.segment(nv, nv);
    lambda_ += x.tail(rows);
    ++statistics_.newton_iterations;
    if (!x.allFinite()) return {StepResult::Outcome::failed, "Newton's corrections are not finite"};
    if (x.head(2 * nv).cwiseAbs().maxCoeff() < kConverged) break;
  }
  v_dot_ = (v_ - state.v - carry * (state.v - v_before_)) / (share * h);
  d_before_ = d_;
  v_before_ = state.v;
  layout.retract(state.q, d_, state.q);
  state.time = time;
  state.v = v_, state.v_dot = v_dot_, state.lambda = lambda_;
  ++statistics_.steps;
  return {};
}

}  // namespace lithe::lab
