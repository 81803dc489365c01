#include "integrators/lie_bdf.h"

#include <algorithm>
#include <limits>

#include "engine/archive/archive.h"
#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/motion/projection.h"

namespace lithe {
namespace {

constexpr int kMaxNewton = 8;
constexpr int kMaxAttempts = 40;
constexpr int kMaxSplits = 12;              // a fixed step that does not converge is halved that often
constexpr double kTurnedChart = 0.7;        // rad, from which the chart moves on
constexpr double kNearPoint = 0.2;          // of a step: a second point nearer than that to the newest is dropped
constexpr double kFactorReach = 0.25;       // change of w_0 that a factor outlives
constexpr double kRateOfFreshFactor = 0.5;  // assumed for Newton until measured
constexpr double kLeastRate = 0.003;        // that is believed: one far off tells nothing of those near the solution
constexpr double kForgets = 1.2;            // of a rate that was measured in an earlier step
constexpr int kMostUseless = 6;             // then a factor of another step is tried every 2⁵ steps

}  // namespace

LieBdf::LieBdf(Parameters parameters) : parameters_(parameters) {
  require::at("LieBdf", [&] {
    require::not_negative(parameters.step, "step");
    require::not_negative(parameters.first_step, "first_step");
    require::not_negative(parameters.max_step, "max_step");
    require::not_negative(parameters.tolerance.relative, "relative tolerance");
    require::positive(parameters.tolerance.absolute, "absolute tolerance");
    require::positive(parameters.newton_tolerance, "newton_tolerance");
  });
  if (parameters.max_order < 1 || parameters.max_order > 5)
    throw SceneError("max_order is " + std::to_string(parameters.max_order), "LieBdf", "give 1 to 5");
  if (automatic()) return;
  Parameters start = parameters;
  start.step = 0;
  start.max_step = parameters.step;
  starter_ = std::make_unique<LieBdf>(start);
}

void LieBdf::prepare(EquationsOfMotion& equations, State& state) {
  const Layout& layout = equations.layout();
  const int nv = layout.v_count(), rows = layout.row_count();
  if (!resumes()) statistics_ = {};
  for (VectorX* x : {&d_, &v_, &v_dot_, &past_d_rate_, &past_v_rate_, &shift_, &rate_, &increment_, &rv_, &correction_,
                     &d_error_, &v_error_, &d_size_, &v_size_})
    x->setZero(nv);
  for (VectorX* x : {&lambda_, &rl_, &rl2_}) x->setZero(rows);
  q_ = state.q;
  if (state.v_dot.size() != nv) state.v_dot.setZero(nv);
  if (state.lambda.size() != rows) state.lambda.setZero(rows);
  Projector(equations).accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
  factor_weight_ = 0;
  convergence_rate_ = fresh_rate_ = kRateOfFreshFactor;
  made_anew_ = useless_ = 0;
  steps_at_order_ = 0;
  begun_ = state.time;
  last_order_ = 0;
  started_.clear();
  if (starter_) {
    h_ = parameters_.step;
    order_ = parameters_.max_order;
    history_.reset(layout, state.time, state.q);
    history_.push(state.time, state.q, d_, state.v, state.lambda);
    starter_->start(equations, state);
    return;
  }
  h_ = first_step(equations, state);
  begin(layout, state);
}

/// The past before the start, as v and v̇ tell it: it serves the first predictors and error estimates alone.
void LieBdf::begin(const Layout& layout, const State& state) {
  history_.reset(layout, state.time, state.q);
  for (int i = 2; i >= 0; --i) {
    const double t = -i * h_;
    d_ = t * state.v + 0.5 * t * t * state.v_dot;
    v_ = state.v + t * state.v_dot;
    layout.retract(state.q, d_, q_);
    history_.push(state.time + t, q_, d_, v_, state.lambda);
  }
  order_ = 1;
  steps_at_order_ = 0;
  raising_ = true;
  failed_ = false;
}

double LieBdf::natural_step(double left) const {
  if (!automatic()) {
    // Equal steps up to t_stop, no longer than the given one.
    const double count = std::ceil(left / h_ - 1e-9);
    return count <= 1 ? left : (std::abs(count * h_ - left) > 1e-9 * left ? left / count : h_);
  }
  if (h_ >= left * (1 - 1e-9)) return left;
  return std::min(h_, left / 2);  // no sliver at the end
}

/// The first of fixed steps, taken by the automatic method.
StepResult LieBdf::start_step(EquationsOfMotion& equations, State& state, double t_stop) {
  const double h = natural_step(t_stop - state.time);
  const double time = state.time + h >= t_stop - 1e-9 * h ? t_stop : state.time + h;
  started_.clear();
  while (state.time < time) {
    if (StepResult result = starter_->step(equations, state, time); !result.ok()) return result;
    started_.push_back(starter_->last_step());
    started_.back().to = state;
  }
  const IntegratorStatistics& of_start = starter_->statistics();
  const long steps = statistics_.steps;
  statistics_ = of_start;
  statistics_.steps = steps + 1;
  equations.layout().difference(history_.base(), state.q, d_);
  history_.push(state.time, state.q, d_, state.v, state.lambda);
  return {};
}

/// Makes history and order fit a step of h: no point so near the newest that the polynomial amplifies its error; no
/// more points than the chart spans.
void LieBdf::fit_history(const Layout& layout, double h) {
  if (history_.size() > 2 && history_.time(0) - history_.time(1) < kNearPoint * h) history_.drop(1);
  order_ = std::min(order_, history_.size() - 1);
  const double turning = fastest_turning(layout, history_.v(0));
  while (order_ > 1 && turning * (history_.time(0) - history_.time(order_)) > kLargestTurn) --order_;
}

void LieBdf::predict(const Layout& layout, double time) {
  history_.derivative_weights(time, order_, weights_);
  history_.combine_d(weights_, order_, past_d_rate_);
  history_.combine_v(weights_, order_, past_v_rate_);
  // d from the extrapolated velocity rather than extrapolated itself: v then starts with an error of one order less.
  history_.extrapolation_weights(time, order_, error_weights_);
  history_.combine_d(error_weights_, order_ + 1, d_);
  history_.combine_v(error_weights_, order_ + 1, v_);
  layout.chart_rates(d_, v_, rate_);
  d_ = (rate_ - past_d_rate_) / weights_[0];
  shift_.setZero();
  // Higher degrees amplify what Newton has left in λ, from step to step.
  const int degree = std::min(order_, 2);
  history_.extrapolation_weights(time, degree, error_weights_);
  history_.combine_lambda(error_weights_, degree + 1, lambda_);
  derive_velocities(layout);
  layout.retract(history_.base(), d_, q_);
}

/// v = Jr(d) (p_d' + ζ) and v̇ = p_v'.
void LieBdf::derive_velocities(const Layout& layout) {
  v_ = weights_[0] * (d_ - shift_) + past_d_rate_;
  for (const auto& b : layout.bodies()) {
    if (!b.frame) continue;
    const Vector3 turning = v_.segment<3>(b.v + 3);
    v_.segment<3>(b.v + 3) = left_jacobian(d_.segment<3>(b.v + 3)).transpose() * turning;
  }
  v_dot_ = weights_[0] * v_ + past_v_rate_;
}

/// With the factor at hand if it may do; with a new one, from the prediction on, if it does not. Where stiff directions
/// turn, that of the step before is of no use, and finding that out costs two evaluations: it is then tried ever less
/// often.
LieBdf::Newton LieBdf::solve(EquationsOfMotion& equations, const State& start, double time) {
  const Layout& layout = equations.layout();
  predict(layout, time);
  layout.magnitudes(q_, d_size_);
  v_size_ = v_.cwiseAbs().cwiseMax(start.v.cwiseAbs());
  const bool fresh = factor_weight_ == 0 || std::abs(weights_[0] / factor_weight_ - 1) > kFactorReach || made_anew_ > 0;
  if (made_anew_ > 0) --made_anew_;
  const long factors = statistics_.factorizations;
  const Newton result = iterate(equations, start, time, fresh);
  if (!fresh) {
    const bool useful = result == Newton::converged && statistics_.factorizations == factors;
    useless_ = useful ? 0 : std::min(useless_ + 1, kMostUseless);
    if (!useful) made_anew_ = (1 << (useless_ - 1)) - 1;  // once tells nothing: any factor grows old
  }
  if (result == Newton::converged || fresh) return result;
  predict(layout, time);
  return iterate(equations, start, time, true);
}

LieBdf::Newton LieBdf::iterate(EquationsOfMotion& equations, const State& start, double time, bool fresh) {
  const Layout& layout = equations.layout();
  // No correction reaches them: what was extrapolated for them would grow from step to step.
  for (int row : equations.redundant_rows()) lambda_[row] = 0;
  const double w = weights_[0];
  bool renew = fresh;  // the factor is to be made anew: at the start, and where corrections shrink too slowly
  int made_at = -1;    // the iteration that made it; of another step: -1
  double rate_of_new = 0;
  double* rate = &convergence_rate_;
  double last = 0;
  for (int k = 0; k < kMaxNewton; ++k) {
    equations.evaluate(time, q_, v_, Level::velocity);
    ++statistics_.evaluations;
    equations.residual(v_dot_, lambda_, rv_);
    if (renew) {
      // v turns with x by w (x + ω × x / (2 w)): what an increment of ω/w tells the engine.
      increment_ = v_ / w;
      factor_.make(equations, {1, w, w * w}, time, start, q_, v_, v_dot_, lambda_, &increment_);
      ++statistics_.factorizations;
      made_at = k;
      factor_weight_ = w;
      convergence_rate_ = kRateOfFreshFactor;  // in later steps
      rate_of_new = fresh_rate_;
      rate = &rate_of_new;
      fresh_rate_ = std::min(kForgets * fresh_rate_, kRateOfFreshFactor);
    }
    // 1. Dynamics, and G v + ∂g/∂t = 0. A factor of another step is balanced for inertia, the larger part.
    equations.constraint(Level::velocity, rl2_);
    // Before the factor spreads it over all coordinates, a value that is not finite tells where it comes from.
    if (!rv_.allFinite() || !rl2_.allFinite()) return Newton::no_number;
    rv_ *= -2 / (1 + w * w / (factor_weight_ * factor_weight_));
    rl2_ /= -w;
    equations.constraint(Level::position, rl_);
    rl_ = -rl_ - rl2_;
    for (int row : equations.velocity_rows()) rl_[row] = 0;
    equations.solve(rv_, rl2_);
    lambda_ += rl2_;
    layout.chart_rates(d_, rv_, rate_);
    // 2. Positions alone, along the same factor: g = 0.
    correction_.setZero();
    equations.solve(correction_, rl_);
    layout.chart_rates(d_, correction_, increment_);
    shift_ += increment_;
    increment_ += rate_;
    d_ += increment_;
    derive_velocities(layout);
    layout.retract(history_.base(), d_, q_);
    ++statistics_.newton_iterations;

    const double moved = increment_.cwiseAbs().maxCoeff();
    double size = error_ratio(increment_, d_size_, parameters_.tolerance);
    rate_ *= w;
    size = std::max(size, error_ratio(rate_, v_size_, parameters_.tolerance));
    if (!std::isfinite(size) || !std::isfinite(moved)) return Newton::no_number;
    if (k > 0) *rate = std::max(0.3 * *rate, size / last);
    if (made_at >= 0 && k == made_at + 1) fresh_rate_ = std::clamp(size / last, kLeastRate, kRateOfFreshFactor);
    if (*rate < 1 && size * *rate / (1 - *rate) <= parameters_.newton_tolerance) return Newton::converged;
    // Round-off: corrections no longer shrink and are tiny beside the coordinates.
    if (k > 0 && size > 0.3 * last && moved <= 1e-14 * (1 + q_.cwiseAbs().maxCoeff())) return Newton::converged;
    if (k > 0 && size > 2 * last) return Newton::slow;
    renew = k > 0 && size > 0.3 * last;
    last = size;
  }
  return Newton::slow;
}

StepResult LieBdf::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  if (!(t_stop > state.time)) return {};
  const Layout& layout = equations.layout();
  if (fastest_turning(layout, history_.d(0)) > kTurnedChart) history_.recentre(layout);
  if (starter_ && history_.size() <= parameters_.max_order) return start_step(equations, state, t_stop);
  // A step cut by t_stop takes nothing back, but the points it leaves do not bear a much longer one.
  const double wished = h_, turning = fastest_turning(layout, state.v);
  if (!automatic()) order_ = parameters_.max_order;
  fit_history(layout, h_);
  double h = natural_step(t_stop - state.time);
  if (automatic()) h = std::min(h, 2 * (history_.time(0) - history_.time(1)));
  if (turning > 0) h = std::min(h, kLargestTurn / (2 * turning));
  for (int tries = 1;; ++tries) {
    const bool last = state.time + h >= t_stop - 1e-9 * h;
    const double time = last ? t_stop : state.time + h;
    if (last) h = t_stop - state.time;
    const Newton newton = solve(equations, state, time);
    const int order = order_;
    double ratio = 0;
    if (newton == Newton::converged && automatic()) ratio = error(time, order_);
    if (newton == Newton::converged && ratio <= 1) {
      if (automatic()) {
        plan(layout, time, h, ratio);
        if (h < 0.999 * wished && tries == 1) h_ = std::max(wished, h_);
        if (parameters_.max_step > 0) h_ = std::min(h_, parameters_.max_step);
      }
      accept(state, time);
      last_order_ = order;
      started_.clear();
      return {};
    }
    ++statistics_.rejected;
    raising_ = false;
    failed_ = true;
    const double smallest = 16 * std::numeric_limits<double>::epsilon() * std::abs(time);
    if (tries >= (automatic() ? kMaxAttempts : kMaxSplits) || h <= smallest)
      return {StepResult::Outcome::failed, describe(layout, newton, h)};
    if (newton != Newton::converged) {
      ++statistics_.newton_failures;
      factor_weight_ = 0;
      h *= automatic() ? 0.25 : 0.5;
    } else {
      shrink(layout, ratio, time, h, tries);
    }
    if (automatic()) h_ = h;
  }
}

bool LieBdf::keep(Archive& archive, EquationsOfMotion& equations, const State& state) {
  archive.same("step", parameters_.step);
  archive.same("first_step", parameters_.first_step);
  archive.same("max_step", parameters_.max_step);
  archive.same("max_order", parameters_.max_order);
  archive.same("newton_tolerance", parameters_.newton_tolerance);
  archive.same("relative tolerance", parameters_.tolerance.relative);
  archive.same("absolute tolerance", parameters_.tolerance.absolute);
  archive("statistics", statistics_);
  archive("h", h_);
  archive("order", order_);
  archive("steps_at_order", steps_at_order_);
  if (order_ < 0 || order_ > parameters_.max_order)
    throw FileError("the checkpoint's method has order " + std::to_string(order_), archive.source(),
                    "resume from an older one");
  archive("raising", raising_);
  archive("begun", begun_);
  archive("failed", failed_);
  archive("factor_weight", factor_weight_);
  archive("convergence_rate", convergence_rate_);
  archive("fresh_rate", fresh_rate_);
  archive("made_anew", made_anew_);
  archive("useless", useless_);
  archive.group("past", [&] { history_.history(archive); });
  if (starter_) archive.group("starter", [&] { starter_->history(archive, equations, state); });
  if (!archive.loads() && factor_weight_ == 0) factor_.forget();
  factor_.history(archive, equations);
  return true;
}

void LieBdf::accept(State& state, double time) {
  history_.push(time, q_, d_, v_, lambda_);
  state.time = time;
  state.q = q_;
  state.v = v_;
  state.v_dot = v_dot_;
  state.lambda = lambda_;
  ++statistics_.steps;
}

}  // namespace lithe
