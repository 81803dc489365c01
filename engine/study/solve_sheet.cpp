#include <algorithm>
#include <span>

#include "engine/study/solve_internal.h"
#include "engine/study/study_run.h"

namespace lithe {

Solution Solver::finish() {
  bodies_.set(answer_.models);
  Solution solution{{answer_.samples.columns, {}}, {}};
  const std::size_t width = answer_.samples.columns.size();
  for (int row = 0; row < answer_.samples.row_count(); row += finer_)
    solution.samples.add_row(std::span(answer_.samples.values).subspan(static_cast<std::size_t>(row) * width, width));
  Certificate& c = solution.certificate;
  c.scene = options_.scene;
  c.duration = duration_;
  c.simplification = simplification_;
  c.integrator = answer_.integrator;
  c.tolerance = answer_.tolerance.relative;
  c.steps = answer_.statistics.steps;
  c.mean_step = c.steps > 0 ? duration_ / static_cast<double>(c.steps) : 0;
  c.answer_cost = answer_.cost;
  for (std::size_t w = 0; w < count(); ++w)
    c.quantities.push_back({wants_[w].sensor.name(), change_[w], bounds_[w], errors_[w]});
  for (std::size_t b = 0; b < answer_.models.size(); ++b) c.bodies.push_back(describe(b));
  if (rigid_.reached() && !is_rigid(answer_.models)) {
    double error = 0;
    for (std::size_t w = 0; w < count(); ++w) error = std::max(error, kPredicted * deformation_[w] / bounds_[w]);
    ++chosen_;
    trials_.insert(trials_.begin(), {"rigid", rigid_.tolerance.relative, true, error, rigid_.cost});
  }
  c.trials = trials_;
  c.chosen = chosen_;
  remark();
  c.remarks = remarks_;
  c.cost = thread_seconds() - begun_;
  return solution;
}

ChosenBody Solver::describe(std::size_t b) const {
  const DeformableBody& body = *bodies_.bodies()[b];
  ChosenBody out{body.name(), answer_.models[b], body.finest_deflection(), {}, {}, ""};
  for (const auto& e : effects_) {
    if (e.body != static_cast<int>(b)) continue;
    const auto& modes = out.fidelity.modes;
    std::vector<double> effect = e.effect;
    for (std::size_t w = 0; w < count(); ++w) effect[w] *= amplification_[w];
    out.modes.push_back({e.mode, e.frequency, std::find(modes.begin(), modes.end(), e.mode) != modes.end(), effect});
  }
  if (body.finest_deflection() != Deflection::linear && !is_rigid(answer_.models))
    out.deflection_effect = second_order_;
  double share = 0, second = 0;
  for (std::size_t w = 0; w < count(); ++w) {
    share = std::max(share, deformation_.empty() ? kInfinity : deformation_[w] / bounds_[w]);
    second = std::max(second, second_order_.empty() ? 0 : second_order_[w] / bounds_[w]);
  }
  if (out.fidelity.modes.empty())
    out.why = is_rigid(answer_.models)
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

void Solver::remark() {
  if (std::any_of(errors_.begin(), errors_.end(), [](const StatedError& e) { return std::isnan(e.deflection); }))
    remarks_.push_back(
        "what the second order of deflection does cannot be told, so that nothing is certified: the basis has no "
        "data for it; make_basis(model, frame, modes, {.deflection = Deflection::quadratic}) gives it, or "
        "SolveOptions::small_deflection leaves it out of the statement");
  if (largest_part() <= 1) return;
  double truncation = 0, deflection = 0, time = 0;
  for (std::size_t w = 0; w < count(); ++w) {
    truncation = std::max(truncation, errors_[w].truncation / bounds_[w]);
    deflection = std::max(deflection, errors_[w].deflection / bounds_[w]);
    time = std::max(time, errors_[w].time / bounds_[w]);
  }
  if (deflection >= std::max(truncation, time))
    remarks_.push_back(
        order_of(answer_.models) == finest() && finest() < Deflection::quadratic
            ? "no number of modes brings the error down: it is of the second order of deflection, for which the "
              "basis has no data; make_basis(model, frame, modes, {.deflection = Deflection::quadratic}) gives it"
            : "no number of modes brings the error down: the deflection is too large for reduced bodies; model the "
              "body by its nodes (plugins/inertial_body)");
  else if (truncation >= time)
    remarks_.push_back(
        "the candidate modes do not suffice: make_basis() with more of them, and with the interfaces "
        "that are loaded");
  else
    remarks_.push_back("the motion amplifies errors of the integrator: no tolerance tried is tight enough");
}

}  // namespace lithe
