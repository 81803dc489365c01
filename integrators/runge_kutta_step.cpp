#include "integrators/runge_kutta_step.h"

#include <algorithm>

#include "engine/archive/archive.h"

namespace lithe {
namespace {

constexpr double kPositionTolerance = 1e-14;  // |g| after a step, in the units of the rows; or round-off if larger
constexpr int kMaxProjections = 10;

/// Hairer's form of it (Hairer, Nørsett & Wanner I, II.6): y = y₀ + x (F₀ + x' (F₁ + x (F₂ + x' (F₃ + …)))), x' = 1 -
/// x. Leaves y - y₀ in `value` and its derivative by x in `rate`.
void nested_polynomial(const MatrixX& F, double x, VectorX& value, VectorX& rate) {
  const auto last = F.cols() - 1;
  value = F.col(last);
  rate.setZero(F.rows());
  for (auto i = last; i >= 0; --i) {
    const double factor = i % 2 == 0 ? x : 1 - x, slope = i % 2 == 0 ? 1 : -1;
    rate = factor * rate + slope * value;
    value *= factor;
    if (i > 0) value += F.col(i - 1);
  }
}

}  // namespace

RungeKuttaStep::RungeKuttaStep(const RungeKuttaTableau& tableau, EquationsOfMotion& equations)
    : tableau_(tableau),
      equations_(equations),
      layout_(equations.layout()),
      forward_(equations.parts().forward_dynamics),
      projector_(equations) {
  const int nv = layout_.v_count(), rows = layout_.row_count();
  for (MatrixX* x : {&d_dot_, &v_dot_}) x->setZero(nv, static_cast<Eigen::Index>(tableau.a.size()));
  for (VectorX* x : {&d_, &v_, &d_before_, &d_error_, &v_error_, &d_second_, &v_second_, &d_size_, &v_size_, &d_rate_})
    x->setZero(nv);
  q_.setZero(layout_.q_count());
  lambda_.setZero(rows);
  if (tableau.dense.empty()) return;
  for (MatrixX* x : {&d_dense_, &v_dense_}) x->setZero(nv, 3 + static_cast<Eigen::Index>(tableau.dense.size()));
  lambda_dense_.setZero(rows, static_cast<Eigen::Index>(tableau.a.size()) - tableau.stages);
}

void RungeKuttaStep::accelerations(State& state) {
  state.v_dot.resize(layout_.v_count());
  state.lambda.resize(layout_.row_count());
  projector_.accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
}

double RungeKuttaStep::first_step(const State& start, const Tolerance& tolerance, double max_step) {
  layout_.magnitudes(start.q, d_size_);
  v_size_ = start.v.cwiseAbs();
  const auto ratio = [&](const VectorX& of_d, const VectorX& of_v) {
    return std::max(error_ratio(of_d, d_size_, tolerance), error_ratio(of_v, v_size_, tolerance));
  };
  const double size = ratio(d_size_, v_size_), rate = ratio(start.v, start.v_dot);
  double h = size > 1e-5 && rate > 1e-5 ? 0.01 * size / rate : 1e-6;
  if (max_step > 0) h = std::min(h, max_step);

  d_ = h * start.v;
  v_ = start.v + h * start.v_dot;
  layout_.retract(start.q, d_, q_);
  accelerate(start.time + h, 1);
  d_ = (v_ - start.v) / h;
  v_ = (v_dot_.col(1) - start.v_dot) / h;
  const double largest = std::max(rate, ratio(d_, v_));
  h = std::min(100 * h, largest > 1e-15 ? std::pow(0.01 / largest, 1.0 / tableau_.order) : 1e-3);
  return max_step > 0 ? std::min(h, max_step) : h;
}

/// d, v and q of stage i from the rates of those before.
void RungeKuttaStep::stage(const State& start, double h, int i) {
  d_.setZero();
  v_ = start.v;
  for (int j = 0; j < i; ++j) {
    if (tableau_.a[i][j] == 0) continue;
    d_ += (h * tableau_.a[i][j]) * d_dot_.col(j);
    v_ += (h * tableau_.a[i][j]) * v_dot_.col(j);
  }
  layout_.retract(start.q, d_, q_);
}

void RungeKuttaStep::accelerate(double time, int i, Projector::Factor factor) {
  ++evaluations;
  if (forward_) return forward_->accelerations(time, q_, v_, v_dot_.col(i));
  projector_.accelerations(time, q_, v_, v_dot_.col(i), lambda_, factor);
  if (factor != Projector::Factor::last) ++factorizations;
}

RungeKuttaStep::Outcome RungeKuttaStep::attempt(const State& start, double h, double time) {
  const int last = tableau_.stages - 1;
  dense_ready_ = false;
  begin_ = start.time, end_ = time, h_ = h;
  // 1. All stages but the last; the first is the end of the step before.
  d_dot_.col(0) = start.v;
  v_dot_.col(0) = start.v_dot;
  for (int i = 1; i < last; ++i) {
    stage(start, h, i);
    layout_.chart_rates(d_, v_, d_dot_.col(i));
    accelerate(i == last - 1 ? time : start.time + tableau_.time[i] * h, i);
    if (!v_dot_.col(i).allFinite()) return Outcome::no_number;
  }
  d_before_ = d_;
  // 2. The end of the step, moved onto the constraints. The stage before was near enough to give the direction.
  stage(start, h, last);
  auto factor = Projector::Factor::fresh;
  if (forward_) {
    if (!forward_->project(time, q_, v_, kPositionTolerance)) {
      // Shorter steps drift less; where they do not help, it is a singular position: then by the projector from here
      // on.
      constexpr int kMostRefusals = 4;
      if (++refusals_ == kMostRefusals) forward_ = nullptr;
      return Outcome::off_constraints;
    }
    refusals_ = 0;
  } else if (lambda_.size() > 0) {
    if (!projector_.position(time, q_, kPositionTolerance, kMaxProjections, Projector::Factor::last).converged)
      return Outcome::off_constraints;
    projector_.velocity(time, q_, v_);
    ++factorizations;
    factor = Projector::Factor::last;
  }
  // 3. The last stage there: it serves the error estimate, gives λ and begins the next step.
  layout_.chart_rates(d_, v_, d_dot_.col(last));
  accelerate(time, last, factor);
  if (!v_dot_.col(last).allFinite() || !q_.allFinite()) return Outcome::no_number;
  estimate_stiffness();
  return Outcome::taken;
}

double RungeKuttaStep::error(const State& start, double h, const Tolerance& tolerance) {
  for (VectorX* x : {&d_error_, &v_error_, &d_second_, &v_second_}) x->setZero();
  for (int i = 0; i < tableau_.stages; ++i) {
    const double first = tableau_.error[i], second = tableau_.second_error[i];
    if (first != 0) {
      d_error_ += (h * first) * d_dot_.col(i);
      v_error_ += (h * first) * v_dot_.col(i);
    }
    if (second != 0) {
      d_second_ += (h * second) * d_dot_.col(i);
      v_second_ += (h * second) * v_dot_.col(i);
    }
  }
  layout_.magnitudes(q_, d_size_);
  v_size_ = v_.cwiseAbs().cwiseMax(start.v.cwiseAbs());

  const int d = largest_share(d_error_, d_size_, tolerance), v = largest_share(v_error_, v_size_, tolerance);
  const auto share = [&](int i, const VectorX& error, const VectorX& size) {
    return i < 0 ? 0 : std::abs(error[i]) / (tolerance.absolute + tolerance.relative * size[i]);
  };
  component_ = share(d, d_error_, d_size_) > share(v, v_error_, v_size_) ? d : v;

  const auto stretched = [&](const VectorX& error, const VectorX& second, const VectorX& size) {
    const double ratio = error_ratio(error, size, tolerance), lower = error_ratio(second, size, tolerance);
    return lower == 0 ? ratio : ratio * ratio / std::sqrt(ratio * ratio + 0.01 * lower * lower);
  };
  return std::max(stretched(d_error_, d_second_, d_size_), stretched(v_error_, v_second_, v_size_));
}

int RungeKuttaStep::broken() const {
  for (int i = 1; i < tableau_.stages; ++i)
    for (int k = 0; k < v_dot_.rows(); ++k)
      if (!std::isfinite(v_dot_(k, i))) return k;
  return -1;
}

void RungeKuttaStep::finish(State& state, Multipliers multipliers) {
  state.q = q_;
  state.v = v_;
  state.v_dot = v_dot_.col(tableau_.stages - 1);
  if (forward_ && multipliers == Multipliers::later) {
    state.lambda.resize(0);
    return;
  }
  if (forward_) projector_.accelerations(end_, q_, v_, d_rate_, lambda_);
  state.lambda = lambda_;
}

void RungeKuttaStep::history(Archive& archive) {
  archive("refusals", refusals_);
  bool forward = forward_ != nullptr;
  archive("forward", forward);
  if (!forward) forward_ = nullptr;  // it has refused too often
  archive("lambda", lambda_);        // where the next search for reactions begins
  archive("all_evaluations", evaluations);
  archive("all_factorizations", factorizations);
}

void RungeKuttaStep::estimate_stiffness() {
  const int last = tableau_.stages - 1;
  const double moved = (d_ - d_before_).norm();
  const bool told = moved > 1e-14 * (1 + d_.norm());  // above round-off
  stiffness_ = told ? h_ * std::sqrt((v_dot_.col(last) - v_dot_.col(last - 1)).norm() / moved) : 0;
}

/// The stages beyond the step's, and from all of them the polynomials of d and v. λ is the polynomial of degree 4
/// through both ends and those three stages, which are near enough to the motion for it.
bool RungeKuttaStep::prepare_dense(const State& from, const State& to) {
  const double h = h_;
  const int stages = static_cast<int>(tableau_.a.size());
  for (int i = tableau_.stages; i < stages; ++i) {
    stage(from, h, i);
    layout_.chart_rates(d_, v_, d_dot_.col(i));
    accelerate(from.time + tableau_.time[i] * h, i);
    if (!v_dot_.col(i).allFinite()) return false;
    lambda_dense_.col(i - tableau_.stages) = lambda_;
  }
  layout_.difference(from.q, to.q, d_);
  v_ = to.v - from.v;
  const auto coefficients = [&](MatrixX& F, const VectorX& change, const MatrixX& rates) {
    F.col(0) = change;
    F.col(1) = h * rates.col(0) - change;
    F.col(2) = 2 * change - h * (rates.col(0) + rates.col(tableau_.stages - 1));
    for (std::size_t k = 0; k < tableau_.dense.size(); ++k) {
      auto column = F.col(3 + static_cast<Eigen::Index>(k));
      column.setZero();
      for (int j = 0; j < stages; ++j)
        if (tableau_.dense[k][j] != 0) column += (h * tableau_.dense[k][j]) * rates.col(j);
    }
  };
  coefficients(d_dense_, d_, d_dot_);
  coefficients(v_dense_, v_, v_dot_);
  return true;
}

bool RungeKuttaStep::interpolate(const State& from, const State& to, double time, State& out) {
  if (tableau_.dense.empty() || begin_ != from.time || end_ != to.time) return false;
  if (!dense_ready_ && !prepare_dense(from, to)) return false;
  dense_ready_ = true;
  const double x = (time - from.time) / h_;
  nested_polynomial(d_dense_, x, d_, d_rate_);
  out.time = time;
  out.q.resize(from.q.size());
  layout_.retract(from.q, d_, out.q);
  nested_polynomial(v_dense_, x, v_, d_rate_);
  out.v = from.v + v_;
  out.v_dot = d_rate_ / h_;
  out.quarter_turns = from.quarter_turns;
  out.contacts = from.contacts;

  out.lambda.resize(0);
  if (forward_) return true;
  // Lagrange's form for λ.
  const double times[] = {0, tableau_.time[13], tableau_.time[14], tableau_.time[15], 1};
  out.lambda.setZero(from.lambda.size());
  for (int i = 0; i < 5; ++i) {
    double weight = 1;
    for (int j = 0; j < 5; ++j)
      if (j != i) weight *= (x - times[j]) / (times[i] - times[j]);
    if (i == 0)
      out.lambda += weight * from.lambda;
    else if (i == 4)
      out.lambda += weight * to.lambda;
    else
      out.lambda += weight * lambda_dense_.col(i - 1);
  }
  return true;
}

}  // namespace lithe
