#include "engine/study/modes_left_out.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/analysis/linearization.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/study/model_run.h"

namespace lithe {
namespace {

/// Gives the bodies back the models that they had.
class ModelsKept {
 public:
  explicit ModelsKept(BodyModels& bodies) : bodies_(bodies), models_(bodies.current()) {}
  ~ModelsKept() { bodies_.set(models_); }
  ModelsKept(const ModelsKept&) = delete;
  ModelsKept& operator=(const ModelsKept&) = delete;
  const std::vector<Fidelity>& models() const { return models_; }

 private:
  BodyModels& bodies_;
  const std::vector<Fidelity> models_;
};

/// Which candidate each linear coordinate of a body is.
std::vector<int> candidates_of(const BodyModels& bodies, const std::vector<Fidelity>& models,
                               const Layout::BodySlice& slice) {
  const auto at = std::find(bodies.bodies().begin(), bodies.bodies().end(), slice.body);
  if (at != bodies.bodies().end()) return models[static_cast<std::size_t>(at - bodies.bodies().begin())].modes;
  std::vector<int> all;
  for (int k = 0; k < slice.linear; ++k) all.push_back(k);
  return all;
}

/// The coordinates of a state in the richer layout; modes that the poorer one lacks are zero.
VectorX embedded(const std::vector<Layout::BodySlice>& from, const std::vector<std::vector<int>>& modes,
                 const VectorX& q, const State& to, const Layout& layout) {
  VectorX out = to.q;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Layout::BodySlice& target = layout.bodies()[i];
    const int frame = from[i].frame ? 7 : 0;
    out.segment(target.q, frame) = q.segment(from[i].q, frame);
    out.segment(target.q + frame, target.linear).setZero();
    for (std::size_t k = 0; k < modes[i].size(); ++k)
      out[target.q + frame + modes[i][k]] = q[from[i].q + frame + static_cast<int>(k)];
  }
  return out;
}

double frequency_error(double used, double richer) {
  if (!(used > 0 && richer > 0)) return used > 0 || richer > 0 ? 1 : 0;
  return std::abs(std::sqrt(used / richer) - 1);
}

}  // namespace

ModesLeftOut find_modes_left_out(SystemGraph& graph, const System& system, const Equilibrium& found, double fraction,
                                 const EquilibriumOptions& options) {
  ModesLeftOut answer;
  BodyModels bodies(graph);
  const ModelsKept kept(bodies);
  // 1. The answer in use, in the coordinates of the candidates.
  const std::vector<Layout::BodySlice> slices = system.layout().bodies();
  std::vector<std::vector<int>> modes;
  for (const auto& slice : slices) modes.push_back(candidates_of(bodies, kept.models(), slice));
  answer.lowest_stiffness = linearize(system, found.state).lowest_stiffness();
  // 2. The same with all of them, deflecting as the bodies do.
  std::vector<Fidelity> all = bodies.all();
  for (std::size_t b = 0; b < all.size(); ++b) all[b].deflection = kept.models()[b].deflection;
  bodies.set(all);
  const System richer = assemble(graph);
  State start = richer.initial_state();
  start.time = found.state.time;
  start.quarter_turns = found.state.quarter_turns;
  const VectorX before = embedded(slices, modes, found.state.q, start, richer.layout());
  start.q = before;
  start.v.setZero();
  answer.richer = find_equilibrium(richer, start, options);
  answer.richer_stiffness = linearize(richer, answer.richer.state).lowest_stiffness();
  answer.frequency_error = frequency_error(answer.lowest_stiffness, answer.richer_stiffness);
  // 3. By body: η as far as it moves a node.
  for (std::size_t b = 0; b < all.size(); ++b) {
    const DeformableBody& body = *bodies.bodies()[b];
    const Layout::BodySlice& slice = richer.layout().slice(body);
    const VectorX reach = body.candidate_reach();
    const int first = slice.q + (slice.frame ? 7 : 0);
    const VectorX eta = answer.richer.state.q.segment(first, slice.linear), old = before.segment(first, slice.linear);
    answer.bodies.push_back({body.name(), static_cast<int>(kept.models()[b].modes.size()),
                             static_cast<int>(reach.size()), reach.dot(eta.cwiseAbs()),
                             reach.dot((eta - old).cwiseAbs())});
  }
  for (const ModesLeftOut::Body& body : answer.bodies)
    if (!body.known())
      log::warn("what the modes of '" + body.name + "' leave out is not known: all " + std::to_string(body.candidates) +
                " of its basis are in use\n  fix:  make the basis with more modes, and give .mode_count.");
  if (answer.largest() > fraction)
    log::warn("modes left out matter to this equilibrium:\n" + answer.text() +
              "  fix:  use more modes, or static modes of the loaded interfaces (Reduction::loaded).");
  return answer;
}

double ModesLeftOut::largest() const {
  double most = frequency_error;
  for (const Body& body : bodies) most = std::max(most, body.share());
  return most;
}

std::string ModesLeftOut::text() const {
  std::string text;
  char line[240];
  for (const Body& body : bodies) {
    if (body.known())
      std::snprintf(line, sizeof line, "  %s: %d of %d modes; of %.3g m the others bring %.2g m (%.2g %%)\n",
                    body.name.c_str(), body.used, body.candidates, body.deflection, body.missing, 100 * body.share());
    else
      std::snprintf(line, sizeof line, "  %s: all %d modes of its basis, what others would bring is not known\n",
                    body.name.c_str(), body.candidates);
    text += line;
  }
  std::snprintf(line, sizeof line,
                "  lowest stiffness: %.5g 1/s² with the modes in use, %.5g with all (frequency %.2g %%)\n",
                lowest_stiffness, richer_stiffness, 100 * frequency_error);
  return text + line;
}

}  // namespace lithe
