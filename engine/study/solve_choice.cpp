#include <algorithm>
#include <cmath>

#include "engine/study/solve_internal.h"

namespace lithe::solving {
namespace {

bool rigid_bodies_do(const Asked& asked, const RigidMotion& rigid) {
  for (std::size_t w = 0; w < asked.count(); ++w)
    if (!(kPredicted * rigid.deformation[w] < kRigidShare * rigid.bounds[w])) return false;
  return true;
}

/// Something that is wanted does not move in the first order: what moves it is not known, so that nothing may be left
/// out.
bool tells_nothing(const Asked& asked, const RigidMotion& rigid) {
  for (std::size_t w = 0; w < asked.count(); ++w)
    if (rigid.change[w] <= round_off(asked, rigid.run().samples, w)) return true;
  return false;
}

/// By a run of all modes: as each takes part in the strain energy of its body, so much it counts.
std::vector<ModelError::Coordinate> by_energy(const Asked& asked, const RigidMotion& rigid) {
  std::vector<ModelError::Coordinate> modes;
  const ModelRun run = run_at(asked, asked.bodies.all(), rigid.pace, rigid.elastic_scale, true);
  if (!run.reached()) return modes;
  const auto change = sample_changes(asked.sensors, run.samples);
  for (int b = 0; b < asked.bodies.count(); ++b) {
    const DeformableBody* body = asked.bodies.bodies()[static_cast<std::size_t>(b)];
    const auto slice =
        std::find_if(run.slices.begin(), run.slices.end(), [&](const auto& s) { return s.body == body; });
    const VectorX root = body->candidate_stiffness().cwiseSqrt();
    VectorX most = VectorX::Zero(root.size());
    for (const State& state : run.states)
      most = most.cwiseMax(state.q.segment(slice->q + (slice->frame ? 7 : 0), slice->linear).cwiseAbs());
    const VectorX energy = root.cwiseProduct(most);
    for (int k = 0; k < energy.size(); ++k) {
      modes.push_back({b, k, root[k] / (2 * M_PI), most[k], change});
      for (double& effect : modes.back().effect) effect *= energy[k] / std::max(energy.maxCoeff(), 1e-300);
    }
  }
  return modes;
}

}  // namespace

Choice choose(const Asked& asked, const RigidMotion& rigid) {
  const std::vector<double> none(asked.count(), 0);
  Choice choice;
  choice.effects.second_order = choice.effects.fourth_order = none;
  if (!rigid.reached()) {
    choice.models = asked.bodies.all();
    choice.remarks = {"with rigid bodies the run fails: " + rigid.why};
    return choice;
  }
  choice.models = asked.bodies.rigid();
  choice.effects.modes = rigid.deformed.coordinates;
  choice.untold = asked.bodies.count() > 0 && tells_nothing(asked, rigid);
  choice.rigid = asked.bodies.count() == 0 || (!choice.untold && rigid_bodies_do(asked, rigid));
  if (choice.rigid) return choice;
  choice.effects.modes = choice.untold
                             ? by_energy(asked, rigid)
                             : estimate(asked, rigid.run(), asked.bodies.all(), asked.stride, Detail::each).coordinates;
  std::vector<double> bounds = rigid.bounds;
  if (choice.untold && !choice.effects.modes.empty()) {
    bounds.assign(asked.count(), 0);
    for (const auto& c : choice.effects.modes)
      for (std::size_t w = 0; w < asked.count(); ++w) bounds[w] = std::max(bounds[w], c.effect[w]);
    bounds = allowed(asked, bounds, rigid.run().samples);
  }
  for (double share = kModesShare; is_rigid(choice.models) && share > kNoShare; share /= 4)
    choice.models = with_modes(asked, choice.effects.modes, rigid.amplification, bounds, share);
  if (is_rigid(choice.models)) choice.models = asked.bodies.all();
  return choice;
}

}  // namespace lithe::solving
