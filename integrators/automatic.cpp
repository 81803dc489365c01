#include "integrators/automatic.h"

#include <algorithm>

#include "engine/archive/archive.h"
#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/lie_bdf.h"
#include "integrators/radau.h"

namespace lithe {
namespace {

/// What Automatic knows of each method, measured on the charts in docs/charts.
struct Traits {
  double share;  // of the tolerance, that its steps are held to
  int trial;     // steps of a trial, to get into its stride
  int wait;      // steps before the others are tried in any case; doubled where that changed nothing
  double evaluation, iteration, factorization;  // work, in evaluations of accelerations
};
constexpr Traits kTraits[] = {
    {0.1, 10, 120, 1, 0, 0},        // a factorisation of M goes with each evaluation
    {0.003, 30, 120, 0, 1.1, 0.8},  // it starts at order 1
    {0.1, 5, 30, 0.5, 2, 0.5},
};
constexpr double kForwardWork =
    0.25;                      // of an explicit evaluation where ForwardDynamics serves: trees 0.35, planes 0.16
constexpr int kBlock = 5;      // steps that a pace is measured over
constexpr int kHeldSteps = 8;  // with the step near the limit of stability, before the others are tried
constexpr int kCalmSteps = 4;  // away from it: the count begins anew
constexpr int kHeldShare = 5;  // of the wait, where stability holds the step
constexpr int kLongestWait = 1 << 20;

IntegratorStatistics sum(const IntegratorStatistics& a, const IntegratorStatistics& b) {
  return {.steps = a.steps + b.steps,
          .rejected = a.rejected + b.rejected,
          .newton_iterations = a.newton_iterations + b.newton_iterations,
          .factorizations = a.factorizations + b.factorizations,
          .evaluations = a.evaluations + b.evaluations,
          .newton_failures = a.newton_failures + b.newton_failures,
          .limiting = b.limiting};
}

}  // namespace

Automatic::Automatic(Parameters parameters) : parameters_(parameters) {
  require::at("Automatic", [&] {
    require::not_negative(parameters.tolerance.relative, "relative tolerance");
    require::not_negative(parameters.tolerance.absolute, "absolute tolerance");
    require::positive(parameters.tolerance.relative + parameters.tolerance.absolute, "tolerance");
    require::not_negative(parameters.first_step, "first_step");
    require::not_negative(parameters.max_step, "max_step");
  });
}

Automatic::~Automatic() = default;

Integrator& Automatic::at_work() const {
  if (method_ == Method::lie_bdf) return *bdf_;
  if (method_ == Method::radau) return *radau_;
  return *explicit_;
}

double Automatic::current_step() const {
  if (method_ == Method::lie_bdf) return bdf_->current_step();
  if (method_ == Method::radau) return radau_->current_step();
  return explicit_->current_step();
}

double Automatic::work() const {
  const IntegratorStatistics& s = at_work().statistics();
  const Traits& t = kTraits[place(method_)];
  const double evaluation = method_ == Method::explicit_runge_kutta ? explicit_work_ : t.evaluation;
  return evaluation * static_cast<double>(s.evaluations) + t.iteration * static_cast<double>(s.newton_iterations) +
         t.factorization * static_cast<double>(s.factorizations);
}

void Automatic::prepare(EquationsOfMotion& equations, State& state) {
  statistics_ = {};
  switches_ = 0;
  to_try_.clear();
  to_try_.reserve(kMethods);
  step_.fill(parameters_.first_step);
  pace_.fill(0);
  wait_ = {kTraits[0].wait, kTraits[1].wait, kTraits[2].wait};
  held_steps_ = calm_steps_ = 0;
  explicit_work_ =
      equations.parts().forward_dynamics ? kForwardWork : kTraits[place(Method::explicit_runge_kutta)].evaluation;
  incumbent_ = Method::explicit_runge_kutta;
  change(incumbent_, equations, state);
}

/// Hands the state to a method.
void Automatic::change(Method method, EquationsOfMotion& equations, State& state) {
  before_ = statistics_;
  method_ = method;
  const double share = kTraits[place(method)].share, first_step = begun_with_ = step_[place(method)];
  const Tolerance tolerance{.relative = share * parameters_.tolerance.relative,
                            .absolute = share * parameters_.tolerance.absolute};
  const auto make = [&]<class T>(std::unique_ptr<T>& made, typename T::Parameters parameters) {
    parameters.tolerance = tolerance;
    parameters.first_step = first_step;
    parameters.max_step = parameters_.max_step;
    made = std::make_unique<T>(parameters);
  };
  if (method == Method::lie_bdf) make(bdf_, {});
  if (method == Method::radau) make(radau_, {});
  if (method == Method::explicit_runge_kutta) make(explicit_, {.method = ExplicitRungeKutta::Method::dormand_prince8});
  at_work().start(equations, state);
  fresh_ = true;
  steps_ = 0;
  block_time_ = state.time;
  block_work_ = work();
}

StepResult Automatic::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  if (!(t_stop > state.time)) return {};
  std::string why;
  StepResult result;
  for (int failed = 0;; ++failed) {
    fresh_ = false;
    result = at_work().step(equations, state, t_stop, multipliers());
    statistics_ = sum(before_, at_work().statistics());
    if (result.ok()) break;
    why += (failed > 0 ? "; " : "") + at_work().name() + ": " + result.why;
    if (failed + 1 == kMethods) return {StepResult::Outcome::failed, why};
    // The next method from the same state; it keeps the scene.
    to_try_.clear();
    incumbent_ = static_cast<Method>((place(method_) + 1) % kMethods);
    ++switches_;
    change(incumbent_, equations, state);
  }
  if (!result.why.empty()) steps_ = -2 * kBlock;
  watch(equations, state);
  return result;
}

/// Whether the explicit step has for a while been as large as stability allows.
bool Automatic::is_held_by_stability() {
  constexpr double kNear = 0.5;  // of the limit
  if (explicit_->stiffness() > kNear * explicit_->stability_limit()) {
    calm_steps_ = 0;
    ++held_steps_;
  } else if (++calm_steps_ >= kCalmSteps) {
    held_steps_ = 0;
  }
  return held_steps_ >= kHeldSteps;
}

void Automatic::watch(EquationsOfMotion& equations, State& state) {
  const int own = place(method_);
  ++steps_;
  if (steps_ < 0) return;  // on the way across a singular pose: no place to change methods
  step_[own] = current_step();
  const bool held = method_ == Method::explicit_runge_kutta && is_held_by_stability();
  if (steps_ % kBlock != 0) return;
  pace_[own] = (state.time - block_time_) / std::max(work() - block_work_, 1.0);
  block_time_ = state.time;
  block_work_ = work();

  if (!to_try_.empty()) {
    if (steps_ >= kTraits[own].trial) settle(equations, state);
    return;
  }
  // The first time that stability holds the step, the others are tried at once.
  const bool soon = held && (wait_[own] == kTraits[own].wait || steps_ >= wait_[own] / kHeldShare);
  if (!soon && steps_ < wait_[own]) return;
  for (Method rival : {Method::radau, Method::lie_bdf})
    if (rival != method_) to_try_.push_back(rival);
  if (method_ != Method::explicit_runge_kutta) to_try_.insert(to_try_.begin(), Method::explicit_runge_kutta);
  change(to_try_.back(), equations, state);
}

/// The end of a trial: the next one, or the best of all keeps the scene.
void Automatic::settle(EquationsOfMotion& equations, State& state) {
  to_try_.pop_back();
  if (!to_try_.empty()) return change(to_try_.back(), equations, state);
  const auto best = static_cast<Method>(std::max_element(pace_.begin(), pace_.end()) - pace_.begin());
  if (best == incumbent_) {
    wait_[place(best)] = std::min(2 * wait_[place(best)], kLongestWait);
  } else {
    ++switches_;
    wait_ = {kTraits[0].wait, kTraits[1].wait, kTraits[2].wait};
    incumbent_ = best;
  }
  held_steps_ = calm_steps_ = 0;
  if (best != method_) change(best, equations, state);
}

bool Automatic::keep(Archive& archive, EquationsOfMotion& equations, const State& state) {
  archive.same("relative tolerance", parameters_.tolerance.relative);
  archive.same("absolute tolerance", parameters_.tolerance.absolute);
  archive.same("first_step", parameters_.first_step);
  archive.same("max_step", parameters_.max_step);
  Method method = method_;
  double begun_with = begun_with_;
  archive("method", method);
  archive("begun_with", begun_with);
  if (place(method) < 0 || place(method) >= kMethods)
    throw FileError("the checkpoint's method is unknown", archive.source(), "resume from an older one");
  if (archive.loads()) {
    State begun = state;
    step_[place(method)] = begun_with;
    change(method, equations, begun);
  }
  archive("step", step_);
  archive("statistics", statistics_);
  archive("before", before_);
  archive("incumbent", incumbent_);
  archive("switches", switches_);
  archive("fresh", fresh_);
  archive("steps", steps_);
  archive("held_steps", held_steps_);
  archive("calm_steps", calm_steps_);
  std::vector<int> to_try;
  for (Method m : to_try_) to_try.push_back(place(m));
  archive("to_try", to_try);
  to_try_.clear();
  for (int m : to_try) to_try_.push_back(static_cast<Method>(std::clamp(m, 0, kMethods - 1)));
  archive("pace", pace_);
  archive("wait", wait_);
  archive("block_time", block_time_);
  archive("block_work", block_work_);
  archive.group("at work", [&] { at_work().history(archive, equations, state); });
  return true;
}

void Automatic::interpolate(const Layout& layout, const State& from, const State& to, double time, State& out) const {
  if (fresh_) return Integrator::interpolate(layout, from, to, time, out);  // the step was another method's
  at_work().interpolate(layout, from, to, time, out);
}

}  // namespace lithe
