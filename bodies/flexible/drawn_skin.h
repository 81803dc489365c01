#pragma once

#include <array>
#include <vector>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// The surface of a model whose elements are lines: each point moves with two nodes as their rotations φ say,
///   u = Σ w_i (u_i + φ_i × (x - x_i)),   w = (1 - share, share)
/// For pictures alone.
struct DrawnSkin {
  Matrix3X points;                        // undeformed, axes of the nodes, m
  std::vector<std::array<int, 2>> nodes;  // of each point, by index
  std::vector<double> shares;             // of the second one
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<int, 2>> edges;
};

/// u of all points, x y z of point after point, by the degrees of freedom of the nodes: 3 points x dofs.
SparseMatrix skin_motion(const DrawnSkin& skin, const Matrix3X& nodes, const std::vector<RotationalDof>& rotations);

}  // namespace lithe
