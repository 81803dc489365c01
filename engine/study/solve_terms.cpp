#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/study/solve_internal.h"

namespace lithe::solving {

double Judgement::largest_part() const {
  double most = 0;
  for (std::size_t w = 0; w < errors.size(); ++w) {
    StatedError known = errors[w];
    if (std::isnan(known.deflection)) known.deflection = 0;
    most = std::max(most, known.total() / bounds[w]);
  }
  return most;
}

StatedError Judgement::largest_parts() const {
  StatedError parts;
  for (std::size_t w = 0; w < errors.size(); ++w) {
    parts.truncation = std::max(parts.truncation, errors[w].truncation / bounds[w]);
    parts.deflection = std::max(parts.deflection, errors[w].deflection / bounds[w]);
    parts.mesh = std::max(parts.mesh, errors[w].mesh / bounds[w]);
    parts.time = std::max(parts.time, errors[w].time / bounds[w]);
  }
  return parts;
}

// ---- runs ----

std::vector<double> allowed(const Asked& asked, const std::vector<double>& change, const Table& samples) {
  std::vector<double> bounds(asked.count());
  for (std::size_t w = 0; w < asked.count(); ++w) {
    const Precision& p = asked.wants[w].precision;
    bounds[w] = p.relative ? p.value * std::max(change[w], round_off(asked, samples, w)) : p.value;
  }
  return bounds;
}

double round_off(const Asked& asked, const Table& samples, std::size_t w) {
  int column = 1;
  for (std::size_t s = 0; s < w; ++s) column += static_cast<int>(asked.sensors[s].columns().size());
  double size = 1;
  for (std::size_t i = 0; i < asked.sensors[w].columns().size(); ++i)
    size = std::max(size, std::abs(samples.at(0, column + static_cast<int>(i))));
  return 1e-9 * size;
}

CertificateTrial trial(const Asked& asked, const ModelRun& run, double error) {
  return {model_text(asked.bodies, run.models), run.tolerance.relative, true, error, run.cost};
}

void note(const Asked& asked, Answer& answer) {
  answer.trials.push_back(trial(asked, answer.run, answer.judgement.largest_part()));
  answer.chosen = static_cast<int>(answer.trials.size()) - 1;
}

// ---- models ----

bool Asked::has_meshes() const {
  return std::any_of(bodies.bodies().begin(), bodies.bodies().end(),
                     [](const DeformableBody* body) { return body->element_count(0) > 0; });
}

bool is_rigid(const std::vector<Fidelity>& models) {
  return std::all_of(models.begin(), models.end(),
                     [](const Fidelity& m) { return m.modes.empty() && m.deflection != Deflection::exact; });
}

Deflection finest(const Asked& asked) {
  Deflection finest = Deflection::linear;
  for (const DeformableBody* body : asked.bodies.bodies()) finest = std::max(finest, body->finest_deflection());
  return finest;
}

Deflection order_of(const std::vector<Fidelity>& models) {
  Deflection order = Deflection::linear;
  for (const Fidelity& m : models) order = std::max(order, m.deflection);
  return order;
}

std::vector<Fidelity> deflected(const Asked& asked, std::vector<Fidelity> models, Deflection deflection) {
  const auto& bodies = asked.bodies.bodies();
  for (std::size_t b = 0; b < models.size(); ++b)
    if (!models[b].modes.empty()) models[b].deflection = std::min(deflection, bodies[b]->finest_deflection());
  return models;
}

std::vector<Fidelity> with_modes(const Asked& asked, const std::vector<ModelError::Coordinate>& modes,
                                 const std::vector<double>& amplification, const std::vector<double>& bounds,
                                 double share) {
  const auto severity = [&](const ModelError::Coordinate& c) {
    double most = 0;
    for (std::size_t w = 0; w < asked.count(); ++w) most = std::max(most, amplification[w] * c.effect[w] / bounds[w]);
    return most;
  };
  std::vector<std::size_t> order(modes.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return severity(modes[a]) < severity(modes[b]); });
  std::vector<Fidelity> models = asked.bodies.rigid();
  double sum = 0;
  for (std::size_t i : order) {
    const auto& c = modes[i];
    sum += severity(c);
    if (sum > share) models[static_cast<std::size_t>(c.body)].modes.push_back(c.mode);
  }
  for (Fidelity& m : models) std::sort(m.modes.begin(), m.modes.end());
  return models;
}

}  // namespace lithe::solving
