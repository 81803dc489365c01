#pragma once

#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/forces/joint_coulomb_friction.h"
#include "tests/joints/mechanisms.h"

/// Pieces of the tests of set-valued friction.
namespace lithe::test::coulomb_friction {

inline std::vector<NamedMethod> methods(double h) {
  std::vector<NamedMethod> all;
  all.push_back({"Moreau-Jean", std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = h})});
  all.push_back({"nonsmooth generalized-alpha",
                 std::make_unique<NonsmoothGeneralizedAlpha>(NonsmoothGeneralizedAlpha::Parameters{.step = h})});
  return all;
}

inline JointCoulombFriction& rub(SystemGraph& graph, const std::vector<JointCoordinate>& coordinates,
                                 const Constraint& joint, JointCoulombFriction::Parameters p) {
  p.joint = &joint;
  return add_joint_coulomb_friction(graph, "rub", coordinates, std::move(p));
}

}  // namespace lithe::test::coulomb_friction
