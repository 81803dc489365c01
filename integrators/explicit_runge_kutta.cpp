#include "integrators/explicit_runge_kutta.h"

#include <algorithm>
#include <limits>

#include "engine/archive/archive.h"
#include "engine/base/checks.h"

namespace lithe {
namespace {

constexpr int kMaxAttempts = 40;
constexpr int kMaxSplits = 12;  // a fixed step that gives no finite values is halved that often

}  // namespace

ExplicitRungeKutta::ExplicitRungeKutta(Parameters parameters)
    : parameters_(parameters),
      tableau_(parameters.method == Method::dormand_prince8 ? &dormand_prince8() : &dormand_prince5()) {
  require::at("ExplicitRungeKutta", [&] {
    require::not_negative(parameters.step, "step");
    require::not_negative(parameters.first_step, "first_step");
    require::not_negative(parameters.max_step, "max_step");
    require::positive(parameters.tolerance.relative + parameters.tolerance.absolute, "tolerance");
  });
}

std::string ExplicitRungeKutta::name() const { return "explicit Runge-Kutta " + std::string(tableau_->name); }

void ExplicitRungeKutta::prepare(EquationsOfMotion& equations, State& state) {
  if (!resumes()) statistics_ = {};
  stiffness_ = 0;
  step_ = std::make_unique<RungeKuttaStep>(*tableau_, equations);
  step_->accelerations(state);
  if (parameters_.step > 0)
    h_ = parameters_.step;
  else if (parameters_.first_step > 0)
    h_ = parameters_.first_step;
  else
    h_ = step_->first_step(state, parameters_.tolerance, parameters_.max_step);
  ratio_last_ = 1e-4;
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

/// After a step of length h: proportional-integral control; no growth right after a rejection.
double ExplicitRungeKutta::next_step(double h, double ratio, int tries) const {
  const double grow =
      0.9 * std::pow(std::max(ratio, 1e-8), -tableau_->growth) * std::pow(ratio_last_, tableau_->growth_last);
  const double next = h * std::clamp(grow, 0.2, tries > 1 ? 1.0 : 5.0);
  // A step cut by t_stop takes nothing back.
  const double wished = h < 0.999 * h_ && tries == 1 ? std::max(h_, next) : next;
  return parameters_.max_step > 0 ? std::min(wished, parameters_.max_step) : wished;
}

StepResult ExplicitRungeKutta::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  if (!(t_stop > state.time)) return {};
  if (!step_ || &step_->equations() != &equations) step_ = std::make_unique<RungeKuttaStep>(*tableau_, equations);
  const bool automatic = parameters_.step == 0;
  double h = natural_step(t_stop - state.time);
  for (int tries = 1;; ++tries) {
    const bool last = state.time + h >= t_stop - 1e-9 * h;
    const double time = last ? t_stop : state.time + h;
    if (last) h = t_stop - state.time;
    const RungeKuttaStep::Outcome outcome = step_->attempt(state, h, time);
    const bool taken = outcome == RungeKuttaStep::Outcome::taken;
    double ratio = 0;
    if (taken && automatic) {
      ratio = step_->error(state, h, parameters_.tolerance);
      statistics_.limiting = step_->component();
    }
    statistics_.evaluations = step_->evaluations;
    statistics_.factorizations = step_->factorizations;
    if (taken && ratio <= 1) {
      step_->finish(state, multipliers());
      state.time = time;
      stiffness_ = step_->stiffness();
      ++statistics_.steps;
      if (!automatic) return {};
      h_ = next_step(h, ratio, tries);
      ratio_last_ = std::max(ratio, 1e-4);
      return {};
    }
    ++statistics_.rejected;
    const double smallest = 16 * std::numeric_limits<double>::epsilon() * std::abs(time);
    if (tries >= (automatic ? kMaxAttempts : kMaxSplits) || h <= smallest)
      return {StepResult::Outcome::failed, describe(equations.layout(), outcome, h)};
    h *= taken && std::isfinite(ratio) ? std::clamp(0.9 * std::pow(ratio, -1.0 / tableau_->order), 0.1, 0.9) : 0.5;
  }
}

bool ExplicitRungeKutta::keep(Archive& archive, EquationsOfMotion& equations, const State& /*state*/) {
  archive.same("step", parameters_.step);
  archive.same("first_step", parameters_.first_step);
  archive.same("max_step", parameters_.max_step);
  archive.same("relative tolerance", parameters_.tolerance.relative);
  archive.same("absolute tolerance", parameters_.tolerance.absolute);
  archive("statistics", statistics_);
  archive("h", h_);
  archive("ratio_last", ratio_last_);
  archive("stiffness", stiffness_);
  if (!step_ || &step_->equations() != &equations) step_ = std::make_unique<RungeKuttaStep>(*tableau_, equations);
  step_->history(archive);
  return true;
}

void ExplicitRungeKutta::interpolate(const Layout& layout, const State& from, const State& to, double time,
                                     State& out) const {
  if (!step_ || !step_->interpolate(from, to, time, out)) Integrator::interpolate(layout, from, to, time, out);
}

/// Why no step of size h was taken, with the coordinate that is to blame.
std::string ExplicitRungeKutta::describe(const Layout& layout, RungeKuttaStep::Outcome outcome, double h) const {
  const std::string size = step_text(h);
  if (outcome == RungeKuttaStep::Outcome::off_constraints)
    return "the end of the step cannot be moved onto the constraints at steps of " + size;
  if (outcome == RungeKuttaStep::Outcome::no_number) {
    const int broken = step_->broken();
    if (broken < 0) return "the coordinates are not finite at steps of " + size;
    return "the acceleration is not finite at steps of " + size + "; first in " + layout.velocity_name(broken);
  }
  const std::string why = "the local error stays above the tolerance at steps of " + size;
  return statistics_.limiting < 0 ? why : why + "; largest in " + layout.velocity_name(statistics_.limiting);
}

}  // namespace lithe
