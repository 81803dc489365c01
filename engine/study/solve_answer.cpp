#include <algorithm>
#include <numeric>
#include <utility>

#include "engine/base/error.h"
#include "engine/study/solve_internal.h"
#include "engine/study/study_run.h"

namespace lithe {

// ---- 3. the answer ----

void Solver::accept_rigid() {
  answer_ = tolerance_ < kFirstTolerance / 10                    ? run(bodies_.rigid(), tolerance_, false)
            : tolerance_ < kFirstTolerance && tighter_.reached() ? tighter_
                                                                 : rigid_;
  if (!answer_.reached()) {
    remarks_.push_back("rigid, tolerance " + short_number(tolerance_) + ": " + answer_.why);
    answer_ = rigid_;
  }
  errors_.assign(count(), {});
  for (std::size_t w = 0; w < count(); ++w) {
    errors_[w].truncation = kPredicted * deformation_[w];
    errors_[w].time = time_worth_[w] * answer_.tolerance.relative;
    errors_[w].solver = answer_.residual + kRoundOff * round_off(w);
  }
  note_trial(answer_, largest_part());
  chosen_ = static_cast<int>(trials_.size()) - 1;
}

void Solver::refine(std::vector<Fidelity> models) {
  double share = kModesShare;
  std::optional<ModelRun> good;  // the last that reached the end
  std::vector<StatedError> good_errors;
  for (int round = 0; round < options_.most_runs; ++round) {
    const bool stepped = (step_ > 0 || round == 0) && try_steps(models);
    if (!stepped) answer_ = run(models, tolerance_, true);
    if (!answer_.reached()) {
      note_trial(answer_, kInfinity);
      remarks_.push_back(model_text(bodies_, models) + ": " + answer_.why);
      if (!complete(models) && !raise_order(models)) tolerance_ /= 10;
      continue;
    }
    change_ = sample_changes(sensors_, answer_.samples);
    set_bounds();
    judge();
    if (stepped)
      for (std::size_t w = 0; w < count(); ++w) errors_[w].time = step_error_[w];
    else if (is_rough())
      judge_rough();
    note_trial(answer_, largest_part());
    chosen_ = static_cast<int>(trials_.size()) - 1;
    if (largest_part() <= 1) return;
    good = answer_, good_errors = errors_;
    if (!improve(models, share)) return;
  }
  if (answer_.reached()) return;
  if (good) {
    answer_ = std::move(*good), errors_ = good_errors;
    return;
  }
  throw SimulationError("no model of the scene reached the end: " + answer_.why, "solve",
                        "run the scene by itself first: diagnose() tells why it fails");
}

/// Steps as long as the samples are apart, and half of that; true if the difference, a third of which is left in the
/// finer, is a small part of what is allowed.
bool Solver::try_steps(const std::vector<Fidelity>& models) {
  step_ = 0;
  if (!methods_.by_step || change_.empty()) return false;
  for (std::size_t w = 0; w < count(); ++w)
    if (bounds_[w] < kCoarse * change_[w]) return false;
  const double interval = duration_ / samples();
  const auto stepped = [&](double step, bool dynamics) {
    return run_model(graph_, bodies_, models, sensors_, [&](const Tolerance&) { return methods_.by_step(step); },
                     {duration_, samples(), {}, simplify_, dynamics});
  };
  const ModelRun coarse = stepped(interval, false);
  if (!coarse.reached()) return false;
  ModelRun fine = stepped(interval / 2, true);
  if (!fine.reached()) return false;
  step_error_ = sample_differences(sensors_, coarse.samples, fine.samples);
  for (std::size_t w = 0; w < count(); ++w) {
    step_error_[w] *= kStepsLeft;
    if (!(step_error_[w] < kStepsShare * bounds_[w])) return false;
  }
  fine.tolerance = {0, 0};
  answer_ = std::move(fine);
  step_ = interval / 2;
  return true;
}

/// Modes that no load drives keep joints from being redundant: all up to the highest chosen, then all.
bool Solver::complete(std::vector<Fidelity>& models) const {
  bool more = false;
  for (std::size_t b = 0; b < models.size(); ++b) {
    auto& modes = models[b].modes;
    if (modes.empty()) continue;
    const auto known = modes.size();
    const int last = modes.back() + 1;
    const bool leading = static_cast<int>(known) == last;
    const int end = leading ? static_cast<int>(bodies_.bodies()[b]->candidate_stiffness().size()) : last;
    modes.resize(static_cast<std::size_t>(end));
    std::iota(modes.begin(), modes.end(), 0);
    more |= modes.size() > known;
  }
  return more;
}

/// States the errors of the answer along its own motion.
void Solver::judge() {
  errors_.assign(count(), {});
  const ModelError rest =
      model_error(graph_, bodies_, answer_, bodies_.all(), Missing::modes, sensors_, 1, Detail::each);
  for (const auto& c : rest.coordinates)
    for (auto& known : effects_)
      if (known.body == c.body && known.mode == c.mode) known = c;
  if (effects_.empty()) effects_ = rest.coordinates;
  // How far the first order carries here: the change by deformation as it came, over that predicted.
  std::vector<double> carried(count(), 1);
  if (rigid_.reached()) {
    const auto came = sample_differences(sensors_, answer_.samples, rigid_.samples);
    for (std::size_t w = 0; w < count(); ++w)
      if (deformation(w) > 0) carried[w] = std::clamp(came[w] / deformation_[w], 1.0, 10.0);
  }
  // What the modes left out do to the motion at large.
  std::vector<double> at_large(count(), 0);
  if (rigid_.reached() && !rest.coordinates.empty()) {
    const ModelRun moved = run_model(graph_, bodies_, bodies_.rigid(), sensors_, methods_.by_tolerance,
                                     rigid_request(false), rest.feedback);
    if (moved.reached()) at_large = sample_differences(sensors_, moved.samples, rigid_.samples);
  }
  std::vector<double> next(count(), 0);  // of the order beyond
  const Deflection order = order_of(answer_.models);
  if (order < finest()) {
    const Deflection above = order == Deflection::linear ? Deflection::stiffened : Deflection::quadratic;
    next =
        model_error(graph_, bodies_, answer_, deflected(answer_.models, above), Missing::all, sensors_, stride_).effect;
    auto& known = order == Deflection::linear ? second_order_ : fourth_order_;
    for (std::size_t w = 0; w < count(); ++w) known[w] = std::max(known[w], next[w]);
  } else if (order != Deflection::linear) {  // orders fall as the second fell from the first
    const auto& last = order == Deflection::quadratic ? fourth_order_ : second_order_;
    for (std::size_t w = 0; w < count() && !deformation_.empty(); ++w)
      if (deformation_[w] > 0) next[w] = last[w] * std::min(1.0, second_order_[w] / deformation_[w]);
  }
  if (order != Deflection::linear)
    for (std::size_t w = 0; w < count(); ++w) next[w] += kFieldsLeftOut * second_order_[w];
  for (std::size_t w = 0; w < count(); ++w) {
    errors_[w].truncation = kCaution * carried[w] * (rest.effect[w] + at_large[w]) + kCandidates * deformation(w);
    errors_[w].deflection = kCaution * next[w];
    if (!options_.small_deflection && finest() == Deflection::linear)
      errors_[w].deflection = std::numeric_limits<double>::quiet_NaN();
    errors_[w].time = answer_.tolerance.relative * time_worth(w);
    errors_[w].solver = answer_.residual + kRoundOff * round_off(w);
  }
}

/// Where reactions or accelerations are wanted, modes that hardly move show: a second run at a looser tolerance
/// tells.
void Solver::judge_rough() {
  const ModelRun looser = run(answer_.models, 10 * answer_.tolerance.relative, false);
  const auto difference = sample_differences(sensors_, answer_.samples, looser.samples);
  for (std::size_t w = 0; w < count(); ++w)
    if (rigid_.rough.empty() || rigid_.rough[w])
      errors_[w].time = looser.reached() ? kRoughTime * difference[w] : kInfinity;
}

double Solver::largest_part() const {
  double most = 0;
  for (std::size_t w = 0; w < count(); ++w) {
    StatedError known = errors_[w];
    if (std::isnan(known.deflection)) known.deflection = 0;
    most = std::max(most, known.total() / bounds_[w]);
  }
  return most;
}

/// Refines what counts most; false if nothing is left to refine.
bool Solver::improve(std::vector<Fidelity>& models, double& share) {
  double truncation = 0, deflection = 0, time = 0;
  for (std::size_t w = 0; w < count(); ++w) {
    truncation = std::max(truncation, errors_[w].truncation / bounds_[w]);
    deflection = std::max(deflection, errors_[w].deflection / bounds_[w]);
    time = std::max(time, errors_[w].time / bounds_[w]);
  }
  bool better = false;
  if (deflection > 0.3) better = raise_order(models);
  if (truncation > 0.3 && !effects_.empty()) {
    share *= 0.3 / truncation;
    for (bool more = false; !more && share > kNoShare; share /= 4) more = add_modes(models, with_modes(share));
    better |= share > kNoShare;
    models = deflected(models, order_of(models));
  }
  if (step_ > 0 && time > 0.3) {
    step_ = 0;
    return true;
  }
  if (time > 0.3 && tolerance_ > kTightest) {
    tolerance_ = std::max(kTightest, tolerance_ * 0.1 / time);
    better = true;
  }
  return better;
}

bool Solver::add_modes(std::vector<Fidelity>& models, const std::vector<Fidelity>& more) {
  bool added = false;
  for (std::size_t b = 0; b < models.size(); ++b) {
    std::vector<int> both;
    std::set_union(models[b].modes.begin(), models[b].modes.end(), more[b].modes.begin(), more[b].modes.end(),
                   std::back_inserter(both));
    added |= both != models[b].modes;
    models[b].modes = both;
  }
  return added;
}

bool Solver::raise_order(std::vector<Fidelity>& models) const {
  const Deflection order = order_of(models);
  if (order >= finest()) return false;
  models = deflected(models, order == Deflection::linear ? Deflection::stiffened : Deflection::quadratic);
  return true;
}

}  // namespace lithe
