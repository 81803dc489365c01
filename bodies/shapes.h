#pragma once

#include <vector>

#include "bodies/rigid_body.h"

namespace lithe {

/// Mass properties of a solid of uniform density: for RigidBody::Parameters, and to place its centre.
///   const MassProperties m = box({1, 0.1, 0.1}, 500);   graph.add<RigidBody>("link", {.mass = m.mass, .inertia =
///   m.inertia});
struct MassProperties {
  double mass;      // kg
  Vector3 center;   // of mass, axes of the shape, m
  Inertia inertia;  // about the centre of mass, axes of the shape, kg m²
};

// Sizes in m, density in kg/m³. Each throws SceneError for a size or density that is not above zero.
/// Box with full edge lengths, centred.
MassProperties box(const Vector3& edges, double density);
/// Sphere, centred.
MassProperties sphere(double radius, double density);
/// Cylinder along z, centred; `length` is the full length.
MassProperties cylinder(double radius, double length, double density);
/// Capsule along z, centred; `length` is that of the cylindrical part.
MassProperties capsule(double radius, double length, double density);
/// Convex hull of points (Bullet's hull, exact integrals over its faces). Throws SceneError if they enclose no volume.
MassProperties convex_hull(const std::vector<Vector3>& points, double density);

}  // namespace lithe
