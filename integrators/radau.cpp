#include "integrators/radau.h"

#include <algorithm>
#include <limits>

#include "engine/archive/archive.h"
#include "engine/base/checks.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr double kSafety = 0.9;
constexpr double kLargestGrowth = 8, kSmallestGrowth = 0.2;  // of a step, by the error
constexpr double kRate = 0.4;                                // of Newton, that the next step should not pass
constexpr double kWorthChanging = 1.2;  // growth below which a step stays, where Newton lives on the old factor
constexpr int kMaxAttempts = 40;
constexpr int kMaxSplits = 12;  // a fixed step that will not converge is halved that often

/// 0.1 relative^(2/3), and absolute in the same proportion.
Tolerance of_estimate(const Tolerance& t) {
  if (t.relative == 0) return {0, 0.1 * std::pow(t.absolute, 2.0 / 3)};
  const double relative = 0.1 * std::pow(t.relative, 2.0 / 3);
  return {relative, t.absolute * relative / t.relative};
}

}  // namespace

Radau::Radau(Parameters parameters) : parameters_(parameters) {
  require::at("Radau", [&] {
    require::not_negative(parameters.step, "step");
    require::not_negative(parameters.first_step, "first_step");
    require::not_negative(parameters.max_step, "max_step");
    require::not_negative(parameters.newton_tolerance, "newton_tolerance");
    require::not_negative(parameters.tolerance.relative, "relative tolerance");
    require::positive(parameters.tolerance.absolute, "absolute tolerance");
  });
  estimate_ = of_estimate(parameters.tolerance);
}

void Radau::prepare(EquationsOfMotion& equations, State& state) {
  const Layout& layout = equations.layout();
  if (!resumes()) statistics_ = {};
  equations_ = &equations;
  projector_.emplace(equations);
  for (VectorX* x : {&v_, &v_dot_, &d_error_, &v_error_, &d_size_, &v_size_}) x->setZero(layout.v_count());
  q_ = state.q;
  lambda_.setZero(layout.row_count());
  if (state.lambda.size() != layout.row_count()) state.lambda.setZero(layout.row_count());
  state.v_dot.resize(layout.v_count());
  projector_->accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
  stages_.prepare(equations, state);
  h_ = parameters_.step > 0 ? parameters_.step : first_step(layout, state);
  h_accepted_ = ratio_accepted_ = 0;
}

/// A hundredth of the time in which the state would change by its own allowance-weighted size (Hairer, Nørsett & Wanner
/// I, II.4).
double Radau::first_step(const Layout& layout, const State& state) {
  if (parameters_.first_step > 0) return parameters_.first_step;
  layout.magnitudes(state.q, d_size_);
  v_size_ = state.v.cwiseAbs();
  const auto ratio = [&](const VectorX& of_d, const VectorX& of_v) {
    return std::max(error_ratio(of_d, d_size_, estimate_), error_ratio(of_v, v_size_, estimate_));
  };
  const double size = ratio(d_size_, v_size_), rate = ratio(state.v, state.v_dot);
  const double h = size > 1e-5 && rate > 1e-5 ? 0.01 * size / rate : 1e-6;
  return parameters_.max_step > 0 ? std::min(h, parameters_.max_step) : h;
}

/// Equal steps up to t_stop, no longer than the one wished for: no sliver at the end, and a factor to keep.
double Radau::natural_step(double left) const {
  const double count = std::ceil(left / h_ - 1e-9);
  return count <= 1 ? left : (std::abs(count * h_ - left) > 1e-9 * left ? left / count : h_);
}

double Radau::error(EquationsOfMotion& equations, const State& start, double h, bool filter) {
  equations.layout().magnitudes(start.q, d_size_);
  v_size_ = start.v.cwiseAbs().cwiseMax(stages_.velocity().cwiseAbs());
  double ratio = 0;
  for (bool again : {false, true}) {
    stages_.estimate(equations, start, h, again, d_error_, v_error_);
    ++statistics_.evaluations;
    const double of_d = error_ratio(d_error_, d_size_, estimate_), of_v = error_ratio(v_error_, v_size_, estimate_);
    statistics_.limiting =
        of_d > of_v ? largest_share(d_error_, d_size_, estimate_) : largest_share(v_error_, v_size_, estimate_);
    ratio = std::max(of_d, of_v);
    if (!filter || !(ratio > 1)) break;  // a stiff transient makes the first estimate too large
  }
  return ratio;
}

/// Gustafsson's predictive control (IV.8, equation 8.25), less where Newton had to work (Gustafsson & Söderlind 1997).
double Radau::next_step(double h, double ratio, bool repeated) {
  const int most = RadauStages::kMaxNewton;
  const double safety = std::min(kSafety, kSafety * (1 + 2 * most) / (stages_.iterations() + 2 * most));
  double growth = safety * std::pow(std::max(ratio, 1e-10), -0.25);
  if (h_accepted_ > 0)
    growth =
        std::min(growth, kSafety * h / h_accepted_ * std::pow(ratio_accepted_ / std::max(ratio * ratio, 1e-20), 0.25));
  // Where Newton bounds the step (stiff forces that turn), it does so before it fails: its rate goes with h to h².
  if (stages_.worst_rate() > 0) growth = std::min(growth, std::sqrt(kRate / stages_.worst_rate()));
  growth = std::clamp(growth, kSmallestGrowth, repeated ? 1 : kLargestGrowth);
  h_accepted_ = h;
  ratio_accepted_ = std::max(ratio, 1e-2);
  if (stages_.worth_keeping() && growth >= 1 && growth <= kWorthChanging) growth = 1;
  return h * growth;
}

/// The end of the step, with consistent accelerations; where friction gives none, those of the last stage.
void Radau::finish(EquationsOfMotion& equations, State& state, double time) {
  equations.layout().retract(state.q, stages_.increment(), q_);
  state.time = time;
  state.q = q_;
  state.v = stages_.velocity();
  v_dot_ = stages_.acceleration();
  lambda_ = stages_.multipliers();
  projector_->accelerations(time, state.q, state.v, v_dot_, lambda_);
  ++statistics_.evaluations;
  ++statistics_.factorizations;
  const bool consistent = v_dot_.allFinite() && lambda_.allFinite();
  if (consistent)
    state.v_dot = v_dot_, state.lambda = lambda_;
  else
    state.v_dot = stages_.acceleration(), state.lambda = stages_.multipliers();
  ++statistics_.steps;
}

StepResult Radau::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  if (!(t_stop > state.time)) return {};
  if (equations_ != &equations) {
    equations_ = &equations;
    projector_.emplace(equations);
    stages_.prepare(equations, state);
  }
  const Layout& layout = equations.layout();
  const bool automatic = parameters_.step == 0, first = h_accepted_ == 0;
  const RadauStages::Target target{parameters_.tolerance,
                                   automatic || parameters_.newton_tolerance > 0 ? parameters_.newton_tolerance : 1e-9};
  const double wished = h_;
  double h = natural_step(t_stop - state.time);
  for (int tries = 1;; ++tries) {
    const bool last = state.time + h >= t_stop - 1e-9 * h;
    const double time = last ? t_stop : state.time + h;
    if (last) h = t_stop - state.time;
    stages_.predict(layout, state, h);
    const bool converged = stages_.solve(equations, state, time, h, target, statistics_);
    double ratio = 0;
    if (converged && automatic) ratio = error(equations, state, h, first || tries > 1);
    if (converged && ratio <= 1) {
      stages_.accept(state, h);
      finish(equations, state, time);
      if (!automatic) return {};
      const double next = next_step(h, ratio, tries > 1);
      h_ = h < 0.999 * wished && tries == 1 ? std::max(wished, next) : next;  // a step cut by t_stop takes nothing back
      if (parameters_.max_step > 0) h_ = std::min(h_, parameters_.max_step);
      return {};
    }
    ++statistics_.rejected;
    if (!converged) ++statistics_.newton_failures;
    const double smallest = 16 * std::numeric_limits<double>::epsilon() * std::abs(time);
    if (tries >= (automatic ? kMaxAttempts : kMaxSplits) || h <= smallest)
      return {StepResult::Outcome::failed, describe(layout, converged, h)};
    if (!converged || !std::isfinite(ratio))
      h *= 0.5;
    else
      h *= first ? 0.1 : std::clamp(kSafety * std::pow(ratio, -0.25), kSmallestGrowth, kSafety);
  }
}

bool Radau::keep(Archive& archive, EquationsOfMotion& equations, const State& /*state*/) {
  archive.same("step", parameters_.step);
  archive.same("first_step", parameters_.first_step);
  archive.same("max_step", parameters_.max_step);
  archive.same("newton_tolerance", parameters_.newton_tolerance);
  archive.same("relative tolerance", parameters_.tolerance.relative);
  archive.same("absolute tolerance", parameters_.tolerance.absolute);
  archive("statistics", statistics_);
  archive("h", h_);
  archive("h_accepted", h_accepted_);
  archive("ratio_accepted", ratio_accepted_);
  archive.group("stages", [&] { stages_.history(archive, equations); });
  return true;
}

/// Why no step of size h was taken, with the coordinate that is to blame.
std::string Radau::describe(const Layout& layout, bool converged, double h) const {
  const int worst = converged ? statistics_.limiting : stages_.worst();
  const std::string where = worst >= 0 ? "; largest in " + layout.velocity_name(worst) : "";
  return (converged ? "the local error stays above the tolerance at steps of "
                    : "Newton does not converge at steps of ") +
         step_text(h) + where;
}

}  // namespace lithe
