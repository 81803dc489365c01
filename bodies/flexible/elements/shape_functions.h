#pragma once

#include <string>
#include <vector>

#include "engine/base/math.h"

namespace lithe {

/// Shape functions of a solid at one place, in natural coordinates ξ (bricks: [-1, 1]³; tetrahedra: ξ >= 0, Σ ξ <= 1).
struct ShapeValues {
  VectorX values;     // N_a
  MatrixX gradients;  // ∂N_a/∂ξ, nodes x 3
};

/// A place in natural coordinates and its weight in an integral over them.
struct IntegrationPoint {
  Vector3 xi;
  double weight;
};

/// Lagrange (4, 8, 10 nodes) or serendipity (20 nodes) shapes; node order of Abaqus and CalculiX: corners, then the
/// middles of the edges. Source: Dhondt, The Finite Element Method for Three-Dimensional Thermomechanical
/// Applications, 2004, section 2.1.
ShapeValues shape_functions(int node_count, const Vector3& xi);

/// Natural coordinates of the nodes, 3 x node_count.
Matrix3X natural_nodes(int node_count);

/// Gauss points per direction along a brick, first coordinate fastest: 2³ (exact to the third power) or 3³ (fifth).
std::vector<IntegrationPoint> brick_rule(int points_per_direction);
/// 1, 4 or 15 points of a tetrahedron, exact to degree 1, 2, 5 (Keast 1986, Comput. Meth. Appl. Mech. Eng. 55, 339).
std::vector<IntegrationPoint> tetrahedron_rule(int points);

/// B of ∇N (nodes x 3): small strain ε = B u, order xx yy zz xy xz yz, engineering shear.
MatrixX strain_matrix(const MatrixX& gradients);

}  // namespace lithe
