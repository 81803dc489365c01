#include "integrators/energy_momentum.h"

namespace lithe {
namespace {

constexpr int kMaxNewton = 25;
constexpr double kRest = 1e-12;  // of the kinetic energy

}  // namespace

void EnergyMomentum::prepare(EquationsOfMotion& equations, State& state) {
  const int nv = equations.layout().v_count(), rows = equations.layout().row_count();
  for (VectorX* x :
       {&v_middle_, &d_, &momentum_, &momentum_end_, &momentum_middle_, &slope_, &mass_rate_, &elastic_, &x_})
    x->setZero(nv);
  rate_rows_.setZero(rows);
  q_middle_ = state.q;
  MomentumBalance::prepare(equations, state);
}

/// v_m, the middle and the end of the step; false where a body would turn by half a turn or more.
bool EnergyMomentum::move(const Layout& layout, const State& start, double h) {
  v_middle_ = 0.5 * (start.v + v_);
  d_ = h / 2 * v_middle_;
  for (const auto& b : layout.bodies()) {
    if (!b.frame) continue;
    const double s = d_.segment<3>(b.v + 3).norm();  // sin(|θ|/2)
    if (!(s < 1)) return false;
    if (s > 0) d_.segment<3>(b.v + 3) *= std::asin(s) / s;
  }
  layout.retract(start.q, d_, q_middle_);
  layout.retract(q_middle_, d_, q_);
  return true;
}

/// Momenta and slopes of the step along v_m, the slope's factor where asked for; the end is the state evaluated last.
void EnergyMomentum::evaluate_step(EquationsOfMotion& equations, const State& start, double h, double time) {
  if (deforms_) {
    mass_rate_.setZero();
    evaluate(equations, start.time, start.q, v_middle_);
    add_deformed_momentum(equations, start.q, q_middle_, v_middle_, -1 / h, mass_rate_);
  }
  evaluate(equations, 0.5 * (start.time + time), q_middle_, v_middle_);
  if (deforms_) {
    x_ = v_middle_;
    for (const auto& b : equations.layout().bodies())
      if (b.frame) x_.segment<6>(b.v).setZero();
    multiply_mass(equations, x_, elastic_);
  }
  slope(equations, q_middle_, v_middle_, lambda_, momentum_middle_, slope_);
  if (!equations.velocity_rows().empty()) equations.constraint(Level::velocity, rate_rows_);
  evaluate(equations, time, q_, v_);
  multiply_mass(equations, v_, momentum_end_);
  if (!deforms_) return;
  add_deformed_momentum(equations, q_, q_middle_, v_middle_, 1 / h, mass_rate_);
  slope_ += mass_rate_;
}

/// rv_ = what the balance of momenta lacks, rows of rotations in the axes of the middle.
void EnergyMomentum::balance(const Layout& layout, const State& start, double h) {
  rv_ = momentum_end_ - momentum_;
  for (const auto& b : layout.bodies()) {
    double gained = 0;  // kinetic energy less what its rows account for
    const int count = (b.frame ? 6 : 0) + b.linear;
    if (b.linear > 0)
      gained = 0.5 * (v_.segment(b.v, count).dot(momentum_end_.segment(b.v, count)) -
                      start.v.segment(b.v, count).dot(momentum_.segment(b.v, count)));
    if (b.frame) {
      const Matrix3 A = orientation(q_middle_, b), E = rotation_exp(d_.segment<3>(b.v + 3));
      const Vector3 P = 0.5 * (momentum_.segment<3>(b.v) + momentum_end_.segment<3>(b.v));
      const Vector3 x_rate = v_middle_.segment<3>(b.v);
      rv_.segment<3>(b.v + 3) = E * momentum_end_.segment<3>(b.v + 3) - E.transpose() * momentum_.segment<3>(b.v + 3) +
                                h * (A.transpose() * x_rate.cross(P));
      // Of the slope, A^T (P_p × ẋ) is that of the kinetic energy; the rest is the torque.
      slope_.segment<3>(b.v + 3) -= A.transpose() * momentum_middle_.segment<3>(b.v).cross(x_rate);
    }
    if (b.linear > 0) {
      gained -= v_middle_.segment(b.v, count).dot(rv_.segment(b.v, count));
      gained += h / 2 * v_middle_.segment(b.v, count).dot(mass_rate_.segment(b.v, count));
      const int first = b.v + count - b.linear;
      const double along = v_middle_.segment(first, b.linear).dot(elastic_.segment(first, b.linear));
      // At rest of the elastic coordinates there is no direction to correct along, only round-off to divide.
      const double rest = kRest * std::abs(v_.segment(b.v, count).dot(momentum_end_.segment(b.v, count)));
      if (along > 0)
        rv_.segment(first, b.linear) +=
            gained * along / (along * along + rest * rest) * elastic_.segment(first, b.linear);
    }
  }
  rv_ -= h * slope_;
}

EnergyMomentum::Attempt EnergyMomentum::attempt(EquationsOfMotion& equations, const State& start, double h,
                                                double time) {
  v_ = start.v + h * start.v_dot;
  lambda_ = start.lambda;
  evaluate(equations, start.time, start.q, start.v);
  multiply_mass(equations, start.v, momentum_);
  if (!move(equations.layout(), start, h)) return Attempt::no_convergence;

  const double scale = 1 + start.v.cwiseAbs().maxCoeff();
  Corrections corrections{newton_tolerance_};
  for (int k = 0; k < kMaxNewton && !corrections.done; ++k) {
    if (corrections.wants_factor) {
      evaluate(equations, 0.5 * (start.time + time), q_middle_, v_middle_);
      factorize(equations, {h * h / 4, h / 2, 1}, start, lambda_);
    }
    evaluate_step(equations, start, h, time);
    balance(equations.layout(), start, h);
    rv_ = -rv_;
    equations.constraint(Level::position, rl_);
    rl_ *= -2 / h;
    for (int row : equations.velocity_rows()) rl_[row] = -2 * rate_rows_[row];
    equations.solve(rv_, rl_);
    ++statistics_.newton_iterations;
    v_ += rv_;
    lambda_ += rl_ / h;
    if (!rv_.allFinite() || !rl_.allFinite()) return Attempt::no_number;
    corrections.add(rv_.cwiseAbs().maxCoeff() / scale);
    if (corrections.diverges || !move(equations.layout(), start, h)) return Attempt::no_convergence;
  }
  if (!corrections.done) return Attempt::no_convergence;
  return finish(equations, time, Projector::Factor::fresh) ? Attempt::taken : Attempt::no_number;
}

}  // namespace lithe
