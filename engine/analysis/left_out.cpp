#include "engine/analysis/left_out.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "engine/base/log.h"
#include "engine/model/deformable_body.h"
#include "engine/observe/sensors.h"
#include "engine/observe/snapshot.h"

namespace lithe {
namespace {

constexpr double kSmallMotion = 1e-5;  // along a shape whose largest entry is 1

/// The deformable bodies that have candidates, and those of them that are in use.
std::vector<const DeformableBody*> deformable_bodies(const System& system) {
  std::vector<const DeformableBody*> bodies;
  for (const auto& entry : system.graph().bodies())
    if (const auto* body = dynamic_cast<const DeformableBody*>(entry.body); body)
      if (body->fidelity().deflection != Deflection::exact && body->candidate_stiffness().size() > 0)
        bodies.push_back(body);
  return bodies;
}

VectorX forces_on(Snapshot& now, const DeformableBody& body) {
  std::vector<MarkerLoad> loads;
  const auto add = [&](const auto& markers, const auto& sensor) {
    for (std::size_t m = 0; m < markers.size(); ++m) {
      if (markers[m].body != &body) continue;
      std::array<double, 6> w;
      sensor(static_cast<int>(m)).evaluate(now, w);
      loads.push_back({markers[m].index, {w[0], w[1], w[2]}, {w[3], w[4], w[5]}});
    }
  };
  const SystemGraph& graph = now.system().graph();
  for (const auto& entry : graph.constraints())
    add(entry.markers, [&](int m) { return reaction(*entry.constraint, m); });
  for (const auto& entry : graph.forces()) add(entry.markers, [&](int m) { return applied_force(*entry.force, m); });
  const Layout::BodySlice& slice = now.system().layout().slice(body);
  return body.candidate_forces(now.body_state(body), now.accelerations().data() + slice.v, loads,
                               now.system().gravity());
}

std::vector<int> unused_modes(const DeformableBody& body, Eigen::Index candidates) {
  const std::vector<int>& used = body.fidelity().modes;
  std::vector<int> unused;
  for (int k = 0; k < candidates; ++k)
    if (!std::binary_search(used.begin(), used.end(), k)) unused.push_back(k);
  return unused;
}

}  // namespace

std::vector<DeflectionLeftOut> deflection_left_out(const System& system, const State& state) {
  std::vector<DeflectionLeftOut> out;
  const auto bodies = deformable_bodies(system);
  if (bodies.empty()) return out;
  Snapshot now(system, state);
  for (const DeformableBody* body : bodies) {
    const VectorX stiffness = body->candidate_stiffness(), reach = body->candidate_reach();
    const std::vector<int>& used = body->fidelity().modes;
    const int candidates = static_cast<int>(stiffness.size());
    out.push_back({body->name(), static_cast<int>(used.size()), candidates, 0, 0});
    DeflectionLeftOut& answer = out.back();
    const Layout::BodySlice& slice = system.layout().slice(*body);
    for (std::size_t i = 0; i < used.size(); ++i)
      answer.deflection += reach[used[i]] * std::abs(state.q[slice.q + 7 + static_cast<int>(i)]);
    if (!answer.known()) continue;
    const VectorX forces = forces_on(now, *body);
    for (int k : unused_modes(*body, candidates)) answer.missing += reach[k] * std::abs(forces[k]) / stiffness[k];
    answer.deflection += answer.missing;
  }
  return out;
}

double frequency_left_out(const System& system, const State& state, const VectorX& shape, double inertia,
                          double stiffness) {
  const auto bodies = deformable_bodies(system);
  const double step = kSmallMotion / shape.lpNorm<Eigen::Infinity>();
  State moved = state;
  double softening = 0;
  Snapshot ahead(system), behind(system);
  bool placed = false;
  for (const DeformableBody* body : bodies) {
    const VectorX candidate_stiffness = body->candidate_stiffness();
    const std::vector<int> unused = unused_modes(*body, candidate_stiffness.size());
    if (unused.empty()) continue;
    if (!placed) {
      system.layout().retract(state.q, step * shape, moved.q);
      ahead.evaluate(moved, Accelerations::solved);
      system.layout().retract(state.q, -step * shape, moved.q);
      behind.evaluate(moved, Accelerations::solved);
      placed = true;
    }
    const VectorX change = (forces_on(ahead, *body) - forces_on(behind, *body)) / (2 * step);
    for (int k : unused)
      if (candidate_stiffness[k] > stiffness)
        softening += change[k] * change[k] / (candidate_stiffness[k] - stiffness) / inertia;
  }
  return softening < stiffness ? std::sqrt(stiffness / (stiffness - softening)) - 1 : 1;
}

void tell_left_out(const std::vector<DeflectionLeftOut>& bodies) {
  for (const DeflectionLeftOut& body : bodies) {
    if (!(body.share() > kLeftOutToTell)) continue;
    char share[32];
    std::snprintf(share, sizeof share, "%.0f %%", 100 * body.share());
    log::warn("find_equilibrium: '" + body.name + "' uses " + std::to_string(body.used) + " of " +
              std::to_string(body.candidates) + " modes; the others would be some " + share +
              " of its deflection\n  fix:  use more modes, or static modes of the loaded interfaces "
              "(Reduction::loaded).");
  }
}

}  // namespace lithe
