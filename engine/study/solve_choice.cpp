#include <algorithm>

#include "engine/study/solve_internal.h"

namespace lithe::solving {
namespace {

bool rigid_bodies_do(const Asked& asked, const RigidMotion& rigid) {
  for (std::size_t w = 0; w < asked.count(); ++w)
    if (!(kPredicted * rigid.deformation[w] < kRigidShare * rigid.bounds[w])) return false;
  return true;
}

/// Whether the second or fourth order of deflection must be in the model.
bool counts(const RigidMotion& rigid, const std::vector<double>& effect) {
  for (std::size_t w = 0; w < effect.size(); ++w)
    if (!(kCaution * effect[w] < kSecondOrder * rigid.bounds[w])) return true;
  return false;
}

struct ChosenModes {
  std::vector<Fidelity> models;
  ModelError error;  // from the rigid run to these
};

/// Modes that are left out make the body stiffer: the rest of them together may do less than their sum.
ChosenModes choose_modes(const Asked& asked, const RigidMotion& rigid, const ModelError& all) {
  double share = kModesShare;
  const auto with = [&] { return with_modes(asked, all.coordinates, rigid.amplification, rigid.bounds, share); };
  const auto error = [&](const std::vector<Fidelity>& models) {
    return model_error(asked.graph, asked.bodies, rigid.run, models, Missing::modes, asked.sensors, asked.stride);
  };
  const auto close_to_all = [&](const ModelError& some) {
    const auto difference = sample_differences(asked.sensors, some.samples, all.samples);
    for (std::size_t w = 0; w < asked.count(); ++w)
      if (!(rigid.amplification[w] * difference[w] < kModesShare * rigid.bounds[w])) return false;
    return true;
  };
  ChosenModes chosen{with(), {}};
  chosen.error = error(chosen.models);
  for (int round = 0; round < kMostChoices && !close_to_all(chosen.error); ++round) {
    const auto before = chosen.models;
    while (chosen.models == before && share > kNoShare) {
      share /= 4;
      chosen.models = with();
    }
    if (chosen.models == before) break;
    chosen.error = error(chosen.models);
  }
  return chosen;
}

/// From the motion predicted with the first-order modes: what the second order makes of it.
void add_second_order(const Asked& asked, const RigidMotion& rigid, const ModelError& first, Choice& choice) {
  std::vector<Fidelity>& models = choice.models;
  Effects& effects = choice.effects;
  effects.second_order.assign(asked.count(), 0), effects.fourth_order.assign(asked.count(), 0);
  if (is_rigid(models) || !rigid.corrected || finest(asked) == Deflection::linear) return;
  const ModelRun bent =
      with_response(asked.graph, asked.bodies, *rigid.corrected, models, first.response, asked.sensors);
  const auto own = own_remainders(asked.graph, asked.bodies, bent);
  const auto error = [&](Deflection deflection) {
    return model_error(asked.graph, asked.bodies, bent, deflected(asked, models, deflection), Missing::all,
                       asked.sensors, asked.stride, Detail::whole, own);
  };
  const ModelError stiffened = error(Deflection::stiffened);
  effects.second_order = stiffened.effect;
  if (finest(asked) == Deflection::quadratic)
    effects.fourth_order = sample_differences(asked.sensors, error(Deflection::quadratic).samples, stiffened.samples);
  if (counts(rigid, effects.second_order)) {
    double most = 0;
    for (std::size_t w = 0; w < asked.count(); ++w)
      most = std::max(most, kCaution * effects.second_order[w] / rigid.bounds[w]);
    choice.trials.push_back({model_text(asked.bodies, models), 0, false, most, 0});
    models = deflected(asked, models, Deflection::stiffened);
  }
  if (counts(rigid, effects.fourth_order)) models = deflected(asked, models, Deflection::quadratic);
}

/// Rigid bodies could not move as the scene asks: all modes.
Choice fallback(const Asked& asked, const RigidMotion& rigid) {
  const std::vector<double> none(asked.count(), 0);
  return {asked.bodies.all(), {{}, none, none}, {}, {"with rigid bodies the run fails: " + rigid.run.why}};
}

}  // namespace

Choice choose(const Asked& asked, const RigidMotion& rigid) {
  if (!rigid.run.reached()) return fallback(asked, rigid);
  Choice choice;
  if (asked.bodies.count() == 0) return choice;
  choice.models = asked.bodies.rigid();
  choice.effects.modes = rigid.deformed.coordinates;
  if (rigid_bodies_do(asked, rigid)) return choice;
  const ModelError all = model_error(asked.graph, asked.bodies, rigid.run, asked.bodies.all(), Missing::modes,
                                     asked.sensors, asked.stride, Detail::each);
  choice.effects.modes = all.coordinates;
  const ChosenModes chosen = choose_modes(asked, rigid, all);
  choice.models = chosen.models;
  add_second_order(asked, rigid, chosen.error, choice);
  return choice;
}

}  // namespace lithe::solving
