#include "integrators/explicit_runge_kutta.h"

#include <algorithm>
#include <limits>

#include "engine/checks.h"

namespace lithe {
namespace {

// Dormand & Prince 5(4): the last row of A is also the weights of order 5.
constexpr double kTime[7] = {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1, 1};
constexpr double kA[7][6] = {
    {},
    {1.0 / 5},
    {3.0 / 40, 9.0 / 40},
    {44.0 / 45, -56.0 / 15, 32.0 / 9},
    {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
    {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
    {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84},
};
/// Weights of order 5 less those of order 4.
constexpr double kError[7] = {71.0 / 57600, 0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40};

constexpr double kPositionTolerance = 1e-14;  // |g| after a step, in the units of the rows; or round-off if larger
constexpr int kMaxProjections = 10;
constexpr int kMaxAttempts = 40;
constexpr int kMaxSplits = 12;  // a fixed step that gives no numbers is halved that often

}  // namespace

ExplicitRungeKutta::ExplicitRungeKutta(Parameters parameters) : parameters_(parameters) {
  require::at("ExplicitRungeKutta", [&] {
    require::not_negative(parameters.step, "step");
    require::not_negative(parameters.first_step, "first_step");
    require::not_negative(parameters.max_step, "max_step");
    require::positive(parameters.tolerance.relative + parameters.tolerance.absolute, "tolerance");
  });
}

void ExplicitRungeKutta::prepare(EquationsOfMotion& equations, State& state) {
  const Layout& layout = equations.layout();
  const int nv = layout.v_count(), rows = layout.row_count();
  statistics_ = {};
  equations_ = &equations;
  projector_.emplace(equations);
  for (MatrixX* x : {&d_dot_, &v_dot_}) x->setZero(nv, kStages);
  for (VectorX* x : {&d_, &v_, &d_error_, &v_error_, &d_size_, &v_size_}) x->setZero(nv);
  q_ = state.q;
  lambda_.setZero(rows);
  state.v_dot.resize(nv);
  state.lambda.resize(rows);
  projector_->accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
  h_ = parameters_.step > 0 ? parameters_.step : first_step(layout, state);
  ratio_last_ = 1e-4;
}

/// The step of an explicit Euler method that would err by a hundredth of the allowance, from the size of the first and
/// second derivatives (Hairer, Nørsett & Wanner I, II.4).
double ExplicitRungeKutta::first_step(const Layout& layout, const State& state) {
  if (parameters_.first_step > 0) return parameters_.first_step;
  const Tolerance& tolerance = parameters_.tolerance;
  layout.magnitudes(state.q, d_size_);
  v_size_ = state.v.cwiseAbs();
  const auto ratio = [&](const VectorX& of_d, const VectorX& of_v) {
    return std::max(error_ratio(of_d, d_size_, tolerance), error_ratio(of_v, v_size_, tolerance));
  };
  const double size = ratio(d_size_, v_size_), rate = ratio(state.v, state.v_dot);
  double h = size > 1e-5 && rate > 1e-5 ? 0.01 * size / rate : 1e-6;
  if (parameters_.max_step > 0) h = std::min(h, parameters_.max_step);

  d_ = h * state.v;
  v_ = state.v + h * state.v_dot;
  layout.retract(state.q, d_, q_);
  accelerate(state.time + h, 1);
  d_ = (v_ - state.v) / h;
  v_ = (v_dot_.col(1) - state.v_dot) / h;
  const double largest = std::max(rate, ratio(d_, v_));
  h = std::min(100 * h, largest > 1e-15 ? std::pow(0.01 / largest, 0.2) : 1e-3);
  return parameters_.max_step > 0 ? std::min(h, parameters_.max_step) : h;
}

double ExplicitRungeKutta::natural_step(double left) const {
  if (parameters_.step > 0) {
    // Equal steps up to t_stop, no longer than the given one.
    const double count = std::ceil(left / h_ - 1e-9);
    return count <= 1 ? left : (std::abs(count * h_ - left) > 1e-9 * left ? left / count : h_);
  }
  if (h_ >= left * (1 - 1e-9)) return left;
  return std::min(h_, left / 2);  // no sliver at the end
}

/// d, v and q of stage i from the rates of those before, and its ḋ.
void ExplicitRungeKutta::stage(const Layout& layout, const State& start, double h, int i) {
  d_.setZero();
  v_ = start.v;
  for (int j = 0; j < i; ++j) {
    if (kA[i][j] == 0) continue;
    d_ += (h * kA[i][j]) * d_dot_.col(j);
    v_ += (h * kA[i][j]) * v_dot_.col(j);
  }
  layout.retract(start.q, d_, q_);
}

void ExplicitRungeKutta::accelerate(double time, int i, Projector::Factor factor) {
  projector_->accelerations(time, q_, v_, v_dot_.col(i), lambda_, factor);
  ++statistics_.evaluations;
  if (factor != Projector::Factor::last) ++statistics_.factorizations;
}

ExplicitRungeKutta::Attempt ExplicitRungeKutta::attempt(const Layout& layout, const State& start, double h,
                                                        double time) {
  // 1. Six stages; the first is the end of the step before.
  d_dot_.col(0) = start.v;
  v_dot_.col(0) = start.v_dot;
  for (int i = 1; i < kStages - 1; ++i) {
    stage(layout, start, h, i);
    layout.chart_rates(d_, v_, d_dot_.col(i));
    accelerate(i == kStages - 2 ? time : start.time + kTime[i] * h, i);
    if (!v_dot_.col(i).allFinite()) return Attempt::no_number;
  }
  // 2. The end of the step, moved onto the constraints. The last stage was near enough to give the direction.
  stage(layout, start, h, kStages - 1);
  auto factor = Projector::Factor::fresh;
  if (lambda_.size() > 0) {
    if (!projector_->position(time, q_, kPositionTolerance, kMaxProjections, Projector::Factor::last).converged)
      return Attempt::off_constraints;
    projector_->velocity(time, q_, v_);
    ++statistics_.factorizations;
    factor = Projector::Factor::last;
  }
  // 3. The seventh stage there: it serves the error estimate, gives λ and begins the next step.
  layout.chart_rates(d_, v_, d_dot_.col(kStages - 1));
  accelerate(time, kStages - 1, factor);
  return v_dot_.col(kStages - 1).allFinite() && q_.allFinite() ? Attempt::taken : Attempt::no_number;
}

double ExplicitRungeKutta::error(const Layout& layout, const State& start, double h) {
  d_error_.setZero();
  v_error_.setZero();
  for (int i = 0; i < kStages; ++i) {
    d_error_ += (h * kError[i]) * d_dot_.col(i);
    v_error_ += (h * kError[i]) * v_dot_.col(i);
  }
  layout.magnitudes(q_, d_size_);
  v_size_ = v_.cwiseAbs().cwiseMax(start.v.cwiseAbs());
  return std::max(error_ratio(d_error_, d_size_, parameters_.tolerance),
                  error_ratio(v_error_, v_size_, parameters_.tolerance));
}

StepResult ExplicitRungeKutta::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  if (!(t_stop > state.time)) return {};
  if (equations_ != &equations) {
    equations_ = &equations;
    projector_.emplace(equations);
  }
  const Layout& layout = equations.layout();
  const bool automatic = parameters_.step == 0;
  const double wished = h_;
  double h = natural_step(t_stop - state.time);
  for (int tries = 1;; ++tries) {
    const bool last = state.time + h >= t_stop - 1e-9 * h;
    const double time = last ? t_stop : state.time + h;
    if (last) h = t_stop - state.time;
    const Attempt outcome = attempt(layout, state, h, time);
    double ratio = 0;
    if (outcome == Attempt::taken && automatic) ratio = error(layout, state, h);
    if (outcome == Attempt::taken && ratio <= 1) {
      state.time = time;
      state.q = q_;
      state.v = v_;
      state.v_dot = v_dot_.col(kStages - 1);
      state.lambda = lambda_;
      ++statistics_.steps;
      if (!automatic) return {};
      // Proportional-integral control; no growth right after a rejection.
      const double grow = 0.9 * std::pow(std::max(ratio, 1e-8), -0.17) * std::pow(ratio_last_, 0.04);
      const double next = h * std::clamp(grow, 0.2, tries > 1 ? 1.0 : 5.0);
      h_ = h < 0.999 * wished && tries == 1 ? std::max(wished, next) : next;  // a step cut by t_stop takes nothing back
      if (parameters_.max_step > 0) h_ = std::min(h_, parameters_.max_step);
      ratio_last_ = std::max(ratio, 1e-4);
      return {};
    }
    ++statistics_.rejected;
    const double smallest = 16 * std::numeric_limits<double>::epsilon() * std::abs(time);
    if (tries >= (automatic ? kMaxAttempts : kMaxSplits) || h <= smallest)
      return {StepResult::Outcome::failed, describe(layout, outcome, h)};
    h *= outcome == Attempt::taken && std::isfinite(ratio) ? std::clamp(0.9 * std::pow(ratio, -0.2), 0.1, 0.9) : 0.5;
  }
}

/// Why no step of size h was taken, with the coordinate that is to blame.
std::string ExplicitRungeKutta::describe(const Layout& layout, Attempt attempt, double h) const {
  const std::string size = step_text(h);
  if (attempt == Attempt::off_constraints)
    return "the end of the step cannot be moved onto the constraints at steps of " + size;
  if (attempt == Attempt::no_number) {
    for (int i = 1; i < kStages; ++i)
      for (int k = 0; k < v_dot_.rows(); ++k)
        if (!std::isfinite(v_dot_(k, i)))
          return "the acceleration is no number at steps of " + size + "; first in " + layout.velocity_name(k);
    return "the coordinates are no numbers at steps of " + size;
  }
  const Tolerance& t = parameters_.tolerance;
  Eigen::Index d = 0, v = 0;
  const double d_worst = (d_error_.array().abs() / (t.absolute + t.relative * d_size_.array())).maxCoeff(&d);
  const double v_worst = (v_error_.array().abs() / (t.absolute + t.relative * v_size_.array())).maxCoeff(&v);
  return "the local error stays above the tolerance at steps of " + size + "; largest in " +
         layout.velocity_name(static_cast<int>(d_worst > v_worst ? d : v));
}

}  // namespace lithe
