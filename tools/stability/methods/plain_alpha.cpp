#include "tools/stability/methods/plain_alpha.h"

#include <Eigen/LU>
#include <algorithm>

#include "engine/motion/projection.h"
#include "tools/stability/methods/dense_equations.h"

namespace lithe::lab {

PlainAlpha::PlainAlpha(Parameters parameters) : parameters_(parameters) {
  const double rho = parameters.spectral_radius;
  am_ = (2 * rho - 1) / (rho + 1);
  af_ = rho / (rho + 1);
  gamma_ = 0.5 + af_ - am_;
  beta_ = 0.25 * (gamma_ + 0.5) * (gamma_ + 0.5);
}

void PlainAlpha::prepare(EquationsOfMotion& equations, State& state) {
  const int nv = equations.layout().v_count(), rows = equations.layout().row_count();
  statistics_ = {};
  for (VectorX* x : {&a_, &a_free_, &v_, &d_, &delta_, &v_dot_, &rv_}) x->setZero(nv);
  for (VectorX* x : {&lambda_, &rl_}) x->setZero(rows);
  state.v_dot.resize(nv);
  state.lambda.setZero(rows);
  Projector(equations).accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
  if (parameters_.start == StartAcceleration::zero) state.v_dot.setZero();
  a_ = state.v_dot;
  q_ = state.q;
}

/// Newton's correction of (d, λ) from (rv_, rl_), in place.
void PlainAlpha::solve(EquationsOfMotion& equations, double h, double per_d) {
  if (parameters_.solver == Solver::engine) return equations.solve(rv_, rl_);
  // In accelerations, with the constraints over h²: without it the powers of h hide what is singular.
  const Eigen::Index nv = rv_.size();
  MatrixX A = dense_matrix(equations);
  VectorX b(A.rows());
  b << rv_, rl_ / (h * h);
  A.leftCols(nv) /= per_d;
  A.bottomRows(rl_.size()) /= h * h;
  const VectorX x =
      parameters_.solver == Solver::dense_lu ? VectorX(A.partialPivLu().solve(b)) : least_norm(A, b, parameters_.cut).x;
  rv_ = x.head(nv) / per_d;
  rl_ = x.tail(rl_.size());
}

StepResult PlainAlpha::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  const Layout& layout = equations.layout();
  const double h = next_step(parameters_.steps, parameters_.step, statistics_.steps, t_stop - state.time);
  const double time = h == t_stop - state.time ? t_stop : state.time + h;
  if (parameters_.at_step_change == StepChange::reset) a_ = state.v_dot;

  // a' = a_free + c v̇',  d = h v + h² ((½ - β) a + β a'),  v' = v + h ((1 - γ) a + γ a')
  const double c = (1 - af_) / (1 - am_), per_d = 1 / (h * h * beta_ * c), rate = gamma_ / (h * beta_);
  a_free_ = (af_ * state.v_dot - am_ * a_) / (1 - am_);
  v_dot_ = state.v_dot;
  if (parameters_.straight_guess) v_dot_ = (-(0.5 - beta_) / beta_ * a_ - a_free_) / c;
  lambda_ = state.lambda;
  bool converged = false;
  for (int k = 0; k < parameters_.max_newton && !converged; ++k) {
    const auto a_new = a_free_ + c * v_dot_;
    d_ = h * state.v + h * h * ((0.5 - beta_) * a_ + beta_ * a_new);
    v_ = state.v + h * ((1 - gamma_) * a_ + gamma_ * a_new);
    layout.retract(state.q, d_, q_);
    equations.evaluate(time, q_, v_, Level::velocity);
    equations.residual(v_dot_, lambda_, rv_);
    equations.constraint(Level::position, rl_);
    rv_ *= -1, rl_ *= -1;
    equations.factorize({1, rate, per_d}, v_dot_, lambda_, &d_);
    solve(equations, h, per_d);
    layout.chart_rates(d_, rv_, delta_);
    v_dot_ += per_d * delta_;
    lambda_ += rl_;
    ++statistics_.newton_iterations;
    if (!v_dot_.allFinite() || !lambda_.allFinite())
      return {StepResult::Outcome::failed, "Newton's corrections are not finite"};
    double size = per_d * delta_.cwiseAbs().maxCoeff(), scale = v_dot_.cwiseAbs().maxCoeff();
    if (rl_.size() > 0) {
      size = std::max(size, rl_.cwiseAbs().maxCoeff());
      scale = std::max(scale, lambda_.cwiseAbs().maxCoeff());
    }
    converged = size < parameters_.newton_tolerance * (1 + scale);
  }
  if (!converged) ++statistics_.newton_failures;
  const VectorX a_new = a_free_ + c * v_dot_;
  d_ = h * state.v + h * h * ((0.5 - beta_) * a_ + beta_ * a_new);
  state.v += h * ((1 - gamma_) * a_ + gamma_ * a_new);
  a_ = a_new;
  layout.retract(state.q, d_, state.q);
  state.time = time;
  state.v_dot = v_dot_;
  state.lambda = lambda_;
  ++statistics_.steps;
  return {};
}

}  // namespace lithe::lab
