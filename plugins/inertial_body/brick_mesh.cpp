#include "plugins/inertial_body/brick_mesh.h"

#include <algorithm>
#include <cmath>

namespace lithe {

int BrickMesh::node_index(int id) const {
  const auto at = std::find(node_ids.begin(), node_ids.end(), id);
  if (at == node_ids.end())
    throw SceneError("mesh has no node " + std::to_string(id), name,
                     node_ids.empty()
                         ? "give it nodes"
                         : "nodes are " + std::to_string(*std::min_element(node_ids.begin(), node_ids.end())) + " to " +
                               std::to_string(*std::max_element(node_ids.begin(), node_ids.end())));
  return static_cast<int>(at - node_ids.begin());
}

const std::vector<int>& BrickMesh::node_set(const std::string& set) const {
  const auto at = node_sets.find(set);
  if (at != node_sets.end()) return at->second;
  std::string known;
  for (const auto& [known_set, unused] : node_sets) known += (known.empty() ? "" : ", ") + known_set;
  throw SceneError("mesh has no node set '" + set + "'", name, known.empty() ? "it has none" : "known are " + known);
}

void require_sound(const BrickMesh& mesh) {
  const auto fail = [&](const std::string& what, const std::string& fix) { throw SceneError(what, mesh.name, fix); };
  const Solid& m = mesh.material;
  if (!(m.young > 0) || !std::isfinite(m.young))
    fail("Young's modulus is " + std::to_string(m.young), "give material.young > 0, in Pa");
  if (!(m.poisson > -1 && m.poisson < 0.5))
    fail("Poisson's ratio is " + std::to_string(m.poisson), "give -1 < material.poisson < 0.5");
  if (!(m.density > 0) || !std::isfinite(m.density))
    fail("density is " + std::to_string(m.density), "give material.density > 0, in kg/m3");
  if (mesh.elements.empty()) fail("mesh has no element", "give at least one 8-node brick");
  if (static_cast<int>(mesh.node_ids.size()) != mesh.node_count() ||
      static_cast<int>(mesh.element_ids.size()) != mesh.element_count())
    fail("labels do not match nodes or elements in number", "give one label a node and one an element");
  if (!mesh.nodes.allFinite()) fail("a node's position is not finite", "give numbers");
  std::vector<char> used(mesh.node_count(), 0);
  for (int e = 0; e < mesh.element_count(); ++e) {
    std::array<int, 8> nodes = mesh.elements[e];
    std::sort(nodes.begin(), nodes.end());
    const std::string element = "element " + std::to_string(mesh.element_ids[e]);
    if (nodes.front() < 0 || nodes.back() >= mesh.node_count())
      fail(element + " has a node that the mesh has not", "give node indices from 0");
    if (std::adjacent_find(nodes.begin(), nodes.end()) != nodes.end())
      fail(element + " has a node twice", "collapsed bricks are not supported: use eight different nodes");
    for (int i : nodes) used[i] = 1;
  }
  for (int i = 0; i < mesh.node_count(); ++i)
    if (!used[i]) fail("no element uses node " + std::to_string(mesh.node_ids[i]), "remove it: it would have no mass");
}

BrickMesh brick_block(const Vector3& size, const std::array<int, 3>& divisions, const Solid& material, BrickType type) {
  const auto [nx, ny, nz] = divisions;
  if (nx < 1 || ny < 1 || nz < 1 || !(size.minCoeff() > 0))
    throw SceneError("a block needs positive sizes and divisions", "brick_block", "give lengths > 0 and counts >= 1");
  BrickMesh mesh;
  mesh.name = "block";
  mesh.type = type;
  mesh.material = material;
  mesh.nodes.resize(3, (nx + 1) * (ny + 1) * (nz + 1));
  const auto index = [nx, ny](int i, int j, int k) { return i + (nx + 1) * (j + (ny + 1) * k); };
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) {
        const int n = index(i, j, k), id = n + 1;
        mesh.node_ids.push_back(id);
        mesh.nodes.col(n) << size[0] * i / nx, size[1] * j / ny, size[2] * k / nz;
        if (i == 0) mesh.node_sets["x0"].push_back(id);
        if (i == nx) mesh.node_sets["x1"].push_back(id);
        if (j == 0) mesh.node_sets["y0"].push_back(id);
        if (j == ny) mesh.node_sets["y1"].push_back(id);
        if (k == 0) mesh.node_sets["z0"].push_back(id);
        if (k == nz) mesh.node_sets["z1"].push_back(id);
      }
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        mesh.element_ids.push_back(mesh.element_count() + 1);
        mesh.elements.push_back({index(i, j, k), index(i + 1, j, k), index(i + 1, j + 1, k), index(i, j + 1, k),
                                 index(i, j, k + 1), index(i + 1, j, k + 1), index(i + 1, j + 1, k + 1),
                                 index(i, j + 1, k + 1)});
      }
  return mesh;
}

}  // namespace lithe
