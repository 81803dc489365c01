#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

#include "engine/study/solve_internal.h"

namespace lithe::solving {
namespace {

using Models = std::vector<Fidelity>;

constexpr double kUnresolved = 3;  // ω h beyond which steps damp a mode, so that a run does not show what it does

// ---- richer models ----

/// Modes that no load drives keep joints from being redundant: all up to the highest chosen, then all.
bool complete(const Asked& asked, Models& models) {
  bool more = false;
  for (std::size_t b = 0; b < models.size(); ++b) {
    auto& modes = models[b].modes;
    if (modes.empty()) continue;
    const auto known = modes.size();
    const int last = modes.back() + 1;
    const bool leading = static_cast<int>(known) == last;
    const int end = leading ? static_cast<int>(asked.bodies.bodies()[b]->candidate_stiffness().size()) : last;
    modes.resize(static_cast<std::size_t>(end));
    std::iota(modes.begin(), modes.end(), 0);
    more |= modes.size() > known;
  }
  return more;
}

Models united(Models models, const Models& more) {
  for (std::size_t b = 0; b < models.size(); ++b) {
    std::vector<int> both;
    std::set_union(models[b].modes.begin(), models[b].modes.end(), more[b].modes.begin(), more[b].modes.end(),
                   std::back_inserter(both));
    models[b].modes = both;
  }
  return models;
}

bool raise_order(const Asked& asked, Models& models) {
  const Deflection order = order_of(models);
  if (order >= finest(asked)) return false;
  models = deflected(asked, models, order == Deflection::linear ? Deflection::stiffened : Deflection::quadratic);
  return order_of(models) > order;
}

bool has(const Models& models, const ModelError::Coordinate& c) {
  const auto& modes = models[static_cast<std::size_t>(c.body)].modes;
  return std::binary_search(modes.begin(), modes.end(), c.mode);
}

// ---- the search ----

/// Looks for the poorest model that a richer one differs little from, both at one pace, so that what the pace leaves
/// falls out of the difference; then for a pace.
class Search {
 public:
  Search(const Asked& asked, const RigidMotion& rigid, const Choice& choice)
      : asked_(asked), rigid_(rigid), models_(choice.models), pace_(rigid.pace) {
    answer_.judgement = {rigid.change, rigid.bounds, {}, choice.effects};
    answer_.trials = choice.trials, answer_.remarks = choice.remarks;
  }

  Answer find() {
    for (int round = 0; round < asked_.options.most_runs; ++round) {
      if (!begin()) continue;
      climb();
      std::vector<double> left = model_errors();
      for (std::size_t w = 0; w < asked_.count(); ++w)
        left[w] = kPaceShare * std::max(judgement().bounds[w] - left[w], (1 - kModelShare) * judgement().bounds[w]);
      refine_pace(asked_, models_, left, rigid_.elastic_scale, ladder_);
      const bool unchanged = compare_again();
      judge();
      if (answer_.met() || (unchanged && !improve())) break;
    }
    return std::move(answer_);
  }

 private:
  Judgement& judgement() { return answer_.judgement; }

  /// The model at its pace, and the richer one; false if either fails.
  bool begin() {
    ladder_ = {};
    if (!add_run(asked_, models_, pace_, rigid_.elastic_scale, true, ladder_, answer_.why)) {
      give_up(models_);
      return false;
    }
    measure_scale();
    find_rest();
    richer_ = deflected(asked_,
                        united(models_, with_modes(asked_, judgement().effects.modes, rigid_.amplification,
                                                   judgement().bounds, share_)),
                        finest(asked_));
    if (!look_at_richer(ladder_.last())) {
      give_up(richer_);
      return false;
    }
    return true;
  }
  bool look_at_richer(const ModelRun& run) {
    rich_ = richer_ == run.models ? run : run_at(asked_, richer_, pace_, rigid_.elastic_scale, false);
    by_order_.clear();
    if (!rich_.reached()) answer_.why = rich_.why;
    return rich_.reached();
  }
  void give_up(const Models& failed) {
    answer_.trials.push_back({model_text(asked_.bodies, failed), pace_.tolerance, true, kInfinity, 0});
    answer_.remarks.push_back(model_text(asked_.bodies, failed) + ": " + answer_.why);
    if (complete(asked_, models_) || raise_order(asked_, models_)) return;
    pace_ = finer(pace_);
  }
  void measure_scale() {
    judgement().change = sample_changes(asked_.sensors, ladder_.last().samples);
    judgement().bounds = allowed(asked_, judgement().change, ladder_.last().samples);
  }
  /// What the modes left out do along the motion of the run.
  void find_rest() {
    const ModelError rest = model_error(asked_.graph, asked_.bodies, ladder_.last(), asked_.bodies.all(),
                                        Missing::modes, asked_.sensors, asked_.stride, Detail::each);
    auto& known = judgement().effects.modes;
    for (const auto& c : rest.coordinates) {
      const auto at =
          std::find_if(known.begin(), known.end(), [&](const auto& k) { return k.body == c.body && k.mode == c.mode; });
      if (at != known.end())
        *at = c;
      else
        known.push_back(c);
    }
  }

  /// To richer models, until what one is off by does.
  void climb() {
    for (;;) {
      note_order();
      const auto errors = model_errors();
      double most = 0;
      for (std::size_t w = 0; w < asked_.count(); ++w) most = std::max(most, errors[w] / judgement().bounds[w]);
      if (most <= kModelShare || ladder_.last().models == rich_.models) return;
      answer_.trials.push_back(trial(asked_, ladder_.last(), most));
      if (!richen()) return;
    }
  }
  bool richen() {
    Models next = models_;
    if (!raise_order(asked_, next)) next = richer_;
    Ladder ladder;
    if (next == rich_.models)
      ladder.runs.push_back(rich_), ladder.paces.push_back(pace_);
    else if (!add_run(asked_, next, pace_, rigid_.elastic_scale, false, ladder, answer_.why))
      return false;
    models_ = std::move(next);
    ladder_ = std::move(ladder);
    return true;
  }
  /// What the orders do, by runs of the same modes.
  void note_order() {
    const ModelRun& run = ladder_.last();
    by_order_[order_of(models_)] = run.samples;
    const auto apart = [&](Deflection a, Deflection b) {
      const Table& richer = by_order_.contains(b) ? by_order_[b] : rich_.samples;
      return sample_differences(asked_.sensors, by_order_[a], richer);
    };
    Effects& effects = judgement().effects;
    if (by_order_.contains(Deflection::linear)) effects.second_order = apart(Deflection::linear, Deflection::stiffened);
    if (by_order_.contains(Deflection::stiffened))
      effects.fourth_order = apart(Deflection::stiffened, Deflection::quadratic);
  }

  // ---- errors ----

  /// Of what the first order does at most once more.
  double beyond(std::size_t w) const {
    const Effects& effects = answer_.judgement.effects;
    const double first = rigid_.deformed_by(w), second = effects.second_order[w];
    const double falls = first > 0 ? std::min(1.0, second / first) : 1;
    double last = second;
    if (finest(asked_) == Deflection::quadratic)
      last = by_order_.contains(Deflection::stiffened) ? effects.fourth_order[w] : second * falls;
    return finest(asked_) == Deflection::linear ? 0 : last * falls + kFieldsLeftOut * second;
  }
  /// By the modes that neither has, or that steps hide.
  double unseen(std::size_t w) const {
    double sum = 0;
    for (const auto& c : answer_.judgement.effects.modes) {
      const bool hidden = 2 * M_PI * c.frequency * pace_.step > kUnresolved;
      if (!has(models_, c) && (hidden || !has(richer_, c))) sum += rigid_.amplification[w] * c.effect[w];
    }
    return kCaution * sum + kCandidates * rigid_.deformed_by(w);
  }
  std::vector<double> beside() const {
    for (std::size_t i = 0; i < ladder_.runs.size(); ++i)
      if (ladder_.paces[i].step == pace_.step && ladder_.paces[i].tolerance == pace_.tolerance)
        return sample_differences(asked_.sensors, ladder_.runs[i].samples, rich_.samples);
    return off_;
  }
  std::vector<double> model_errors() {
    off_ = beside();
    std::vector<double> errors(asked_.count());
    for (std::size_t w = 0; w < asked_.count(); ++w) errors[w] = kMeasured * off_[w] + unseen(w) + kCaution * beyond(w);
    return errors;
  }

  /// Where the pace was so coarse that the run has changed by as much as is allowed, the comparison is made again;
  /// false if it then misses.
  bool compare_again() {
    if (ladder_.runs.size() < 2 || models_ == richer_) return true;
    const auto moved = sample_differences(asked_.sensors, rich_.samples, ladder_.last().samples);
    double most = 0;
    for (std::size_t w = 0; w < asked_.count(); ++w) most = std::max(most, moved[w] / judgement().bounds[w]);
    if (most <= 1) return true;
    const std::size_t coarser = ladder_.runs.size() - 2;
    pace_ = ladder_.paces[coarser];
    ModelRun rich = run_at(asked_, richer_, pace_, rigid_.elastic_scale, false);
    if (!rich.reached()) return true;
    rich_ = std::move(rich);
    by_order_.clear();
    const auto errors = model_errors();
    for (std::size_t w = 0; w < asked_.count(); ++w)
      if (errors[w] > judgement().bounds[w]) {
        if (!raise_order(asked_, models_)) models_ = richer_;
        return false;
      }
    return true;
  }

  void judge() {
    const ModelRun& run = ladder_.last();
    Judgement& j = judgement();
    measure_scale();
    const auto left = left_by_pace(asked_, ladder_);
    model_errors();
    j.errors.assign(asked_.count(), {});
    for (std::size_t w = 0; w < asked_.count(); ++w) {
      StatedError& error = j.errors[w];
      double modes = 0;  // of the difference, as far as the estimate has it
      for (const auto& c : j.effects.modes)
        if (!has(run.models, c) && has(richer_, c)) modes += c.effect[w];
      const bool finest_order = order_of(run.models) == finest(asked_);
      modes = finest_order ? off_[w] : std::min(off_[w], modes);
      error.truncation = kMeasured * modes + unseen(w);
      error.deflection = kMeasured * (off_[w] - modes) + kCaution * beyond(w);
      if (!asked_.options.small_deflection && finest(asked_) == Deflection::linear)
        error.deflection = std::numeric_limits<double>::quiet_NaN();
      error.time = left[w];
      error.solver = run.residual + kRoundOff * round_off(asked_, run.samples, w);
    }
    answer_.run = run;
    note(asked_, answer_);
  }

  /// What the richer model leaves out too; false if nothing is left to refine.
  bool improve() {
    const StatedError parts = judgement().largest_parts();
    if (!(parts.truncation > kModelShare) || share_ < kNoShare) return false;
    share_ /= 10;
    models_ = richer_;
    return true;
  }

  const Asked& asked_;
  const RigidMotion& rigid_;
  Answer answer_{};
  Models models_, richer_;
  Pace pace_;
  double share_ = kRicherShare;
  ModelRun rich_;
  Ladder ladder_;
  std::map<Deflection, Table> by_order_;  // of the same modes at one pace
  std::vector<double> off_;
};

}  // namespace

Answer accept_rigid(const Asked& asked, const RigidMotion& rigid, const Choice& choice) {
  Ladder ladder = rigid.ladder;
  std::vector<double> left(asked.count());
  for (std::size_t w = 0; w < asked.count(); ++w)
    left[w] = kPaceShare * (rigid.bounds[w] - kPredicted * rigid.deformation[w]);
  refine_pace(asked, asked.bodies.rigid(), left, rigid.elastic_scale, ladder);
  Answer answer{.run = ladder.last(),
                .judgement = {rigid.change, rigid.bounds, std::vector<StatedError>(asked.count()), choice.effects},
                .trials = choice.trials,
                .remarks = choice.remarks};
  const auto time = left_by_pace(asked, ladder);
  for (std::size_t w = 0; w < asked.count(); ++w) {
    StatedError& error = answer.judgement.errors[w];
    error.truncation = kPredicted * rigid.deformation[w];
    error.time = time[w];
    error.solver = answer.run.residual + kRoundOff * round_off(asked, answer.run.samples, w);
  }
  note(asked, answer);
  return answer;
}

Answer refine(const Asked& asked, const RigidMotion& rigid, const Choice& choice) {
  return Search(asked, rigid, choice).find();
}

}  // namespace lithe::solving
