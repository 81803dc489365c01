#include "bodies/flexible/elements/meshes.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "bodies/flexible/elements/solid_element.h"
#include "engine/base/checks.h"

namespace lithe {
namespace {

constexpr long kMostCells = 2'000'000;  // a slip of the pen must not fill the memory

// Nodes of a cell in half cells from its corner: corners, middles of the bottom, top and vertical edges.
constexpr int kCellNodes[20][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2},
                                   {0, 2, 2}, {1, 0, 0}, {2, 1, 0}, {1, 2, 0}, {0, 1, 0}, {1, 0, 2}, {2, 1, 2},
                                   {1, 2, 2}, {0, 1, 2}, {0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}};
// Six tetrahedra about the diagonal 0-6: their faces match those of the next cell.
constexpr int kSixTetrahedra[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                      {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
constexpr int kTetrahedronMiddles[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

using HalfCells = std::array<int, 3>;

/// Nodes of the elements of one cell, in half cells from the corner of the box.
std::vector<std::vector<HalfCells>> elements_of_cell(const std::string& type, const HalfCells& cell) {
  std::array<HalfCells, 20> at;
  for (size_t a = 0; a < 20; ++a)
    for (size_t k = 0; k < 3; ++k) at[a][k] = 2 * cell[k] + kCellNodes[a][k];
  const auto count = static_cast<size_t>(solid_node_count(type));
  if (count == 8 || count == 20) return {{at.begin(), at.begin() + static_cast<long>(count)}};
  std::vector<std::vector<HalfCells>> tetrahedra;
  for (const auto& corners : kSixTetrahedra) {
    std::vector<HalfCells> nodes;
    for (int corner : corners) nodes.push_back(at[static_cast<size_t>(corner)]);
    for (size_t e = 0; e < count - 4; ++e) {
      const HalfCells a = nodes[static_cast<size_t>(kTetrahedronMiddles[e][0])],
                      b = nodes[static_cast<size_t>(kTetrahedronMiddles[e][1])];
      nodes.push_back({(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2});
    }
    tetrahedra.push_back(std::move(nodes));
  }
  return tetrahedra;
}

/// A box of cells, each node put where `place` says (from its coordinates along the box, 0 to 1). Sets: the six faces.
FiniteElementModel structured(const std::string& name, const std::array<int, 3>& divisions, const std::string& type,
                              const Material& material, const std::function<Vector3(const Vector3&)>& place) {
  for (size_t k = 0; k < 3; ++k)
    if (divisions[k] < 1)
      throw SceneError("it has " + std::to_string(divisions[k]) + " cells along " + "xyz"[k] + ".",
                       "mesh '" + name + "'", "give one or more.");
  if (static_cast<double>(divisions[0]) * divisions[1] * divisions[2] > kMostCells)
    throw SceneError("it has more than two million cells.", "mesh '" + name + "'", "divide it less.");
  if (!is_solid_type(type))
    throw SceneError("no solid element type '" + type + "'.", "mesh '" + name + "'",
                     "known are C3D4, C3D8, C3D8I, C3D10, C3D20, C3D20R.");

  // Cells first: they tell which of the places in half cells are nodes.
  const HalfCells size{2 * divisions[0] + 1, 2 * divisions[1] + 1, 2 * divisions[2] + 1};
  const auto index = [&](const HalfCells& p) {
    return (static_cast<size_t>(p[0]) * static_cast<size_t>(size[1]) + static_cast<size_t>(p[1])) *
               static_cast<size_t>(size[2]) +
           static_cast<size_t>(p[2]);
  };
  std::vector<std::vector<HalfCells>> elements;
  std::vector<int> node_at(index(size), -1);
  for (int i = 0; i < divisions[0]; ++i)
    for (int j = 0; j < divisions[1]; ++j)
      for (int k = 0; k < divisions[2]; ++k)
        for (auto& nodes : elements_of_cell(type, {i, j, k})) {
          for (const HalfCells& p : nodes) node_at[index(p)] = 0;
          elements.push_back(std::move(nodes));
        }

  FiniteElementModel model;
  model.name = name;
  std::vector<Vector3> positions;
  for (int i = 0; i < size[0]; ++i)
    for (int j = 0; j < size[1]; ++j)
      for (int k = 0; k < size[2]; ++k) {
        const HalfCells p{i, j, k};
        if (node_at[index(p)] < 0) continue;
        node_at[index(p)] = static_cast<int>(positions.size());
        positions.push_back(place({i / (size[0] - 1.0), j / (size[1] - 1.0), k / (size[2] - 1.0)}));
        model.node_ids.push_back(static_cast<int>(positions.size()));
        model.node_sets["all"].push_back(model.node_ids.back());
        for (size_t axis = 0; axis < 3; ++axis) {
          if (p[axis] == 0) model.node_sets[std::string(1, "xyz"[axis]) + "_min"].push_back(model.node_ids.back());
          if (p[axis] == size[axis] - 1)
            model.node_sets[std::string(1, "xyz"[axis]) + "_max"].push_back(model.node_ids.back());
        }
      }
  model.nodes = Eigen::Map<const Matrix3X>(positions.front().data(), 3, static_cast<Eigen::Index>(positions.size()));

  ElementBlock block{type, {}, material};
  for (const auto& nodes : elements) {
    block.nodes.emplace_back();
    for (const HalfCells& p : nodes) block.nodes.back().push_back(node_at[index(p)]);
  }
  model.elements.push_back(std::move(block));
  assemble_matrices(model);
  return model;
}

void require_positive(const std::string& name, double value, const char* parameter) {
  require::at("mesh '" + name + "'", [&] { require::positive(value, parameter); });
}

}  // namespace

FiniteElementModel brick_mesh(const BrickMeshParameters& mesh) {
  for (int k = 0; k < 3; ++k) require_positive(mesh.name, mesh.size[k], "size");
  return structured(mesh.name, mesh.divisions, mesh.type, mesh.material,
                    [&](const Vector3& s) { return Vector3(s.cwiseProduct(mesh.size)); });
}

FiniteElementModel rod_mesh(const RodMesh& mesh) {
  require_positive(mesh.name, mesh.length, "length");
  require_positive(mesh.name, mesh.radius, "radius");
  if (mesh.across < 2)
    throw SceneError("it has " + std::to_string(mesh.across) + " cells across.", "mesh '" + mesh.name + "'",
                     "give two or more; four for a smooth rim.");
  // The square [-1, 1]² pressed into a disc: each family of lines becomes one of ellipses, the rim the circle.
  const auto place = [&](const Vector3& s) {
    const double y = 2 * s[1] - 1, z = 2 * s[2] - 1;
    return Vector3(s[0] * mesh.length, mesh.radius * y * std::sqrt(1 - z * z / 2),
                   mesh.radius * z * std::sqrt(1 - y * y / 2));
  };
  FiniteElementModel model =
      structured(mesh.name, {mesh.along, mesh.across, mesh.across}, mesh.type, mesh.material, place);
  std::vector<int> surface, axis;
  for (const char* face : {"y_min", "y_max", "z_min", "z_max"}) {
    const std::vector<int>& nodes = model.node_sets[face];
    surface.insert(surface.end(), nodes.begin(), nodes.end());
    model.node_sets.erase(face);
  }
  std::sort(surface.begin(), surface.end());
  surface.erase(std::unique(surface.begin(), surface.end()), surface.end());
  for (int i = 0; i < model.node_count(); ++i)
    if (model.nodes.col(i).tail<2>().norm() < 1e-9 * mesh.radius) axis.push_back(i + 1);
  model.node_sets["surface"] = std::move(surface);
  if (!axis.empty()) model.node_sets["axis"] = std::move(axis);
  return model;
}

FiniteElementModel plate_mesh(const PlateMesh& mesh) {
  require_positive(mesh.name, mesh.length, "length");
  require_positive(mesh.name, mesh.width, "width");
  require_positive(mesh.name, mesh.thickness, "thickness");
  return structured(
      mesh.name, {mesh.divisions[0], mesh.divisions[1], 1}, mesh.type, mesh.material,
      [&](const Vector3& s) { return Vector3(s[0] * mesh.length, s[1] * mesh.width, (s[2] - 0.5) * mesh.thickness); });
}

}  // namespace lithe
