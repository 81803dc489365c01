#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

#include "engine/study/solve_internal.h"

namespace lithe::solving {
namespace {

using Models = std::vector<Fidelity>;

constexpr double kDriven = 1;      // of what is allowed: the second order then drives modes that no load does
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

bool has(const Models& models, const ModelError::Coordinate& c) {
  const auto& modes = models[static_cast<std::size_t>(c.body)].modes;
  return std::binary_search(modes.begin(), modes.end(), c.mode);
}

// ---- the search ----

/// Looks for the poorest model that a richer one differs little from, both at one pace, so that what the pace leaves
/// falls out of the difference; then for a pace.
class ModelSearch {
 public:
  ModelSearch(const Asked& asked, const RigidMotion& rigid, const Choice& choice)
      : asked_(asked),
        rigid_(rigid),
        untold_(choice.untold),
        models_(choice.models),
        pace_(rigid.pace),
        carried_(rigid.amplification),
        deformed_(asked.count(), 0) {
    answer_.judgement = {rigid.change, rigid.bounds, {}, choice.effects};
    answer_.trials = choice.trials, answer_.remarks = choice.remarks;
    // Steps of two samples must resolve the loads; then a coarser run is compared, for a quarter of a finer one's
    // price.
    if (!rigid.reached() || rigid.pace.step != asked.interval() || asked.simplify || asked.contacts) return;
    const auto left = left_by_pace(asked, rigid.ladder);
    resolved_ = true;
    for (std::size_t w = 0; w < asked.count(); ++w) resolved_ &= 16 * left[w] < rigid.bounds[w];
  }

  Answer find() {
    int round = 0;
    while (round < asked_.options.most_runs && !begin()) ++round;
    if (round == asked_.options.most_runs) return std::move(answer_);
    climb();
    do {
      std::vector<double> left = model_errors();
      for (std::size_t w = 0; w < asked_.count(); ++w)
        left[w] = kPaceShare * std::max(judgement().bounds[w] - left[w], (1 - kModelShare) * judgement().bounds[w]);
      refine_pace(asked_, models_, left, rigid_.elastic_scale, resolved_, ladder_);
      compare_again();
      judge();
    } while (!answer_.met() && ++round < asked_.options.most_runs && improve());
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
    find_rest(ladder_.last());
    richer_ = deflected(asked_, united(models_, modes_within(share_)), finest(asked_));
    if (!look_at_richer(ladder_.last())) {
      give_up(richer_);
      return false;
    }
    return true;
  }
  bool look_at_richer(const ModelRun& run) {
    rich_ = richer_ == run.models ? run : run_at(asked_, richer_, pace_, rigid_.elastic_scale, true);
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
  /// What the modes left out do along the motion of the run, and how far the first order carries here: the change by
  /// deformation as it came, over that predicted.
  void find_rest(const ModelRun& run) {
    const ModelError rest = model_error(asked_.graph, asked_.bodies, run, asked_.bodies.all(order_of(run.models)),
                                        asked_.sensors, asked_.stride, Detail::each);
    auto& known = judgement().effects.modes;
    for (const ModelError::Coordinate& c : rest.coordinates) {
      const auto at =
          std::find_if(known.begin(), known.end(), [&](const auto& k) { return k.body == c.body && k.mode == c.mode; });
      if (at == known.end())
        known.push_back(c);
      else if (!untold_)
        *at = c;
    }
    if (!rigid_.reached()) return;
    deformed_ = sample_differences(asked_.sensors, run.samples, rigid_.run().samples);
    for (std::size_t w = 0; w < asked_.count(); ++w)
      if (rigid_.deformation[w] > 0)
        carried_[w] = rigid_.amplification[w] * std::clamp(deformed_[w] / rigid_.deformation[w], 1.0, 10.0);
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
  Models modes_within(double share) const {
    const Judgement& j = answer_.judgement;
    return with_modes(asked_, j.effects.modes, carried_, j.bounds, share);
  }
  /// Modes or the order of deflection, as the estimate of the one has its part in what the model is off by.
  bool richen() {
    Models next = models_;
    if (by_modes() || !raise_order(asked_, next))
      next = deflected(asked_, united(models_, modes_within(kModesShare / 4)), order_of(models_));
    if (next == models_) raise_order(asked_, next);
    if (next == models_) next = richer_;
    Ladder ladder;
    if (next == rich_.models)
      ladder.runs.push_back(rich_), ladder.paces.push_back(pace_);
    else if (!add_run(asked_, next, pace_, rigid_.elastic_scale, true, ladder, answer_.why))
      return false;
    if (order_of(next) == order_of(models_)) by_order_.clear();
    models_ = std::move(next);
    ladder_ = std::move(ladder);
    return true;
  }
  /// What the orders do, by runs of the same modes.
  void note_order() {
    const ModelRun& run = ladder_.last();
    by_order_[order_of(models_)] = run.samples;
    Effects& effects = judgement().effects;
    const auto measure = [&](Deflection poorer, Deflection richer, std::vector<double>& effect) {
      if (by_order_.contains(poorer) && by_order_.contains(richer))
        effect = sample_differences(asked_.sensors, by_order_[poorer], by_order_[richer]);
    };
    if (order_of(models_) == Deflection::linear)  // as long as no more is known
      effects.second_order = sample_differences(asked_.sensors, run.samples, rich_.samples);
    measure(Deflection::linear, Deflection::stiffened, effects.second_order);
    measure(Deflection::stiffened, Deflection::quadratic, effects.fourth_order);
    known_fourth_ |= by_order_.contains(Deflection::stiffened) && by_order_.contains(Deflection::quadratic);
  }

  /// Whether modes that the richer model has make the better part of the difference.
  bool by_modes() const {
    for (std::size_t w = 0; w < asked_.count(); ++w)
      if (off_[w] > 0 && kMeasured * off_[w] > kModelShare * answer_.judgement.bounds[w] && left_out(w) > 0.5 * off_[w])
        return true;
    return false;
  }
  /// By the estimate: of the modes that the richer model has and the present one not.
  double left_out(std::size_t w) const {
    double sum = 0;
    for (const auto& c : answer_.judgement.effects.modes)
      if (!has(models_, c) && has(richer_, c)) sum += carried_[w] * c.effect[w];
    return sum;
  }

  // ---- errors ----

  /// The change by deformation.
  double deformed(std::size_t w) const { return std::max(deformed_[w], rigid_.deformed_by(w)); }
  /// Orders fall on as they fell beside the first; without data of the fourth, by the fourth root.
  double beyond(std::size_t w) const {
    const Deflection order = finest(asked_);
    if (order == Deflection::linear) return 0;
    const Judgement& j = answer_.judgement;
    const double first = deformed(w);
    const double second = std::min(j.effects.second_order[w], first);  // more, where lower orders run away
    const double falls = first > 0 ? std::min(1.0, std::max(second, j.effects.fourth_order[w]) / first) : 1;
    double next = second * std::sqrt(std::sqrt(falls));
    if (order == Deflection::quadratic) next = falls * (known_fourth_ ? j.effects.fourth_order[w] : second * falls);
    return kBeyond * next + kFieldsLeftOut * second;
  }
  /// By the modes that neither has, or that steps hide.
  double unseen(std::size_t w) const {
    double sum = 0;
    for (const auto& c : answer_.judgement.effects.modes) {
      const bool hidden = 2 * M_PI * c.frequency * pace_.step > kUnresolved;
      if (!has(models_, c) && (hidden || !has(richer_, c))) sum += carried_[w] * c.effect[w];
    }
    return kCaution * sum + kCandidates * deformed(w);
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
    for (std::size_t w = 0; w < asked_.count(); ++w) errors[w] = kMeasured * off_[w] + unseen(w) + beyond(w);
    return errors;
  }

  /// By how much samples are off the answer, in parts of what is allowed.
  double moved(const Table& samples) const {
    const auto apart = sample_differences(asked_.sensors, samples, ladder_.last().samples);
    double most = 0;
    for (std::size_t w = 0; w < asked_.count(); ++w) most = std::max(most, apart[w] / answer_.judgement.bounds[w]);
    return most;
  }
  /// An answer has been compared with a richer model, at a pace at which it has changed by less than is allowed.
  void compare_again() {
    const Models beside = richer_;
    if (models_ == richer_ || order_of(models_) != Deflection::linear) {  // anew, along what it has become
      const auto known = std::find_if(ladder_.runs.begin(), ladder_.runs.end(),
                                      [](const ModelRun& run) { return !run.states.empty(); });
      if (known != ladder_.runs.end()) find_rest(*known);
      if (models_ == richer_) share_ /= 5;
      richer_ = united(richer_, modes_within(share_));
    }
    if (by_second_order() > kDriven) richer_ = all_of(asked_, richer_);
    richer_ = deflected(asked_, std::move(richer_), finest(asked_));
    if (models_ == richer_ || (richer_ == beside && moved(rich_.samples) <= 1)) return;
    std::size_t at = 0;
    while (at + 2 < ladder_.runs.size() && moved(ladder_.runs[at].samples) > 1) ++at;
    pace_ = ladder_.paces[at];
    ModelRun rich = run_at(asked_, richer_, pace_, rigid_.elastic_scale, false);
    if (!rich.reached()) {
      answer_.remarks.push_back("not compared with " + model_text(asked_.bodies, richer_) + ": " + rich.why);
      return;
    }
    rich_ = std::move(rich);
    by_order_.clear();
  }
  /// What the orders of deflection do, in parts of what is allowed.
  double by_second_order() const {
    const Judgement& j = answer_.judgement;
    double most = 0;
    for (std::size_t w = 0; w < asked_.count(); ++w)
      most = std::max(most, (j.effects.second_order[w] + j.effects.fourth_order[w]) / j.bounds[w]);
    return most;
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
      const bool finest_order = order_of(run.models) == finest(asked_);
      const double modes = finest_order ? off_[w] : std::min(off_[w], left_out(w));
      error.truncation = kMeasured * modes + unseen(w);
      error.deflection = kMeasured * (off_[w] - modes) + beyond(w);
      if (!asked_.options.small_deflection && finest(asked_) == Deflection::linear)
        error.deflection = std::numeric_limits<double>::quiet_NaN();
      error.time = left[w];
      error.solver = run.residual + kRoundOff * round_off(asked_, run.samples, w);
    }
    answer_.run = run;
    note(asked_, answer_);
  }

  /// The richer model it was compared with, from where that was; false if it is not better.
  bool improve() {
    const StatedError parts = judgement().largest_parts();
    const bool at_order = order_of(models_) == finest(asked_);
    if (models_ == richer_ || (at_order && parts.deflection > 1) ||
        !(parts.truncation > kModelShare || (!at_order && parts.deflection > kModelShare)))
      return false;
    models_ = richer_;
    ladder_ = {{rich_}, {pace_}};
    return true;
  }

  const Asked& asked_;
  const RigidMotion& rigid_;
  const bool untold_;
  Answer answer_{};
  Models models_, richer_;
  Pace pace_;
  bool resolved_ = false;  // by steps twice as long
  double share_ = kRicherShare;
  std::vector<double> carried_;   // what the motion at large makes of a deformation, at least 1
  std::vector<double> deformed_;  // change by deformation, as a run has it
  ModelRun rich_;
  Ladder ladder_;
  std::map<Deflection, Table> by_order_;  // of the same modes at one pace
  bool known_fourth_ = false;
  std::vector<double> off_;  // beside the richer model
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
