#pragma once

#include <btBulletCollisionCommon.h>

#include <memory>
#include <vector>

#include "engine/model/contact_point.h"
#include "joints/contact/polyhedron_internal.h"
#include "joints/contact/shapes.h"

/// The shapes as Bullet knows them. For joints/contact alone.
namespace lithe {

struct Shape::Data {
  Kind kind;
  /// Of sphere (its centre), capsule (its axis), box, hull: convex->getUserPointer() is this.
  std::unique_ptr<Polyhedron> polyhedron;
  /// Convex kinds: with margin 0 (spheres and capsules: their radius).
  std::unique_ptr<btConvexShape> convex;
  /// Of mesh, height_field, surface: triangles in the axes of the marker, and Bullet's tree over them.
  std::vector<Vector3> points;
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<bool, 3>> open_edges;  // edge i -> i + 1 of a triangle: convex, a contact may lean over it
  std::unique_ptr<btStridingMeshInterface> mesh;
  std::unique_ptr<btConcaveShape> concave;
  /// Of compound.
  std::vector<std::pair<Placement, Shape>> parts;
  /// Of surface.
  std::vector<Marker> nodes;
  VectorX reach;
};

inline btVector3 to_bullet(const Vector3& x) { return {x[0], x[1], x[2]}; }
inline Vector3 from_bullet(const btVector3& x) { return {x.x(), x.y(), x.z()}; }
inline btTransform to_bullet(const Vector3& p, const Matrix3& R) {
  return btTransform(btMatrix3x3(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
                     to_bullet(p));
}

namespace narrow {

/// A point of a pair of surfaces: world axes, normal out of A towards B.
struct Touch {
  Vector3 position, normal;  // midway between the surfaces
  double gap;
  double curvature;
  std::uint64_t feature;  // among the points of this call
};

/// Points of two convex shapes with gap < reach, exact to what docs/contact.md states; appended. Polyhedra give the
/// corners of the patch in which they touch; the deepest point is always among them.
void convex_convex(const btConvexShape& a, const btTransform& at, const btConvexShape& b, const btTransform& bt,
                   double reach, std::vector<Touch>& touches);
/// A is the half space z <= 0 of its transform.
void plane_convex(const btTransform& plane, const btConvexShape& b, const btTransform& bt, double reach,
                  std::vector<Touch>& touches);
/// A triangle (world axes, counter-clockwise from outside: contact from that side) with a convex shape; leans over its
/// edges only where `open`, else the normal is the triangle's.
void triangle_convex(const Vector3 (&corners)[3], const std::array<bool, 3>& open, const btConvexShape& b,
                     const btTransform& bt, double reach, std::vector<Touch>& touches);

}  // namespace narrow
}  // namespace lithe
