#pragma once

#include <array>

#include "bodies/flexible/finite_element_model.h"

namespace lithe::bench {

/// A box of equal bricks along the mesh axes, one corner at the origin.
struct BrickMesh {
  std::array<int, 3> bricks{};    // along x, y, z
  Vector3 size{1, 1, 1};          // of the box, m
  double young = 1, poisson = 0;  // Pa
  double density = 1;             // kg/m³
};

/// Eight-node bricks (C3D8), 2 x 2 x 2 Gauss points: stiffness and consistent mass of the free body. Node sets:
/// "hinge", the edge x = z = 0; "tip", the middle of the edge at the other end of x (the nearest node).
FiniteElementModel brick_model(const BrickMesh& mesh);

}  // namespace lithe::bench
