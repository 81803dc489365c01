#pragma once

#include <array>
#include <string>
#include <vector>

#include "bodies/flexible/flexible_body.h"

namespace lithe {

/// The boundary of a flexible body, for what touches it (shape::surface takes these plain vectors):
///   const SurfaceMesh skin = surface(beam);
///   {skin.frame, shape::surface(skin.nodes, skin.points, skin.triangles, skin.reach)}
struct SurfaceMesh {
  std::vector<Marker> nodes;                  // of the boundary alone, once each
  std::vector<Vector3> points;                // where they are undeformed, in the axes of `frame`, m
  std::vector<std::array<int, 3>> triangles;  // places in `nodes`; counter-clockwise seen from outside
  VectorX reach;  // largest displacement of a node by a unit of each candidate mode (of each linear coordinate, if the
                  // body has one model only), m; empty for nodal coordinates
  Marker frame;   // origin of the body frame, axes of the mesh
};

/// Triangles between node indices around elements: of all faces that one element alone has. Solids of four to twenty
/// nodes (tetrahedra, wedges, bricks; CalculiX order), collapsed ones too; faces of the second order are split at the
/// middles of their edges, so that every node of the face is a corner. Throws SceneError for other types.
std::vector<std::array<int, 3>> boundary_triangles(const std::vector<ElementBlock>& elements, const Matrix3X& nodes);

/// The edges of those faces, once each; of the second order halved at their middles.
std::vector<std::array<int, 2>> boundary_edges(const std::vector<ElementBlock>& elements, const Matrix3X& nodes);

/// Adds a marker to the body for every node of the surface: a few hundred bytes and six numbers a mode each; they cost
/// no time where nothing asks for them. Stays valid for every fidelity, rigid too. Throws SceneError if the basis has
/// no elements, or nothing is left.
SurfaceMesh surface(FlexibleBody& body);
/// Of those faces all of whose corners are in a node set, or among nodes (labels).
SurfaceMesh surface(FlexibleBody& body, const std::string& node_set);
SurfaceMesh surface(FlexibleBody& body, const std::vector<int>& node_ids);
/// Of given triangles (node labels, counter-clockwise seen from outside), for bodies without elements.
SurfaceMesh surface(FlexibleBody& body, const std::vector<std::array<int, 3>>& triangles);

}  // namespace lithe
