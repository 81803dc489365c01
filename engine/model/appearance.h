#pragma once

#include <array>
#include <utility>
#include <vector>

#include "engine/model/body.h"
#include "engine/model/connector.h"

namespace lithe {

/// A shape to be drawn, in the axes of the frame that carries it. Made by the functions of namespace visual.
struct DrawnShape {
  enum class Kind { sphere, box, cylinder, capsule, cone, half_space, mesh };
  Kind kind = Kind::sphere;
  std::vector<double> size{};                   // m: sphere {radius}; box {x, y, z}; along z: {radius, length}
  std::vector<Vector3> points{};                // of a mesh, m
  std::vector<std::array<int, 3>> triangles{};  // of a mesh: places in `points`, counter-clockwise from outside
  Vector3 position = Vector3::Zero();           // m
  Matrix3 orientation = Matrix3::Identity();    // its axes to those that it is in

  /// The same, moved by a pose: visual::box({0.4, 0.02, 0.02}).at({0.2, 0, 0}).
  DrawnShape at(const Point& place, const Matrix3& turned = Matrix3::Identity()) const;
};

/// Shapes to be drawn on bodies (Run::draw). Sizes in m; each throws SceneError for one that is not above zero.
namespace visual {

DrawnShape sphere(double radius);
/// Full edge lengths, centred.
DrawnShape box(const Vector3& edges);
/// Along z, centred, of full length.
DrawnShape cylinder(double radius, double length);
/// Along z, centred; `length` is that of the cylindrical part.
DrawnShape capsule(double radius, double length);
/// Along z: base at z = -length/2, tip at +length/2.
DrawnShape cone(double radius, double length);
/// A round bar between two points.
DrawnShape rod(const Point& from, const Point& to, double radius);
/// Triangles, counter-clockwise seen from outside. Throws SceneError for an index beyond the points.
DrawnShape mesh(const std::vector<Vector3>& points, const std::vector<std::array<int, 3>>& triangles);

}  // namespace visual

/// The surface of a finite-element body, and how its coordinates move it. Matrices have the points in rows, x y z of
/// point after point, in the axes of the body's frame.
struct DrawnMesh {
  Matrix3X points;                              // undeformed, m; of a body without frame: mesh axes
  std::vector<int> nodes;                       // of the body, by index: what each point is
  std::vector<std::array<int, 3>> triangles{};  // counter-clockwise from outside
  std::vector<std::array<int, 2>> edges{};      // of the elements
  bool nodal = false;                           // the body tells where its points are: drawn_points()
  MatrixX modes{};        // displacement by a unit of each linear coordinate; no columns: it does not deform
  VectorX frequencies{};  // Hz, of each mode; empty: not known
  /// What products of coordinates add, a column for each pair k <= l at l (l + 1)/2 + k: u += Σ η_k η_l pair_kl.
  MatrixX pairs{};
  /// xx yy zz xy yz xz of point after point for a unit of each coordinate, Pa; empty: not known.
  MatrixX stress{};
};

/// A body that provides its own surface. Others are drawn by their contacts' shapes, by the shapes given to
/// Run::draw(), or by sticks between their markers.
class DrawableBody {
 public:
  virtual ~DrawableBody() = default;
  virtual DrawnMesh drawn_mesh(bool with_stress) const = 0;
  /// Where the points of the mesh are now, of a body whose mesh is nodal: in the axes of its frame, or of the world
  /// if it has none.
  virtual void drawn_points(const BodyState& /*state*/, const DrawnMesh& /*mesh*/, Matrix3X& /*points*/) const {}
  /// The nodes that a marker follows, by index, and how much each counts (sum 1); none: it stays in the frame.
  virtual std::vector<std::pair<int, double>> nodes_of_marker(int marker) const = 0;
};

/// A connector that has shapes at its markers, as a contact, or a line from marker to marker, as a rope.
class DrawableConnector {
 public:
  virtual ~DrawableConnector() = default;
  /// Shapes at marker number `marker`, in its axes; none where the body draws itself.
  virtual std::vector<DrawnShape> drawn_shapes(int marker) const = 0;
  /// The points of its line in world axes, m, always as many; none: it has no line.
  virtual void drawn_line(std::span<const MarkerView> /*markers*/, const AngleMemory&, Matrix3X& points) const {
    points.resize(3, 0);
  }
};

}  // namespace lithe
