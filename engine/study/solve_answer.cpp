#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "engine/study/solve_judgement_internal.h"

namespace lithe::solving {
namespace {

using Models = std::vector<Fidelity>;

constexpr double kDriven = 0.5;         // of what is allowed: the second order then drives modes that no load does,
constexpr double kDrivenShare = 0.002;  // and those that the estimate gives so little stay out of the richer model
constexpr double kScaled = 0.5;         // of what was allowed: a motion that longer steps made too large
constexpr double kDistinct = 0.3;       // of what is allowed, that tolerances may leave where models are compared

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

/// All candidates of the bodies that deform.
Models all_of(const Asked& asked, Models models) {
  const Models all = asked.bodies.all();
  for (std::size_t b = 0; b < models.size(); ++b)
    if (!models[b].modes.empty()) models[b].modes = all[b].modes;
  return models;
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

// ---- the search ----

/// Looks for the poorest model that a richer one differs little from, both at one pace; then for a pace.
class ModelSearch {
 public:
  ModelSearch(const Asked& asked, const RigidMotion& rigid, const Choice& choice)
      : asked_(asked), rigid_(rigid), judge_(asked, rigid, choice), models_(choice.models), pace_(rigid.pace) {
    answer_.trials = choice.trials, answer_.remarks = choice.remarks;
    // Steps of two samples must resolve the loads; then a coarser run is compared, for a quarter of a finer one's
    // price.
    if (!rigid.reached() || rigid.pace.step != asked.interval() || asked.simplify || asked.contacts) return;
    const auto left = left_by_pace(asked, rigid.ladder);
    const double twice = 2 * rigid.pace.step / rigid.ladder.paces.back().step;
    resolved_ = true;
    for (std::size_t w = 0; w < asked.count(); ++w) resolved_ &= twice * twice * left[w] < rigid.bounds[w];
  }

  Answer find() {
    int round = 0;
    while (round < asked_.options.most_runs && !begin()) ++round;
    if (round < asked_.options.most_runs) {
      climb();
      do {
        refine_steps();
        compare_again();
        judge();
      } while (!answer_.met() && ++round < asked_.options.most_runs && improve());
    }
    answer_.judgement = judge_.judgement();
    return std::move(answer_);
  }

 private:
  // ---- the model, at the first pace ----

  /// The model at its pace, and the richer one; false if either fails.
  bool begin() {
    ladder_ = {};
    if (!add_run(asked_, models_, pace_, rigid_.elastic_scale, true, ladder_, answer_.why)) {
      give_up(models_);
      return false;
    }
    judge_.measure_scale(ladder_.last());
    judge_.find_rest(ladder_.last(), order_of(models_));
    richer_ = deflected(asked_, united(models_, judge_.modes_within(share_)), finest(asked_));
    ModelRun rich = richer_ == models_ ? ladder_.last() : run_at(asked_, richer_, pace_, rigid_.elastic_scale, true);
    if (!rich.reached()) {
      answer_.why = rich.why;
      give_up(richer_);
      return false;
    }
    judge_.compare_with(std::move(rich), pace_);
    return true;
  }
  void give_up(const Models& failed) {
    answer_.trials.push_back({model_text(asked_.bodies, failed), pace_.tolerance, true, kInfinity, 0});
    answer_.remarks.push_back(model_text(asked_.bodies, failed) + ": " + answer_.why);
    if (complete(asked_, models_) || raise_order(asked_, models_)) return;
    pace_ = finer(pace_);
  }
  /// To richer models, until what one is off by does.
  void climb() {
    for (;;) {
      judge_.note_order(ladder_.last());
      const auto errors = judge_.model_errors(ladder_);
      double most = 0;
      for (std::size_t w = 0; w < asked_.count(); ++w) most = std::max(most, errors[w] / bounds()[w]);
      if (most <= kModelShare || ladder_.last().models == judge_.rich().models) return;
      answer_.trials.push_back(trial(asked_, ladder_.last(), most));
      if (!richen()) return;
    }
  }
  /// Modes or the order of deflection, as the estimate of the one has its part in what the model is off by.
  bool richen() {
    Models next = models_;
    if (judge_.by_modes(models_) || !raise_order(asked_, next))
      next = deflected(asked_, united(models_, judge_.modes_within(kModesShare / 4)), order_of(models_));
    if (next == models_) raise_order(asked_, next);
    if (next == models_) next = richer_;
    Ladder ladder;
    if (next == judge_.rich().models)
      ladder = {{judge_.rich()}, {pace_}};
    else if (!add_run(asked_, next, pace_, rigid_.elastic_scale, true, ladder, answer_.why))
      return false;
    if (order_of(next) == order_of(models_)) judge_.forget_orders();
    models_ = std::move(next);
    ladder_ = std::move(ladder);
    return true;
  }

  // ---- its pace ----

  const std::vector<double>& bounds() { return judge_.judgement().bounds; }

  /// Once more, where finer steps show that less is allowed: as of a resonance that long steps only seemed to have.
  void refine_steps() {
    for (double less = 0; less < kScaled;) {
      const std::vector<double> before = bounds();
      std::vector<double> left = judge_.model_errors(ladder_);
      for (std::size_t w = 0; w < asked_.count(); ++w)
        left[w] = kPaceShare * std::max(before[w] - left[w], (1 - kModelShare) * before[w]);
      refine_pace(asked_, models_, left, rigid_.elastic_scale, resolved_, ladder_);
      judge_.measure_scale(ladder_.last());
      less = 1;
      for (std::size_t w = 0; w < asked_.count(); ++w) less = std::min(less, bounds()[w] / before[w]);
    }
  }
  double moved(const Table& samples) { return judge_.apart(samples, ladder_.last().samples); }
  /// An answer has been compared with a richer model, at a pace at which it has changed by less than is allowed.
  void compare_again() {
    const Models beside = richer_;
    const bool driven = judge_.by_second_order() > kDriven;
    if (models_ == richer_ || order_of(models_) != Deflection::linear) {  // anew, along what it has become
      const auto known = std::find_if(ladder_.runs.begin(), ladder_.runs.end(),
                                      [](const ModelRun& run) { return !run.states.empty(); });
      if (known != ladder_.runs.end()) judge_.find_rest(*known, driven ? order_of(models_) : Deflection::linear);
      if (models_ == richer_) share_ /= 5;
      richer_ = united(richer_, judge_.modes_within(share_));
    }
    if (driven)
      richer_ = united(richer_, asked_.contacts ? all_of(asked_, richer_) : judge_.modes_within(kDrivenShare));
    richer_ = deflected(asked_, std::move(richer_), finest(asked_));
    if (models_ == richer_ || (richer_ == beside && moved(judge_.rich().samples) <= 1)) return;
    // Steps that are the same leave the same; by tolerance it does not fall out of the difference.
    const auto too_coarse = [&](std::size_t i) {
      const bool by_step = ladder_.paces[i].step > 0;
      return i + (by_step ? 2 : 1) < ladder_.runs.size() && moved(ladder_.runs[i].samples) > (by_step ? 1 : kDistinct);
    };
    std::size_t at = 0;
    while (too_coarse(at)) ++at;
    ModelRun rich = run_at(asked_, richer_, ladder_.paces[at], rigid_.elastic_scale, false);
    if (!rich.reached()) {
      answer_.remarks.push_back("not compared with " + model_text(asked_.bodies, richer_) + ": " + rich.why);
      return;
    }
    pace_ = ladder_.paces[at];
    judge_.compare_with(std::move(rich), pace_);
  }

  // ---- the answer ----

  void judge() {
    judge_.judge(ladder_);
    answer_.judgement = judge_.judgement();
    answer_.run = ladder_.last();
    note(asked_, answer_);
  }
  /// The richer model it was compared with, from where that was; false if it is not better.
  bool improve() {
    const StatedError parts = answer_.judgement.largest_parts();
    const bool at_order = order_of(models_) == finest(asked_);
    if (models_ == richer_ || (at_order && parts.deflection > 1) ||
        !(parts.truncation > kModelShare || (!at_order && parts.deflection > kModelShare)))
      return false;
    models_ = richer_;
    ladder_ = {{judge_.rich()}, {pace_}};
    return true;
  }

  const Asked& asked_;
  const RigidMotion& rigid_;
  ModelJudge judge_;
  Answer answer_{};
  Models models_, richer_;
  Pace pace_;
  bool resolved_ = false;  // by steps twice as long
  double share_ = kRicherShare;
  Ladder ladder_;
};

}  // namespace

Answer accept_rigid(const Asked& asked, const RigidMotion& rigid, const Choice& choice) {
  Ladder ladder = rigid.ladder;
  std::vector<double> left(asked.count());
  for (std::size_t w = 0; w < asked.count(); ++w)
    left[w] = kPaceShare * (rigid.bounds[w] - kPredicted * rigid.deformation[w]);
  refine_pace(asked, asked.bodies.rigid(), left, rigid.elastic_scale, false, ladder);
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
  return ModelSearch(asked, rigid, choice).find();
}

}  // namespace lithe::solving
