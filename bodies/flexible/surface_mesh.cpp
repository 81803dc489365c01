#include "bodies/flexible/surface_mesh.h"

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>
#include <unordered_set>

#include "engine/base/error.h"

namespace lithe {
namespace surface_parts {

/// A kind of solid by its corners: faces as loops of corners, and the edges in the order of their middle nodes.
struct Solid {
  std::vector<std::vector<int>> faces;
  std::vector<std::array<int, 2>> edges;
};
const Solid kTetrahedron{{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}},
                         {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
const Solid kWedge{{{0, 2, 1}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}},
                   {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}}};
const Solid kBrick{{{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}},
                   {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};

const Solid* find_solid(const std::string& type, std::size_t nodes) {
  if (type.rfind("C3D", 0) != 0) return nullptr;
  if (nodes == 4 || nodes == 10) return &kTetrahedron;
  if (nodes == 6 || nodes == 15) return &kWedge;
  if (nodes == 8 || nodes == 20) return &kBrick;
  return nullptr;
}

struct Face {
  std::vector<int> corners, middles;  // node indices; no middles in the first order
  int elements = 0;                   // that have it
};

/// The face of an element by node indices, counter-clockwise seen from outside. Collapsed edges are left out.
Face face_of(const Solid& solid, const std::vector<int>& element, const std::vector<int>& loop, std::size_t corners) {
  Face face;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const int here = loop[i], next = loop[(i + 1) % loop.size()];
    if (element[here] == element[next]) continue;
    face.corners.push_back(element[here]);
    if (element.size() == corners) continue;
    const auto edge = std::find_if(solid.edges.begin(), solid.edges.end(), [&](const std::array<int, 2>& e) {
      return (e[0] == here && e[1] == next) || (e[0] == next && e[1] == here);
    });
    face.middles.push_back(element[corners + static_cast<std::size_t>(edge - solid.edges.begin())]);
  }
  return face;
}

void split(const Face& face, std::vector<std::array<int, 3>>& triangles) {
  std::vector<int> core = face.corners;
  if (!face.middles.empty()) {
    const std::size_t n = core.size();
    for (std::size_t i = 0; i < n; ++i)
      triangles.push_back({face.corners[i], face.middles[i], face.middles[(i + n - 1) % n]});
    core = face.middles;
  }
  for (std::size_t i = 2; i < core.size(); ++i) triangles.push_back({core[0], core[i - 1], core[i]});
}

/// Faces that one element alone has.
std::vector<Face> boundary_faces(const std::vector<ElementBlock>& elements, const Matrix3X& nodes) {
  std::map<std::vector<int>, std::size_t> number;  // of a face by its sorted corners
  std::vector<Face> faces;
  for (const ElementBlock& block : elements)
    for (const std::vector<int>& element : block.nodes) {
      if (element.size() == 2) continue;  // a line
      const auto* solid = find_solid(block.type, element.size());
      if (!solid)
        throw SceneError("the faces of an element of type '" + block.type + "' with " + std::to_string(element.size()) +
                             " nodes are not known",
                         "boundary_triangles",
                         "C3D4, 6, 8, 10, 15 and 20 are; give surface() triangles of node labels");
      const std::size_t corners = solid == &kTetrahedron ? 4 : solid == &kWedge ? 6 : 8;
      Vector3 center = Vector3::Zero();
      for (std::size_t i = 0; i < corners; ++i) center += nodes.col(element[i]) / static_cast<double>(corners);
      for (const auto& loop : solid->faces) {
        Face face = face_of(*solid, element, loop, corners);
        std::vector<int> key = face.corners;
        std::sort(key.begin(), key.end());
        if (std::unique(key.begin(), key.end()) - key.begin() < 3) continue;
        const auto [found, is_new] = number.try_emplace(std::move(key), faces.size());
        if (is_new) {
          // Outwards also where an element is numbered inside out.
          Vector3 normal = Vector3::Zero(), middle = Vector3::Zero();
          for (std::size_t i = 0; i < face.corners.size(); ++i) {
            const Vector3 here = nodes.col(face.corners[i]),
                          next = nodes.col(face.corners[(i + 1) % face.corners.size()]);
            normal += (here - center).cross(next - center);
            middle += here / static_cast<double>(face.corners.size());
          }
          if (normal.dot(middle - center) < 0) {
            std::reverse(face.corners.begin(), face.corners.end());
            if (!face.middles.empty()) std::reverse(face.middles.begin(), face.middles.end() - 1);
          }
          faces.push_back(std::move(face));
        }
        ++faces[found->second].elements;
      }
    }
  std::erase_if(faces, [](const Face& face) { return face.elements != 1; });
  return faces;
}

std::string place_of(const FlexibleBody& body) { return "'" + body.name() + "' of " + body.where(); }

std::vector<std::array<int, 3>> boundary(const FlexibleBody& body) {
  const ModalBasis& basis = body.basis();
  if (basis.elements.empty())
    throw SceneError("the basis '" + basis.name + "' has no elements, so that its surface is not known", place_of(body),
                     "read the model with its mesh, or give surface() triangles of node labels");
  return boundary_triangles(basis.elements, basis.nodes);
}

/// Triangles of node indices.
SurfaceMesh surface_of(FlexibleBody& body, const std::vector<std::array<int, 3>>& triangles) {
  if (triangles.empty())
    throw SceneError("no face of the body is in the surface", place_of(body), "name all nodes of the faces that are");
  const ModalBasis& basis = body.basis();
  SurfaceMesh mesh{.frame = body.body_frame()};
  std::unordered_map<int, int> place;
  for (const auto& triangle : triangles) {
    std::array<int, 3>& corners = mesh.triangles.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const int node = triangle[i];
      const auto [found, is_new] = place.try_emplace(node, static_cast<int>(mesh.nodes.size()));
      if (is_new) {
        mesh.nodes.push_back(body.node(basis.node_ids[static_cast<std::size_t>(node)]));
        mesh.points.push_back(basis.rotation * basis.nodes.col(node));
      }
      corners[i] = found->second;
    }
  }
  mesh.reach = body.candidate_reach();
  if (mesh.reach.size() == 0 && !basis.nodal && basis.modes.cols() > 0) {
    mesh.reach.resize(basis.modes.cols());
    for (Eigen::Index k = 0; k < mesh.reach.size(); ++k)
      mesh.reach[k] =
          Eigen::Map<const Matrix3X>(basis.modes.col(k).data(), 3, basis.nodes.cols()).colwise().norm().maxCoeff();
  }
  return mesh;
}

}  // namespace surface_parts

std::vector<std::array<int, 3>> boundary_triangles(const std::vector<ElementBlock>& elements, const Matrix3X& nodes) {
  std::vector<std::array<int, 3>> triangles;
  for (const auto& face : surface_parts::boundary_faces(elements, nodes)) surface_parts::split(face, triangles);
  return triangles;
}

std::vector<std::array<int, 2>> boundary_edges(const std::vector<ElementBlock>& elements, const Matrix3X& nodes) {
  std::set<std::array<int, 2>> edges;
  const auto add = [&](int a, int b) { edges.insert({std::min(a, b), std::max(a, b)}); };
  for (const auto& face : surface_parts::boundary_faces(elements, nodes))
    for (std::size_t i = 0; i < face.corners.size(); ++i) {
      const int here = face.corners[i], next = face.corners[(i + 1) % face.corners.size()];
      if (face.middles.empty()) {
        add(here, next);
      } else {
        add(here, face.middles[i]);
        add(face.middles[i], next);
      }
    }
  for (const ElementBlock& block : elements)
    for (const std::vector<int>& element : block.nodes)
      if (element.size() == 2) add(element[0], element[1]);
  return {edges.begin(), edges.end()};
}

SurfaceMesh surface(FlexibleBody& body) { return surface_parts::surface_of(body, surface_parts::boundary(body)); }

SurfaceMesh surface(FlexibleBody& body, const std::string& node_set) {
  return surface(body, body.basis().node_set(node_set));
}

SurfaceMesh surface(FlexibleBody& body, const std::vector<int>& node_ids) {
  std::unordered_set<int> wanted;
  for (int id : node_ids) wanted.insert(body.basis().node_index(id));
  std::vector<std::array<int, 3>> triangles = surface_parts::boundary(body);
  std::erase_if(triangles, [&](const std::array<int, 3>& t) {
    return !std::all_of(t.begin(), t.end(), [&](int node) { return wanted.count(node) > 0; });
  });
  return surface_parts::surface_of(body, triangles);
}

SurfaceMesh surface(FlexibleBody& body, const std::vector<std::array<int, 3>>& triangles) {
  std::vector<std::array<int, 3>> indices;
  for (const auto& t : triangles)
    indices.push_back({body.basis().node_index(t[0]), body.basis().node_index(t[1]), body.basis().node_index(t[2])});
  return surface_parts::surface_of(body, indices);
}

}  // namespace lithe
