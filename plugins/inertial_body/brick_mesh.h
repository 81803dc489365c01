#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "engine/plugin.h"

namespace lithe {

/// Isotropic St. Venant-Kirchhoff solid: S = λ tr(E) 1 + 2 μ E between Green-Lagrange strain and second Piola-Kirchhoff
/// stress; what CalculiX does with *ELASTIC under NLGEOM.
struct Solid {
  double young = 0;    // E, Pa
  double poisson = 0;  // ν
  double density = 0;  // kg/m³

  double lambda() const { return young * poisson / ((1 + poisson) * (1 - 2 * poisson)); }
  double mu() const { return young / (2 * (1 + poisson)); }
};

/// Which 8-node brick: with incompatible modes it bends without locking (C3D8I, SOLID45), without them it is C3D8.
enum class BrickType { incompatible_modes, plain };

/// A solid as a finite-element code describes it: nodes, 8-node bricks in CalculiX/Abaqus order, material. Mesh axes,
/// m.
struct BrickMesh {
  std::string name;                                   // where it came from, for messages
  std::vector<int> node_ids;                          // labels, by node index
  Matrix3X nodes;                                     // 3 x n
  std::vector<int> element_ids;                       // labels, by element
  std::vector<std::array<int, 8>> elements;           // node indices: bottom face, then top face, seen from above
  std::map<std::string, std::vector<int>> node_sets;  // node labels by set name, lower case
  BrickType type = BrickType::incompatible_modes;
  Solid material;

  int node_count() const { return static_cast<int>(nodes.cols()); }
  int element_count() const { return static_cast<int>(elements.size()); }
  /// Index of a node label; throws SceneError.
  int node_index(int id) const;
  /// Node labels of a set; throws SceneError listing the known sets.
  const std::vector<int>& node_set(const std::string& set) const;
};

/// Throws SceneError for what no solid is: no element, a node index out of range or used twice in an element, a node
/// that no element uses, E or density <= 0, ν outside (-1, 1/2), numbers that are not finite.
void require_sound(const BrickMesh& mesh);

/// Reads a CalculiX input deck (.inp): *NODE, *ELEMENT of type C3D8I or C3D8, *NSET (GENERATE, sets within sets) and
/// the first *ELASTIC and *DENSITY; everything else is skipped. Nodes that no element uses are left out. Throws
/// FileError naming file:line.
BrickMesh read_brick_mesh(const std::string& path);

/// A block of nx x ny x nz bricks between the origin and `size` (m). Node labels count from 1, fastest in x, then y,
/// then z. Sets: x0, x1, y0, y1, z0, z1 for its faces.
BrickMesh brick_block(const Vector3& size, const std::array<int, 3>& divisions, const Solid& material,
                      BrickType type = BrickType::incompatible_modes);

}  // namespace lithe
