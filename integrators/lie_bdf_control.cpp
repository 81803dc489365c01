#include <algorithm>

#include "engine/motion/projection.h"
#include "integrators/lie_bdf.h"

namespace lithe {
namespace {

/// How much longer a step of this order may be that erred by `ratio` of what it may; half of that is aimed at.
double growth(int order, double ratio) { return std::pow(2 * ratio + 1e-6, -1.0 / (order + 1)); }

}  // namespace

double LieBdf::fastest_turning(const Layout& layout, ConstVectorRef v) {
  double fastest = 0;
  for (const auto& b : layout.bodies())
    if (b.frame) fastest = std::max(fastest, v.segment<3>(b.v + 3).squaredNorm());
  return std::sqrt(fastest);
}

/// The step of an implicit Euler method that would err by an eighth of the allowance, from v̇ and its change over a
/// step that moves nothing far.
double LieBdf::first_step(EquationsOfMotion& equations, const State& state) {
  const double longest = parameters_.max_step > 0 ? parameters_.max_step : 1.0;
  if (parameters_.first_step > 0) return std::min(parameters_.first_step, longest);
  const Tolerance& tolerance = parameters_.tolerance;
  equations.layout().magnitudes(state.q, d_size_);
  v_size_ = state.v.cwiseAbs();
  const double rate = std::max(error_ratio(state.v, d_size_, tolerance), error_ratio(state.v_dot, v_size_, tolerance));
  const double probe = std::min(1e-4, 1 / std::max(rate, 1e-10));
  d_ = probe * state.v + 0.5 * probe * probe * state.v_dot;
  v_ = state.v + probe * state.v_dot;
  equations.layout().retract(state.q, d_, q_);
  lambda_ = state.lambda;
  Projector(equations).accelerations(state.time + probe, q_, v_, v_dot_, lambda_);
  v_error_ = (v_dot_ - state.v_dot) / probe;
  const double bend = std::max(error_ratio(state.v_dot, d_size_, tolerance), error_ratio(v_error_, v_size_, tolerance));
  if (!std::isfinite(bend)) return std::min(1e-6, longest);
  return std::min({0.5 / std::sqrt(std::max(bend, 1e-10)), 1e-2, longest});
}

/// Local error over allowance that a step of `order` ending at the present point would have made.
double LieBdf::error(double time, int order) {
  history_.error_weights(time, order, error_weights_);
  history_.combine_d(error_weights_, order + 1, d_error_);
  history_.combine_v(error_weights_, order + 1, v_error_);
  d_error_ += error_weights_[0] * d_;
  v_error_ += error_weights_[0] * v_;
  return std::max(error_ratio(d_error_, d_size_, parameters_.tolerance),
                  error_ratio(v_error_, v_size_, parameters_.tolerance));
}

/// After a step that erred too much: a shorter one, of lower order where that errs less; of order 1 in the end.
void LieBdf::shrink(const Layout& layout, double ratio, double time, double& h, int failures) {
  double grow = growth(order_, ratio);
  if (order_ > 2) {
    const double lower = growth(order_ - 1, error(time, order_ - 1));
    if (lower > grow) grow = lower, --order_;
  }
  if (failures > 2) {
    order_ = 1;
    // Beside a base far away d of a short step is round-off, and over h that of v is above any tolerance.
    history_.recentre(layout);
  }
  steps_at_order_ = 0;
  h *= failures == 1 && std::isfinite(grow) ? std::clamp(0.9 * grow, 0.25, 0.9) : 0.25;
}

/// Order and length of the next step. Steps are kept for as long as they are near the best: the factor lasts, and
/// polynomials through equal steps err least.
void LieBdf::plan(const Layout& layout, double time, double h, double ratio) {
  const int share = largest_share(d_error_, d_size_, parameters_.tolerance);
  statistics_.limiting = error_ratio(d_error_, d_size_, parameters_.tolerance) < ratio
                             ? largest_share(v_error_, v_size_, parameters_.tolerance)
                             : share;
  const double turning = fastest_turning(layout, v_);
  const auto allowed = [&](int order, double grow) {
    return turning > 0 ? std::min(grow, kLargestTurn / ((order + 1) * turning * h)) : grow;
  };
  ++steps_at_order_;
  double grow = allowed(order_, growth(order_, ratio));
  int order = order_;
  if (raising_) {
    raising_ = order_ < parameters_.max_order && (order_ == 1 || error(time, order_ - 1) > ratio);
    if (raising_) {
      ++order_;
      steps_at_order_ = 0;
      h_ = h * std::clamp(grow, 0.5, 2.0);
      return;
    }
  }
  const bool settled = steps_at_order_ > order_;  // the polynomials have steps of one order
  // Not down to 1: there a changed step moves the velocities of stiff constraints by as much as h.
  if (settled && order_ > 2) {
    const double lower = allowed(order_ - 1, growth(order_ - 1, error(time, order_ - 1)));
    if (lower > grow) grow = lower, order = order_ - 1;
  }
  if (settled && order == order_ && order_ < parameters_.max_order && history_.size() >= order_ + 2) {
    const double higher = allowed(order_ + 1, growth(order_ + 1, error(time, order_ + 1)));
    if (higher > 1.1 * grow) grow = higher, order = order_ + 1;
  }
  if (settled) failed_ = false;
  if (order != order_) steps_at_order_ = 0;
  order_ = order;
  if (grow >= 2 && (settled || !failed_))
    h_ = 2 * h;
  else if (grow < 1)
    h_ = h * std::clamp(grow, 0.5, 0.9);
  else
    h_ = settled && grow > 1.2 ? grow * h : h;
}

/// Why no step of size h was taken, with the coordinate that is to blame.
std::string LieBdf::describe(const Layout& layout, Newton newton, double h) const {
  const std::string size = step_text(h);
  if (newton == Newton::converged)
    return "the local error stays above the tolerance at steps of " + size + "; largest in " +
           layout.velocity_name(largest_share(v_error_, v_size_, parameters_.tolerance));
  if (newton == Newton::slow) {
    return "Newton does not converge at steps of " + size + "; largest correction in " +
           layout.velocity_name(largest_share(increment_, d_size_, parameters_.tolerance));
  }
  for (int i = 0; i < rv_.size(); ++i)
    if (!std::isfinite(rv_[i]))
      return "the equations give no finite values at steps of " + size + "; first in " + layout.velocity_name(i);
  for (int i = 0; i < rl2_.size(); ++i)
    if (!std::isfinite(rl2_[i]))
      return "the equations give no finite values at steps of " + size + "; first in " + layout.row_name(i);
  return "the equations give no finite values at steps of " + size;
}

}  // namespace lithe
