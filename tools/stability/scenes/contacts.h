#pragma once

#include "bodies/rigid_body.h"
#include "engine/cones/direct_cone_solver.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/contact/contact.h"
#include "tools/stability/bench.h"
#include "tools/stability/lab.h"
#include "tools/stability/scenes/ours.h"

/// The library's time stepping, and what the scenes of contact share.
namespace lithe::lab {

constexpr double kGravity = 9.81;  // m/s²

inline Method moreau(double step, std::unique_ptr<ConeSolver> solver = nullptr,
                     Impacts impacts = Impacts::simultaneous) {
  return std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = step, .contact = {.impacts = impacts}},
                                      std::move(solver));
}
inline Method nonsmooth_alpha(double step) {
  return std::make_unique<NonsmoothGeneralizedAlpha>(NonsmoothGeneralizedAlpha::Parameters{.step = step});
}

/// Inertia of a uniform box of these edges (m) and mass (kg), kg m².
inline Vector3 box_inertia(const Vector3& edges, double mass) {
  const Vector3 squares = edges.cwiseAbs2();
  return mass / 12 * Vector3(squares[1] + squares[2], squares[2] + squares[0], squares[0] + squares[1]);
}

/// The library's regularised friction as a force on one coordinate, N, at the sliding speed `v` under the normal force
/// `normal`.
inline double regularised_friction(const ContactFriction& friction, double normal, double v) {
  const Vector3 zero = Vector3::Zero();
  const ContactMotion motion{.gap = -1, .velocity = {0, v, 0}, .spin = zero, .slip = zero, .bristle = zero};
  return compliant_load({.stiffness = normal, .exponent = 1}, friction, motion).force[1];
}

}  // namespace lithe::lab
