#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "engine/base/number_text.h"
#include "engine/study/solve_internal.h"
#include "engine/study/study_run.h"

namespace lithe::solving {
namespace {

ChosenBody describe(const Asked& asked, const RigidMotion& rigid, const Answer& answer, std::size_t b) {
  const DeformableBody& body = *asked.bodies.bodies()[b];
  const auto& [change, bounds, errors, effects] = answer.judgement;
  const std::vector<Fidelity>& models = answer.run.models;
  ChosenBody out{.name = body.name(),
                 .fidelity = models[b],
                 .finest = body.finest_deflection(),
                 .elements = body.element_count(models[b].elements)};
  for (const auto& e : effects.modes) {
    if (e.body != static_cast<int>(b)) continue;
    const auto& modes = out.fidelity.modes;
    std::vector<double> effect = e.effect;
    for (std::size_t w = 0; w < asked.count(); ++w) effect[w] *= rigid.amplification[w];
    out.modes.push_back({e.mode, e.frequency, std::find(modes.begin(), modes.end(), e.mode) != modes.end(), effect});
  }
  const bool exact = models[b].deflection == Deflection::exact;
  if (body.finest_deflection() != Deflection::linear && !is_rigid(models) && !exact)
    out.deflection_effect = effects.second_order;
  double share = 0, second = 0;
  for (std::size_t w = 0; w < asked.count(); ++w) {
    share = std::max(share, rigid.deformation.empty() ? kInfinity : rigid.deformation[w] / bounds[w]);
    second = std::max(second, effects.second_order.empty() ? 0 : effects.second_order[w] / bounds[w]);
  }
  if (exact)
    out.why = "modes do not do: what they leave out of large deflection is more than is allowed";
  else if (out.fidelity.modes.empty())
    out.why = is_rigid(models)
                  ? "all deformation changes what is wanted by " + short_number(100 * share) + " % of what is allowed"
                  : "its deformation changes what is wanted by little beside that of others";
  else
    out.why = "a rigid body would be off by " + short_number(share) + " times what is allowed" +
              (share < 1 ? ", too much for an estimate to vouch for" : "") +
              (out.fidelity.deflection == Deflection::linear
                   ? ""
                   : "; any number of linear modes by " + short_number(second) + " times");
  return out;
}

/// What a reader must know of errors that are too large, or unknown.
std::vector<std::string> remarks_on_errors(const Asked& asked, const Answer& answer) {
  std::vector<std::string> remarks;
  const auto& errors = answer.judgement.errors;
  if (std::any_of(errors.begin(), errors.end(), [](const StatedError& e) { return std::isnan(e.deflection); }))
    remarks.push_back(
        "what the second order of deflection does cannot be told, so that nothing is certified: the basis has no "
        "data for it; make_basis(model, frame, modes, {.deflection = Deflection::quadratic}) gives it, or "
        "SolveOptions::small_deflection leaves it out of the statement");
  if (answer.judgement.largest_part() <= 1) return remarks;
  const StatedError parts = answer.judgement.largest_parts();
  if (parts.mesh >= std::max({parts.truncation, parts.deflection, parts.time}) && parts.mesh > 0)
    remarks.push_back(
        "more elements are needed than were tried: draw the body with more, or give sections that change less");
  else if (parts.deflection >= std::max(parts.truncation, parts.time))
    remarks.push_back(
        order_of(answer.run.models) == finest(asked) && finest(asked) < Deflection::quadratic
            ? "no number of modes brings the error down: it is of the second order of deflection, for which the "
              "basis has no data; make_basis(model, frame, modes, {.deflection = Deflection::quadratic}) gives it"
            : "no number of modes brings the error down: the deflection is too large for reduced bodies; draw a "
              "slender body as SlenderBody, model others by their nodes (plugins/inertial_body)");
  else if (parts.truncation >= parts.time)
    remarks.push_back(
        "the candidate modes do not suffice: make_basis() with more of them, and with the interfaces "
        "that are loaded");
  else
    remarks.push_back("the motion amplifies errors of the integrator: no tolerance tried is tight enough");
  return remarks;
}

/// The samples that were asked for.
Table samples_of(const Asked& asked, const Table& looked_at) {
  Table samples{looked_at.columns, {}};
  const std::size_t width = looked_at.columns.size();
  for (int row = 0; row < looked_at.row_count(); row += asked.finer)
    samples.add_row(std::span(looked_at.values).subspan(static_cast<std::size_t>(row) * width, width));
  return samples;
}

}  // namespace

Solution certify(const Asked& asked, const RigidMotion& rigid, const Answer& answer, double begun) {
  const ModelRun& run = answer.run;
  const auto& [change, bounds, errors, effects] = answer.judgement;
  asked.bodies.set(run.models);
  Solution solution{samples_of(asked, run.samples), {}};
  Certificate& c = solution.certificate;
  c.scene = asked.options.scene;
  c.duration = asked.duration;
  c.simplification = asked.simplification;
  c.integrator = run.integrator;
  c.tolerance = run.tolerance.relative;
  c.steps = run.statistics.steps;
  c.mean_step = c.steps > 0 ? asked.duration / static_cast<double>(c.steps) : 0;
  c.answer_cost = run.cost;
  for (std::size_t w = 0; w < asked.count(); ++w)
    c.quantities.push_back({asked.wants[w].sensor.name(), change[w], bounds[w], errors[w]});
  for (std::size_t b = 0; b < run.models.size(); ++b) c.bodies.push_back(describe(asked, rigid, answer, b));
  c.trials = answer.trials;
  c.chosen = answer.chosen;
  if (rigid.reached() && !is_rigid(run.models)) {
    double error = 0;
    for (std::size_t w = 0; w < asked.count(); ++w)
      error = std::max(error, kPredicted * rigid.deformation[w] / bounds[w]);
    c.trials.insert(c.trials.begin(), {"rigid", rigid.run().tolerance.relative, true, error, rigid.run().cost});
    ++c.chosen;
  }
  for (const auto& remarks : {asked.remarks, answer.remarks, remarks_on_errors(asked, answer)})
    c.remarks.insert(c.remarks.end(), remarks.begin(), remarks.end());
  c.costs = asked.costs;
  c.cost = thread_seconds() - begun;
  return solution;
}

}  // namespace lithe::solving
