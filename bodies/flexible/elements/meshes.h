#pragma once

#include <array>
#include <string>

#include "bodies/flexible/finite_element_model.h"
#include "engine/base/math.h"

namespace lithe {

/// A box of elements with a corner at the mesh origin, edges along x, y, z:
///   const auto model = brick_mesh({.size = {0.1, 0.01, 0.015}, .divisions = {8, 2, 1}, .material = {2e11, 0.3,
///   7800}});
struct BrickMeshParameters {
  Vector3 size{1, 1, 1};                  // length, width, height, m
  std::array<int, 3> divisions{1, 1, 1};  // cells along x, y, z
  std::string type = "C3D20";  // C3D8I bends as well at a third of the nodes; C3D4, C3D10: six tetrahedra a cell
  Material material{};
  std::string name = "brick";
};
/// A round rod along x, its axis from the origin to (length, 0, 0). The cross-section is a square of cells pressed into
/// the circle, on which its outer nodes lie: elements of the first order lack the segments between them (`across` = 4:
/// 2.6 % of the mass), and stress is poor at the four nodes of the rim where the square had its corners.
struct RodMesh {
  double length = 1, radius = 0.1;  // m
  int along = 8, across = 4;        // cells along the axis, and across the diameter
  std::string type = "C3D20";
  Material material{};
  std::string name = "rod";
};
/// A rectangular plate, its middle plane from (0, 0, 0) to (length, width, 0), thickness along z: a brick of one layer.
struct PlateMesh {
  double length = 1, width = 1, thickness = 0.01;  // m
  std::array<int, 2> divisions{8, 8};              // cells along x and y
  std::string type = "C3D20";
  Material material{};
  std::string name = "plate";
};

/// Models with consistent mass and stiffness and no support. Nodes are numbered from 1 along z fastest, then y, then x,
/// so that the corner at the origin is node 1 and the far one the last (a rod's cross-section likewise). Node sets: the
/// faces "x_min", "x_max", "y_min", ... (a rod: "x_min", "x_max", "surface", and "axis" if `across` is even), and
/// "all". Throw SceneError for a size or division that is not positive, an unknown type, a material without E, ν or
/// density.
FiniteElementModel brick_mesh(const BrickMeshParameters& mesh);
FiniteElementModel rod_mesh(const RodMesh& mesh);
FiniteElementModel plate_mesh(const PlateMesh& mesh);

}  // namespace lithe
