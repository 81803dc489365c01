#pragma once

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/model/system_graph.h"

namespace lithe::test {

inline const Matrix3 kAlongY = rotation_about({1, 0, 0}, -M_PI / 2);

/// An arm of 0.4 m along x, rigid, or with four modes; its marker for a hinge about y at its end.
inline Marker arm_root(SystemGraph& graph, bool flexible) {
  if (!flexible)
    return graph.add<RigidBody>("arm", {.mass = 0.2, .inertia = {1e-5, 0.003, 0.003}, .position = {0.2, 0, 0}})
        .marker({-0.2, 0, 0}, kAlongY);
  const auto basis = make_basis(brick_mesh({.size = {0.4, 0.02, 0.02},
                                            .divisions = {4, 1, 1},
                                            .type = "C3D8I",
                                            .material = {2e8, 0.3, 1200},
                                            .name = "arm"}),
                                MeanAxisFrame{}, 4);
  return graph.add<FlexibleBody>("arm", {.basis = basis, .position = {0, 0, -0.01}}).average({1, 2}, kAlongY);
}

}  // namespace lithe::test
