#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "engine/study/solve_internal.h"
#include "engine/study/study_run.h"

namespace lithe::solving {
namespace {

/// What runs next.
struct Plan {
  std::vector<Fidelity> models;
  double tolerance;
  double share = kModesShare;  // of what is allowed, for modes left out
  bool by_steps = true;        // try_steps() first
};

struct SteppedRun {
  ModelRun run;
  std::vector<double> error;  // by its steps
};

/// Steps as long as the samples are apart, and half of that: the finer run if the difference, a third of which is left
/// in it, is a small part of what is allowed.
std::optional<SteppedRun> try_steps(const Asked& asked, const std::vector<Fidelity>& models,
                                    const std::vector<double>& change, const std::vector<double>& bounds) {
  if (!asked.methods.by_step || change.empty()) return {};
  for (std::size_t w = 0; w < asked.count(); ++w)
    if (bounds[w] < kCoarse * change[w]) return {};
  const double interval = asked.duration / asked.samples();
  const ModelRun coarse = run_stepped(asked, models, interval, false);
  if (!coarse.reached()) return {};
  SteppedRun fine{run_stepped(asked, models, interval / 2, true), {}};
  if (!fine.run.reached()) return {};
  fine.error = sample_differences(asked.sensors, coarse.samples, fine.run.samples);
  for (std::size_t w = 0; w < asked.count(); ++w) {
    fine.error[w] *= kStepsLeft;
    if (!(fine.error[w] < kStepsShare * bounds[w])) return {};
  }
  return fine;
}

// ---- the errors of a run, along its own motion ----

/// How far the first order carries here: the change by deformation as it came, over that predicted.
std::vector<double> carried_so_far(const Asked& asked, const RigidMotion& rigid, const ModelRun& run) {
  std::vector<double> carried(asked.count(), 1);
  if (!rigid.run.reached()) return carried;
  const auto came = sample_differences(asked.sensors, run.samples, rigid.run.samples);
  for (std::size_t w = 0; w < asked.count(); ++w)
    if (rigid.deformed_by(w) > 0) carried[w] = std::clamp(came[w] / rigid.deformation[w], 1.0, 10.0);
  return carried;
}

/// What the modes left out do to the motion at large.
std::vector<double> moved_at_large(const Asked& asked, const RigidMotion& rigid, const ModelError& rest) {
  if (rigid.run.reached() && !rest.coordinates.empty()) {
    const ModelRun moved =
        run_model(asked.graph, asked.bodies, asked.bodies.rigid(), asked.sensors, asked.methods.by_tolerance,
                  request(asked, kFirstTolerance, 1, false), rest.feedback);
    if (moved.reached()) return sample_differences(asked.sensors, moved.samples, rigid.run.samples);
  }
  return std::vector<double>(asked.count(), 0);
}

/// What the order of deflection beyond the run's does; an order that is in reach is looked at, and then known better.
std::vector<double> next_order(const Asked& asked, const RigidMotion& rigid, const ModelRun& run, Effects& effects) {
  std::vector<double> next(asked.count(), 0);
  const Deflection order = order_of(run.models);
  if (order < finest(asked)) {
    const Deflection above = order == Deflection::linear ? Deflection::stiffened : Deflection::quadratic;
    next = model_error(asked.graph, asked.bodies, run, deflected(asked, run.models, above), Missing::all, asked.sensors,
                       asked.stride)
               .effect;
    auto& known = order == Deflection::linear ? effects.second_order : effects.fourth_order;
    for (std::size_t w = 0; w < asked.count(); ++w) known[w] = std::max(known[w], next[w]);
  } else if (order != Deflection::linear) {  // orders fall as the second fell from the first
    const auto& last = order == Deflection::quadratic ? effects.fourth_order : effects.second_order;
    for (std::size_t w = 0; w < asked.count(); ++w)
      if (rigid.deformed_by(w) > 0) next[w] = last[w] * std::min(1.0, effects.second_order[w] / rigid.deformation[w]);
  }
  if (order != Deflection::linear)
    for (std::size_t w = 0; w < asked.count(); ++w) next[w] += kFieldsLeftOut * effects.second_order[w];
  return next;
}

/// Error over tolerance.
double time_worth(const RigidMotion& rigid, const ModelRun& run, double change, std::size_t w) {
  const bool implicit = 10 * run.statistics.newton_iterations > run.statistics.steps;
  return (rigid.time_worth.empty() ? change : rigid.time_worth[w]) +
         (implicit ? kImplicitTime : kExplicitTime) * rigid.deformed_by(w);
}

Judgement judge(const Asked& asked, const RigidMotion& rigid, const ModelRun& run, Effects effects) {
  Judgement judgement;
  judgement.change = sample_changes(asked.sensors, run.samples);
  judgement.bounds = allowed(asked, judgement.change, run.samples);
  const ModelError rest =
      model_error(asked.graph, asked.bodies, run, asked.bodies.all(), Missing::modes, asked.sensors, 1, Detail::each);
  for (const auto& c : rest.coordinates)
    for (auto& known : effects.modes)
      if (known.body == c.body && known.mode == c.mode) known = c;
  if (effects.modes.empty()) effects.modes = rest.coordinates;
  const auto carried = carried_so_far(asked, rigid, run);
  const auto at_large = moved_at_large(asked, rigid, rest);
  const auto next = next_order(asked, rigid, run, effects);
  judgement.errors.resize(asked.count());
  for (std::size_t w = 0; w < asked.count(); ++w) {
    StatedError& error = judgement.errors[w];
    error.truncation = kCaution * carried[w] * (rest.effect[w] + at_large[w]) + kCandidates * rigid.deformed_by(w);
    error.deflection = kCaution * next[w];
    if (!asked.options.small_deflection && finest(asked) == Deflection::linear)
      error.deflection = std::numeric_limits<double>::quiet_NaN();
    error.time = run.tolerance.relative * time_worth(rigid, run, judgement.change[w], w);
    error.solver = run.residual + kRoundOff * round_off(asked, run.samples, w);
  }
  judgement.effects = std::move(effects);
  return judgement;
}

/// Where reactions or accelerations are wanted, modes that hardly move show: a second run at a looser tolerance
/// tells.
void judge_rough(const Asked& asked, const RigidMotion& rigid, const ModelRun& run, std::vector<StatedError>& errors) {
  const ModelRun looser =
      run_logged(asked, run.models, request(asked, 10 * run.tolerance.relative, rigid.elastic_scale, false));
  const auto difference = sample_differences(asked.sensors, run.samples, looser.samples);
  for (std::size_t w = 0; w < asked.count(); ++w)
    if (rigid.run.rough.empty() || rigid.run.rough[w])
      errors[w].time = looser.reached() ? kRoughTime * difference[w] : kInfinity;
}

// ---- a finer model ----

/// Modes that no load drives keep joints from being redundant: all up to the highest chosen, then all.
bool complete(const Asked& asked, std::vector<Fidelity>& models) {
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

bool add_modes(std::vector<Fidelity>& models, const std::vector<Fidelity>& more) {
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

bool raise_order(const Asked& asked, std::vector<Fidelity>& models) {
  const Deflection order = order_of(models);
  if (order >= finest(asked)) return false;
  models = deflected(asked, models, order == Deflection::linear ? Deflection::stiffened : Deflection::quadratic);
  return true;
}

/// Refines what counts most; false if nothing is left to refine.
bool improve(const Asked& asked, const RigidMotion& rigid, const Judgement& judgement, Plan& plan) {
  const StatedError parts = judgement.largest_parts();
  const Effects& effects = judgement.effects;
  bool better = false;
  if (parts.deflection > 0.3) better = raise_order(asked, plan.models);
  if (parts.truncation > 0.3 && !effects.modes.empty()) {
    plan.share *= 0.3 / parts.truncation;
    for (bool more = false; !more && plan.share > kNoShare; plan.share /= 4)
      more =
          add_modes(plan.models, with_modes(asked, effects.modes, rigid.amplification, judgement.bounds, plan.share));
    better |= plan.share > kNoShare;
    plan.models = deflected(asked, plan.models, order_of(plan.models));
  }
  if (plan.by_steps && parts.time > 0.3) {
    plan.by_steps = false;
    return true;
  }
  if (parts.time > 0.3 && plan.tolerance > kTightest) {
    plan.tolerance = std::max(kTightest, plan.tolerance * 0.1 / parts.time);
    better = true;
  }
  return better;
}

/// Bodies must be exact, and can be.
bool beyond_modes(const Asked& asked, const Answer& answer) {
  return asked.has_meshes() && order_of(answer.run.models) == finest(asked) &&
         answer.judgement.largest_parts().deflection > 1;
}

}  // namespace

Answer accept_rigid(const Asked& asked, const RigidMotion& rigid, const Choice& choice) {
  Answer answer{.run = rigid.run,
                .judgement = {rigid.change, rigid.bounds, std::vector<StatedError>(asked.count()), choice.effects},
                .trials = choice.trials,
                .remarks = choice.remarks};
  if (rigid.tolerance < kFirstTolerance / 10) {
    ModelRun tight =
        run_logged(asked, asked.bodies.rigid(), request(asked, rigid.tolerance, rigid.elastic_scale, false));
    if (tight.reached())
      answer.run = std::move(tight);
    else
      answer.remarks.push_back("rigid, tolerance " + short_number(rigid.tolerance) + ": " + tight.why);
  } else if (rigid.tolerance < kFirstTolerance && rigid.tighter) {
    answer.run = *rigid.tighter;
  }
  for (std::size_t w = 0; w < asked.count(); ++w) {
    StatedError& error = answer.judgement.errors[w];
    error.truncation = kPredicted * rigid.deformation[w];
    error.time = rigid.time_worth[w] * answer.run.tolerance.relative;
    error.solver = answer.run.residual + kRoundOff * round_off(asked, answer.run.samples, w);
  }
  note(asked, answer);
  return answer;
}

Answer refine(const Asked& asked, const RigidMotion& rigid, const Choice& choice) {
  Plan plan{.models = choice.models, .tolerance = rigid.tolerance};
  Answer answer{.run = {},
                .judgement = {rigid.change, rigid.bounds, {}, choice.effects},
                .trials = choice.trials,
                .remarks = choice.remarks};
  for (int round = 0; round < asked.options.most_runs; ++round) {
    std::optional<SteppedRun> stepped;
    if (plan.by_steps) stepped = try_steps(asked, plan.models, answer.judgement.change, answer.judgement.bounds);
    plan.by_steps = stepped.has_value();
    ModelRun run = stepped ? std::move(stepped->run)
                           : run_logged(asked, plan.models, request(asked, plan.tolerance, rigid.elastic_scale, true));
    if (!run.reached()) {
      answer.why = run.why;
      answer.trials.push_back(trial(asked, run, kInfinity));
      answer.remarks.push_back(model_text(asked.bodies, plan.models) + ": " + run.why);
      if (!complete(asked, plan.models) && !raise_order(asked, plan.models)) plan.tolerance /= 10;
      continue;
    }
    answer.judgement = judge(asked, rigid, run, std::move(answer.judgement.effects));
    std::vector<StatedError>& errors = answer.judgement.errors;
    if (stepped)
      for (std::size_t w = 0; w < asked.count(); ++w) errors[w].time = stepped->error[w];
    else if (rigid.is_rough())
      judge_rough(asked, rigid, run, errors);
    answer.run = std::move(run);
    note(asked, answer);
    if (answer.met() || beyond_modes(asked, answer) || !improve(asked, rigid, answer.judgement, plan)) break;
  }
  return answer;
}

}  // namespace lithe::solving
