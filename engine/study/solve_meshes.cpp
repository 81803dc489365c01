#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/error.h"
#include "engine/study/solve_internal.h"

namespace lithe::solving {
namespace {

using Models = std::vector<Fidelity>;

bool has_mesh(const Asked& asked, const Models& models, std::size_t b) {
  const Fidelity& model = models[b];
  return asked.bodies.bodies()[b]->element_count(0) > 0 &&
         (!model.modes.empty() || model.deflection == Deflection::exact);
}

/// As many elements as drawn, times the factor, in bodies that deform.
Models meshed(const Asked& asked, Models models, double factor) {
  for (std::size_t b = 0; b < models.size(); ++b) {
    if (!has_mesh(asked, models, b)) continue;
    const int elements = static_cast<int>(std::lround(factor * asked.bodies.bodies()[b]->element_count(0)));
    models[b].elements = std::clamp(elements, kFewestElements, kMostElements);
  }
  return models;
}

/// What the finer of two meshes leaves over, by their difference. Unknown (infinite) if they are hardly finer, as with
/// stations that leave no choice.
std::vector<double> mesh_error(const Asked& asked, const ModelRun& coarse, const ModelRun& fine) {
  double ratio = kInfinity;
  for (std::size_t b = 0; b < fine.models.size(); ++b)
    if (has_mesh(asked, fine.models, b)) {
      const DeformableBody& body = *asked.bodies.bodies()[b];
      ratio = std::min(ratio, static_cast<double>(body.element_count(fine.models[b].elements)) /
                                  body.element_count(coarse.models[b].elements));
    }
  if (!coarse.reached() || !(ratio >= kMeshRatio)) return std::vector<double>(asked.count(), kInfinity);
  std::vector<double> error = sample_differences(asked.sensors, coarse.samples, fine.samples);
  for (double& e : error) e *= kMeshCaution / (ratio * ratio - 1);
  return error;
}

/// By how much finer a mesh must be.
double refinement(double part) {
  return std::isfinite(part) ? std::clamp(std::exp2(std::ceil(0.5 * std::log2(part / kMeshShare))), 2.0, 4.0) : 2;
}

// ---- bodies reduced to modes ----

/// All candidates: which modes span the same motion in another mesh is not known of fewer.
Models all_modes(const Asked& asked, const Answer& answer, double factor) {
  Models models = answer.run.models;
  for (std::size_t b = 0; b < models.size(); ++b) {
    if (!has_mesh(asked, models, b)) continue;
    const Eigen::Index candidates = asked.bodies.bodies()[b]->candidate_stiffness().size();
    models[b].modes.clear();
    for (int k = 0; k < candidates; ++k) models[b].modes.push_back(k);
  }
  return meshed(asked, std::move(models), factor);
}

/// What the elements behind the modes leave over, and finer ones while that alone is too much.
void refine_reduced(const Asked& asked, const RigidMotion& rigid, Answer& answer) {
  const Pace pace{answer.run.step, answer.run.tolerance.relative};
  const auto run = [&](double times) {
    return run_at(asked, all_modes(asked, answer, times), pace, rigid.elastic_scale, false);
  };
  std::vector<StatedError>& errors = answer.judgement.errors;
  const auto state = [&](const std::vector<double>& left) {
    for (std::size_t w = 0; w < asked.count(); ++w) errors[w].mesh = left[w];
  };
  ModelRun coarse = run(0.5), fine = run(1);
  if (!fine.reached()) return;
  state(mesh_error(asked, coarse, fine));
  answer.trials[static_cast<std::size_t>(answer.chosen)].error = answer.judgement.largest_part();
  double factor = 1;
  for (int round = 1; !answer.met() && round < asked.options.most_runs; ++round) {
    factor *= refinement(answer.judgement.largest_parts().mesh);
    ModelRun finer = run(factor);
    if (!finer.reached()) return;
    state(mesh_error(asked, fine, finer));
    answer.run = finer;
    fine = std::move(finer);
    note(asked, answer);
  }
}

// ---- exact bodies ----

/// Of bodies that deform; all of them where no model with modes came to the end.
Models exact(const Asked& asked, const Answer& modal, double factor) {
  const bool unknown = modal.chosen < 0;
  Models models = unknown ? asked.bodies.all(finest(asked)) : modal.run.models;
  for (std::size_t b = 0; b < models.size(); ++b)
    if (has_mesh(asked, models, b)) models[b] = {{}, Deflection::exact};
  return meshed(asked, std::move(models), factor);
}

/// What bodies leave out that are not exact.
void judge_others(const Asked& asked, const Answer& modal, const Models& models, std::vector<StatedError>& errors) {
  const auto model = [&](int b) -> const Fidelity& { return models[static_cast<std::size_t>(b)]; };
  const auto is_exact = [&](int b) { return model(b).deflection == Deflection::exact; };
  for (const auto& c : modal.judgement.effects.modes) {
    const auto& used = model(c.body).modes;
    if (is_exact(c.body) || std::binary_search(used.begin(), used.end(), c.mode)) continue;
    for (std::size_t w = 0; w < asked.count(); ++w) errors[w].truncation += kCaution * c.effect[w];
  }
  bool others = false;
  for (int b = 0; b < asked.bodies.count(); ++b) others |= !is_exact(b) && !model(b).modes.empty();
  if (!others) return;
  for (std::size_t w = 0; w < asked.count(); ++w)
    errors[w].deflection = modal.chosen >= 0 ? modal.judgement.errors[w].deflection : kInfinity;
}

/// The error of the finer of two exact runs: of its elements by the coarser, of its steps by ones of a looser tolerance
/// there.
void judge_exact(const Asked& asked, const RigidMotion& rigid, const Answer& modal, const ModelRun& coarse,
                 ModelRun fine, Answer& answer) {
  const ModelRun looser = run_at(asked, coarse.models, {0, 10 * coarse.tolerance.relative}, rigid.elastic_scale, false);
  Judgement& judgement = answer.judgement;
  judgement.change = sample_changes(asked.sensors, fine.samples);
  judgement.bounds = allowed(asked, judgement.change, fine.samples);
  judgement.errors.assign(asked.count(), {});
  judge_others(asked, modal, fine.models, judgement.errors);
  const auto mesh = mesh_error(asked, coarse, fine);
  const auto time = sample_differences(asked.sensors, coarse.samples, looser.samples);
  for (std::size_t w = 0; w < asked.count(); ++w) {
    StatedError& error = judgement.errors[w];
    error.mesh = mesh[w];
    error.time = looser.reached() ? kToleranceCaution / 10 * time[w] : kInfinity;
    error.solver = fine.residual + kRoundOff * round_off(asked, fine.samples, w);
  }
  answer.run = std::move(fine);
}

/// Chosen is -1 if none reaches the end.
Answer answer_exactly(const Asked& asked, const RigidMotion& rigid, const Answer& modal) {
  Answer answer{.run = {},
                .judgement = {{}, {}, {}, modal.judgement.effects},
                .trials = modal.trials,
                .remarks = modal.remarks,
                .why = modal.why};
  double factor = 1, tolerance = kFirstTolerance;
  const auto run = [&](double times) {
    return run_at(asked, exact(asked, modal, times), {0, tolerance}, rigid.elastic_scale, false);
  };
  std::optional<ModelRun> coarse;  // at the present tolerance
  for (int round = 0; round < asked.options.most_runs; ++round) {
    if (!coarse) coarse = run(factor / 2);
    ModelRun fine = run(factor);
    if (!coarse->reached() || !fine.reached()) {
      answer.why = fine.reached() ? coarse->why : fine.why;
      answer.trials.push_back(trial(asked, fine, kInfinity));
      tolerance = std::max(kTightest, tolerance / 10);
      coarse.reset();
      continue;
    }
    judge_exact(asked, rigid, modal, *coarse, std::move(fine), answer);
    note(asked, answer);
    if (answer.met()) break;
    const StatedError parts = answer.judgement.largest_parts();
    const bool loose_steps = parts.time > kMeshShare && tolerance > kTightest;
    const double finer = parts.mesh > kMeshShare ? refinement(parts.mesh) : 1;
    if (!loose_steps && finer == 1) break;
    if (loose_steps) tolerance = std::max(kTightest, tolerance * std::max(1e-3, 0.3 * kMeshShare / parts.time));
    factor *= finer;
    coarse = answer.run;
    if (loose_steps || finer != 2) coarse.reset();
  }
  return answer;
}

}  // namespace

Answer refine_meshes(const Asked& asked, const RigidMotion& rigid, Answer answer) {
  if (asked.has_meshes()) {
    if (answer.met()) refine_reduced(asked, rigid, answer);
    if (!answer.met()) {
      Answer exactly = answer_exactly(asked, rigid, answer);
      if (exactly.chosen >= 0 &&
          (answer.chosen < 0 || exactly.judgement.largest_part() < answer.judgement.largest_part()))
        answer = std::move(exactly);
      else
        answer.trials = exactly.trials, answer.why = exactly.why;
    }
  }
  if (answer.chosen < 0)
    throw SimulationError("no model of the scene reached the end: " + answer.why, "solve",
                          "run the scene by itself first: diagnose() tells why it fails");
  return answer;
}

}  // namespace lithe::solving
