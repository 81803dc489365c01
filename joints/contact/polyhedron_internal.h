#pragma once

#include <array>
#include <span>
#include <vector>

#include "engine/base/math.h"

namespace lithe {

/// What of a convex body with flat faces can touch: corners, edges, faces. A segment has no face, a point no edge; a
/// triangle two faces, one a side.
struct Polyhedron {
  struct Edge {
    std::array<int, 2> ends;
    std::array<int, 2> faces{-1, -1};  // that it bounds; -1: none
  };
  std::vector<Vector3> corners;
  std::vector<Vector3> normals;  // of the faces, unit, outwards
  std::vector<int> loops;        // corners of face after face, counter-clockwise seen from outside
  std::vector<int> first;        // where a face begins in `loops`; one more: the end
  std::vector<Edge> edges;
  double size = 0;  // largest extent, m

  std::span<const int> loop(int face) const {
    return {loops.data() + first[face], static_cast<std::size_t>(first[face + 1] - first[face])};
  }
};

Polyhedron box_polyhedron(const Vector3& half_edges);
/// Along z.
Polyhedron segment_polyhedron(double length);
Polyhedron point_polyhedron();
void set_triangle(const Vector3& a, const Vector3& b, const Vector3& c, Polyhedron& triangle);
/// Convex hull; faces that are flat to 1e-9 of its size are one, points within 1e-11 of it are inside. Throws
/// SceneError if the points enclose no volume.
Polyhedron hull_polyhedron(std::span<const Vector3> points);

}  // namespace lithe
