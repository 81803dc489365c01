#include <algorithm>

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
  const bool all = asked.bodies.count() > 0 && tells_nothing(asked, rigid);
  choice.rigid = asked.bodies.count() == 0 || (!all && rigid_bodies_do(asked, rigid));
  if (choice.rigid) return choice;
  choice.effects.modes = model_error(asked.graph, asked.bodies, rigid.run(), asked.bodies.all(), Missing::modes,
                                     asked.sensors, asked.stride, Detail::each)
                             .coordinates;
  if (all) choice.models = asked.bodies.all();
  for (double share = kModesShare; is_rigid(choice.models) && share > kNoShare; share /= 4)
    choice.models = with_modes(asked, choice.effects.modes, rigid.amplification, rigid.bounds, share);
  return choice;
}

}  // namespace lithe::solving
