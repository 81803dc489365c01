#include "engine/study/solve_judgement_internal.h"

#include <algorithm>
#include <cmath>

#include "engine/study/inertia_left_out.h"

namespace lithe::solving {
namespace {

using Models = std::vector<Fidelity>;

constexpr double kUnresolved = 3;  // ω h beyond which steps damp a mode, so that a run does not show what it does

bool has(const Models& models, const ModelError::Coordinate& c) {
  const auto& modes = models[static_cast<std::size_t>(c.body)].modes;
  return std::binary_search(modes.begin(), modes.end(), c.mode);
}

}  // namespace

ModelJudge::ModelJudge(const Asked& asked, const RigidMotion& rigid, const Choice& choice)
    : asked_(asked),
      rigid_(rigid),
      untold_(choice.untold),
      judgement_{rigid.change, rigid.bounds, {}, choice.effects},
      carried_(rigid.amplification),
      deformed_(asked.count(), 0),
      by_inertia_(asked.count(), 0) {
  judgement_.change.resize(asked.count(), 0);
}

void ModelJudge::compare_with(ModelRun rich, const Pace& pace) {
  rich_ = std::move(rich), pace_ = pace;
  forget_orders();
}

void ModelJudge::measure_scale(const ModelRun& run) {
  const std::vector<double> before = judgement_.change;
  judgement_.change = sample_changes(asked_.sensors, run.samples);
  judgement_.bounds = allowed(asked_, judgement_.change, run.samples);
  const std::vector<double> less = scaled(before);
  for (std::size_t w = 0; w < asked_.count(); ++w)
    deformed_[w] *= less[w], judgement_.effects.second_order[w] *= less[w],
        judgement_.effects.fourth_order[w] *= less[w];
}

std::vector<double> ModelJudge::scaled(std::vector<double> change) const {
  for (std::size_t w = 0; w < change.size(); ++w)
    change[w] = change[w] > judgement_.change[w] ? judgement_.change[w] / change[w] : 1;
  return change;
}

// ---- effects ----

void ModelJudge::find_rest(const ModelRun& run, Deflection order) {
  const ModelError rest = estimate(asked_, run, asked_.bodies.all(order), asked_.stride, Detail::each);
  const std::vector<double> less = scaled(sample_changes(asked_.sensors, run.samples));
  auto& known = judgement_.effects.modes;
  for (ModelError::Coordinate c : rest.coordinates) {
    for (std::size_t w = 0; w < asked_.count(); ++w) c.effect[w] *= less[w];
    const auto at =
        std::find_if(known.begin(), known.end(), [&](const auto& k) { return k.body == c.body && k.mode == c.mode; });
    if (at == known.end())
      known.push_back(c);
    else if (!untold_)
      *at = c;
  }
  find_by_inertia(run);
  if (!rigid_.reached()) return;
  deformed_ = sample_differences(asked_.sensors, run.samples, rigid_.run().samples);
  for (std::size_t w = 0; w < asked_.count(); ++w) {
    deformed_[w] *= less[w];
    if (rigid_.deformation[w] > 0)
      carried_[w] = rigid_.amplification[w] * std::clamp(deformed_[w] / rigid_.deformation[w], 1.0, 10.0);
  }
}

/// The part that modes beyond the candidates have in a deformation: of each body by its inertia, which loads them too,
/// as far as that body counts.
void ModelJudge::find_by_inertia(const ModelRun& run) {
  by_inertia_.assign(asked_.count(), 0);
  const std::vector<double> beyond = inertia_left_out(asked_.graph, asked_.bodies, run);
  std::vector<double> sums(asked_.count(), 0);
  for (std::size_t b = 0; b < beyond.size(); ++b) {
    double candidates = 0;
    std::vector<double> effect(asked_.count(), 0);
    for (const auto& c : judgement_.effects.modes) {
      if (c.body != static_cast<int>(b)) continue;
      candidates += c.amplitude * c.amplitude;
      for (std::size_t w = 0; w < asked_.count(); ++w) effect[w] += c.effect[w] * c.effect[w];
    }
    if (!(candidates > 0)) continue;
    for (std::size_t w = 0; w < asked_.count(); ++w) {
      by_inertia_[w] += std::sqrt(effect[w]) * beyond[b] / std::sqrt(candidates);
      sums[w] += std::sqrt(effect[w]);
    }
  }
  for (std::size_t w = 0; w < asked_.count(); ++w) by_inertia_[w] = sums[w] > 0 ? by_inertia_[w] / sums[w] : 0;
}

void ModelJudge::note_order(const ModelRun& run) {
  by_order_[order_of(run.models)] = run.samples;
  Effects& effects = judgement_.effects;
  const auto measure = [&](Deflection poorer, Deflection richer, std::vector<double>& effect) {
    if (by_order_.contains(poorer) && by_order_.contains(richer))
      effect = sample_differences(asked_.sensors, by_order_[poorer], by_order_[richer]);
  };
  if (order_of(run.models) == Deflection::linear)  // as long as no more is known
    effects.second_order = sample_differences(asked_.sensors, run.samples, rich_.samples);
  measure(Deflection::linear, Deflection::stiffened, effects.second_order);
  measure(Deflection::stiffened, Deflection::quadratic, effects.fourth_order);
  known_fourth_ |= by_order_.contains(Deflection::stiffened) && by_order_.contains(Deflection::quadratic);
}

Models ModelJudge::modes_within(double share) const {
  return with_modes(asked_, judgement_.effects.modes, carried_, judgement_.bounds, share);
}

double ModelJudge::by_second_order() const {
  const Effects& effects = judgement_.effects;
  double most = 0;
  for (std::size_t w = 0; w < asked_.count(); ++w)
    most = std::max(most, (effects.second_order[w] + effects.fourth_order[w]) / judgement_.bounds[w]);
  return most;
}

// ---- errors ----

bool ModelJudge::by_modes(const Models& models) const {
  for (std::size_t w = 0; w < asked_.count(); ++w)
    if (off_[w] > 0 && kMeasured * off_[w] > kModelShare * judgement_.bounds[w] && left_out(models, w) > 0.5 * off_[w])
      return true;
  return false;
}

/// By the estimate: of the modes that the richer model has and these not.
double ModelJudge::left_out(const Models& models, std::size_t w) const {
  double sum = 0;
  for (const auto& c : judgement_.effects.modes)
    if (!has(models, c) && has(rich_.models, c)) sum += carried_[w] * c.effect[w];
  return sum;
}

/// By the order after the last: orders fall on as they fell beside the first; without data of the fourth, by the fourth
/// root.
double ModelJudge::beyond(std::size_t w) const {
  const Deflection order = finest(asked_);
  if (order == Deflection::linear) return 0;
  const Effects& effects = judgement_.effects;
  const double first = deformed_[w];
  const double second = std::min(effects.second_order[w], first);  // more, where lower orders run away
  const double falls = first > 0 ? std::min(1.0, std::max(second, effects.fourth_order[w]) / first) : 1;
  double next = second * std::sqrt(std::sqrt(falls));
  if (order == Deflection::quadratic) next = falls * (known_fourth_ ? effects.fourth_order[w] : second * falls);
  return kBeyond * next + kFieldsLeftOut * second;
}

/// By the modes that neither has, and by those beyond the candidates. Steps damp modes that they do not resolve: what
/// these do counts as far as the difference from the richer model does not show it.
double ModelJudge::unseen(const Models& models, std::size_t w) const {
  double sum = 0, hidden = 0;
  for (const auto& c : judgement_.effects.modes) {
    if (has(models, c)) continue;
    if (!has(rich_.models, c))
      sum += carried_[w] * c.effect[w];
    else if (2 * M_PI * c.frequency * pace_.step > kUnresolved)
      hidden += carried_[w] * c.effect[w];
  }
  sum += std::max(0.0, hidden - off_[w]);
  return kCaution * sum + beyond_candidates(w) + by_inertia_[w] * deformed_[w];
}

/// By loads other than inertia: a small part of all deformation. How small, the highest third of the candidates of each
/// body tell, in number: where effects fall as 1/n³ with the number of a mode, all those beyond the last do 0.8 of what
/// these do; under smooth loads they fall faster.
double ModelJudge::beyond_candidates(std::size_t w) const {
  if (asked_.contacts) return kCandidatesTouched * deformed_[w];
  const double part = kCandidates * deformed_[w];
  std::vector<std::vector<std::pair<double, double>>> of_body(static_cast<std::size_t>(asked_.bodies.count()));
  for (const auto& c : judgement_.effects.modes)
    of_body[static_cast<std::size_t>(c.body)].emplace_back(c.frequency, c.effect[w]);
  double highest = 0;
  for (auto& modes : of_body) {
    if (modes.empty()) return part;
    std::sort(modes.begin(), modes.end());
    for (std::size_t i = modes.size() - (modes.size() + 2) / 3; i < modes.size(); ++i) highest += modes[i].second;
  }
  return std::min(part, carried_[w] * highest);
}

double ModelJudge::apart(const Table& samples, const Table& others) const {
  const auto differences = sample_differences(asked_.sensors, samples, others);
  double most = 0;
  for (std::size_t w = 0; w < asked_.count(); ++w) most = std::max(most, differences[w] / judgement_.bounds[w]);
  return most;
}

/// The last difference stays where the ladder has no run at the pace of the richer model. By tolerance each run has
/// steps of its own, and what a loose one leaves over need not fall out of the difference: then the nearest of the runs
/// that are as tight counts.
void ModelJudge::measure_off(const Ladder& ladder) {
  std::size_t i = 0;
  while (i < ladder.runs.size() && (ladder.paces[i].step != pace_.step || ladder.paces[i].tolerance != pace_.tolerance))
    ++i;
  if (i == ladder.runs.size()) return;
  off_ = sample_differences(asked_.sensors, ladder.runs[i].samples, rich_.samples);
  if (pace_.step > 0) return;
  for (++i; i < ladder.runs.size(); ++i) {
    const auto tighter = sample_differences(asked_.sensors, ladder.runs[i].samples, rich_.samples);
    for (std::size_t w = 0; w < asked_.count(); ++w) off_[w] = std::min(off_[w], tighter[w]);
  }
}

std::vector<double> ModelJudge::model_errors(const Ladder& ladder) {
  measure_off(ladder);
  std::vector<double> errors(asked_.count());
  for (std::size_t w = 0; w < asked_.count(); ++w)
    errors[w] = kMeasured * off_[w] + unseen(ladder.last().models, w) + beyond(w);
  return errors;
}

void ModelJudge::judge(const Ladder& ladder) {
  const ModelRun& run = ladder.last();
  measure_scale(run);
  const auto left = left_by_pace(asked_, ladder);
  measure_off(ladder);
  judgement_.errors.assign(asked_.count(), {});
  const bool finest_order = order_of(run.models) == finest(asked_);
  for (std::size_t w = 0; w < asked_.count(); ++w) {
    StatedError& error = judgement_.errors[w];
    const double modes = finest_order ? off_[w] : std::min(off_[w], left_out(run.models, w));
    error.truncation = kMeasured * modes + unseen(run.models, w);
    error.deflection = kMeasured * (off_[w] - modes) + beyond(w);
    if (!asked_.options.small_deflection && finest(asked_) == Deflection::linear)
      error.deflection = std::numeric_limits<double>::quiet_NaN();
    error.time = left[w];
    error.solver = run.residual + kRoundOff * round_off(asked_, run.samples, w);
  }
}

}  // namespace lithe::solving
