#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/math.h"
#include "engine/model/marker.h"

namespace lithe {

/// A pose in the axes of another frame.
struct Placement {
  Vector3 position = Vector3::Zero();         // m
  Matrix3 orientation = Matrix3::Identity();  // own axes to the frame's
};

/// Geometry of a collider in the axes of its marker: made by the functions below, copied cheaply, never changed.
class Shape {
 public:
  enum class Kind { sphere, box, cylinder, capsule, cone, hull, half_space, mesh, height_field, surface, compound };
  struct Data;  // joints/contact/shape_internal.h
  Kind kind() const;
  const Data& data() const { return *data_; }
  explicit Shape(std::shared_ptr<const Data> data) : data_(std::move(data)) {}

 private:
  std::shared_ptr<const Data> data_;
};

/// Shapes to collide with. Sizes in m; each throws SceneError for a size that is not above zero, or not finite.
namespace shape {

Shape sphere(double radius);
/// Full edge lengths, centred.
Shape box(const Vector3& edges);
/// Along z, centred, of full length.
Shape cylinder(double radius, double length);
/// Along z, centred; `length` is that of the cylindrical part.
Shape capsule(double radius, double length);
/// Along z: base of `radius` at z = -length/2, tip at +length/2.
Shape cone(double radius, double length);
/// Convex hull of points. Throws SceneError if they enclose no volume.
Shape convex_hull(const std::vector<Vector3>& points);
/// All of z <= 0; contact from above.
Shape half_space();
/// Triangles, counter-clockwise seen from outside: contact from that side. Fixed in the marker's axes. Throws
/// SceneError for an index beyond the points, a triangle without area, no triangle.
Shape mesh(const std::vector<Vector3>& points, const std::vector<std::array<int, 3>>& triangles);
/// Heights above the marker's xy plane on a grid centred at its origin: heights(i, j) at x = (i - (nx - 1)/2)
/// spacing_x, y likewise. Contact from above.
Shape height_field(const MatrixX& heights, double spacing_x, double spacing_y);
/// Several shapes of one collider.
Shape compound(const std::vector<std::pair<Placement, Shape>>& parts);
/// Boundary of a deforming body: triangles, outside as of a mesh, between nodes that are markers of the body whose
/// frame is the collider's marker. `points`: the nodes in that frame, undeformed; `reach`: largest displacement of any
/// node by a unit of each linear coordinate of the body, or of each candidate mode, m (empty: not known, all nodes are
/// checked).
Shape surface(const std::vector<Marker>& nodes, const std::vector<Vector3>& points,
              const std::vector<std::array<int, 3>>& triangles, const VectorX& reach = {});

}  // namespace shape
}  // namespace lithe
