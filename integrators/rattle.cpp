#include "integrators/rattle.h"

namespace lithe {
namespace {

constexpr int kMaxNewton = 20;
constexpr int kMaxReactions = 50;             // iterations of the last multipliers where joints rub
constexpr double kFrictionTolerance = 1e-12;  // of their velocities, relative

}  // namespace

void Rattle::prepare(EquationsOfMotion& equations, State& state) {
  const int nv = equations.layout().v_count(), rows = equations.layout().row_count();
  for (VectorX* x :
       {&D_, &d_, &momentum_, &momentum_end_, &slope_, &slope_end_, &mass_rate_, &mass_rate_end_, &launch_})
    x->setZero(nv);
  for (VectorX* x : {&lambda_begin_, &lambda_end_, &rate_rows_}) x->setZero(rows);
  q_middle_ = state.q;
  MomentumBalance::prepare(equations, state);
}

/// Momenta, slopes and mass rates of the step D; the end is the state evaluated last. The mass rates are those of the
/// parabola through beginning, middle and end: exact where M is at most quadratic in the deformation.
void Rattle::evaluate_step(EquationsOfMotion& equations, const State& start, double h, double time) {
  const Layout& layout = equations.layout();
  d_ = h * D_;
  layout.retract(start.q, d_, q_);
  evaluate(equations, start.time, start.q, D_);
  slope(equations, start.q, D_, lambda_begin_, momentum_, slope_);
  if (deforms_) {
    mass_rate_ = (-3 / h) * momentum_;
    mass_rate_end_.setZero();
    add_deformed_momentum(equations, start.q, q_, D_, 1 / h, mass_rate_end_);
    d_ *= 0.5;
    layout.retract(start.q, d_, q_middle_);
    d_ *= 2;
    evaluate(equations, start.time, q_middle_, D_);
    add_deformed_momentum(equations, q_middle_, start.q, D_, 4 / h, mass_rate_);
    add_deformed_momentum(equations, q_middle_, q_, D_, -4 / h, mass_rate_end_);
  }
  evaluate(equations, time, q_, D_);
  multiply_mass(equations, D_, momentum_end_);
  if (!deforms_) return;
  add_deformed_momentum(equations, q_, start.q, D_, -1 / h, mass_rate_);
  mass_rate_end_ += (3 / h) * momentum_end_;
  slope_ += mass_rate_;
}

/// The velocity D of the step and λ₊ by Newton on the first row of equations.
bool Rattle::solve_step_velocity(EquationsOfMotion& equations, const State& start, double h, double time) {
  const Layout& layout = equations.layout();
  const std::vector<int>& rolling = equations.velocity_rows();
  D_ = start.v + 0.5 * h * start.v_dot;
  lambda_begin_ = start.lambda;
  evaluate(equations, start.time, start.q, D_);
  multiply_mass(equations, start.v, launch_);

  const double scale = 1 + start.v.cwiseAbs().maxCoeff();
  Corrections corrections{newton_tolerance_};
  for (int k = 0; k < kMaxNewton; ++k) {
    if (corrections.wants_factor && !corrections.done) {
      evaluate(equations, start.time, start.q, D_);
      factorize(equations, {0, h / 2, 1}, start, lambda_begin_);
    }
    evaluate_step(equations, start, h, time);
    if (corrections.done) return true;
    rv_ = 0.5 * (momentum_ + momentum_end_);
    for (const auto& b : layout.bodies())
      if (b.frame)
        rv_.segment<3>(b.v + 3) = right_jacobian_inverse(d_.segment<3>(b.v + 3)) * rv_.segment<3>(b.v + 3).eval();
    rv_ = launch_ + h / 2 * slope_ - rv_;
    equations.constraint(Level::position, rl_);
    rl_ /= -h;
    if (!rolling.empty()) {
      equations.constraint(Level::velocity, rate_rows_);
      for (int row : rolling) rl_[row] = -rate_rows_[row] / 2;
      evaluate(equations, start.time, start.q, D_);
      equations.constraint(Level::velocity, rate_rows_);
      for (int row : rolling) rl_[row] -= rate_rows_[row] / 2;
    }
    equations.solve(rv_, rl_);
    ++statistics_.newton_iterations;
    D_ += rv_;
    lambda_begin_ += 2 / h * rl_;
    if (!rv_.allFinite() || !rl_.allFinite()) return false;
    corrections.add(rv_.cwiseAbs().maxCoeff() / scale);
    if (corrections.diverges) return false;
  }
  return false;
}

/// v' and λ₋ from the second row of equations: linear, but for friction that depends on λ₋. The state evaluated last is
/// the end at D.
bool Rattle::solve_end_velocity(EquationsOfMotion& equations, const State& start, double h) {
  launch_ += h / 2 * slope_;
  for (const auto& b : equations.layout().bodies())
    if (b.frame)
      launch_.segment<3>(b.v + 3) = rotation_exp(-d_.segment<3>(b.v + 3)) * launch_.segment<3>(b.v + 3).eval();
  v_ = D_;
  lambda_end_ = lambda_begin_;
  for (int k = 0; k < kMaxReactions; ++k) {
    multiply_mass(equations, v_, rv_);
    slope(equations, q_, D_, lambda_end_, momentum_end_, slope_end_);
    if (deforms_) slope_end_ += mass_rate_end_;
    rv_ = launch_ + h / 2 * slope_end_ - rv_;
    rl_.setZero();
    if (k == 0) {
      equations.constraint(Level::velocity, rl_);  // v' = D so far
      rl_ = -rl_;
    }
    if (k == 0 || equations.reacts()) factorize(equations, {0, 0, 1}, start, lambda_end_);
    equations.solve(rv_, rl_);
    v_ += rv_;
    lambda_end_ += 2 / h * rl_;
    if (!rv_.allFinite() || !rl_.allFinite()) return false;
    if (!equations.reacts() || rv_.cwiseAbs().maxCoeff() <= kFrictionTolerance * (1 + v_.cwiseAbs().maxCoeff()))
      return true;
  }
  return false;
}

Rattle::Attempt Rattle::attempt(EquationsOfMotion& equations, const State& start, double h, double time) {
  if (!solve_step_velocity(equations, start, h, time)) return Attempt::no_convergence;
  if (!solve_end_velocity(equations, start, h)) return Attempt::no_convergence;
  // Accelerations and multipliers of the end itself: λ₊ and λ₋ each lie h beside them.
  lambda_ = lambda_end_;
  return finish(equations, time, Projector::Factor::last) ? Attempt::taken : Attempt::no_number;
}

}  // namespace lithe
