#include "bodies/shapes.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <LinearMath/btConvexHullComputer.h>

#include "engine/base/checks.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

Inertia inertia_of(const btCollisionShape& shape, double mass) {
  btVector3 moments;
  shape.calculateLocalInertia(mass, moments);
  return {moments.x(), moments.y(), moments.z()};
}

}  // namespace

MassProperties box(const Vector3& edges, double density) {
  for (double edge : edges) require::positive(edge, "an edge of the box");
  require::positive(density, "density");
  const double mass = density * edges.prod();
  return {mass, Vector3::Zero(), inertia_of(btBoxShape(btVector3(edges[0], edges[1], edges[2]) / 2), mass)};
}

MassProperties sphere(double radius, double density) {
  require::positive(radius, "radius");
  require::positive(density, "density");
  const double mass = density * 4.0 / 3 * M_PI * radius * radius * radius;
  return {mass, Vector3::Zero(), inertia_of(btSphereShape(radius), mass)};
}

MassProperties cylinder(double radius, double length, double density) {
  require::positive(radius, "radius");
  require::positive(length, "length");
  require::positive(density, "density");
  const double mass = density * M_PI * radius * radius * length;
  return {mass, Vector3::Zero(), inertia_of(btCylinderShapeZ(btVector3(radius, radius, length / 2)), mass)};
}

MassProperties capsule(double radius, double length, double density) {
  // Not Bullet's: it takes the inertia of the bounding box.
  const MassProperties rod = cylinder(radius, length, density), ball = sphere(radius, density);
  const double r = radius, l = length, m = ball.mass;
  const double axial = rod.inertia.matrix(2, 2) + 0.4 * m * r * r;
  // two half balls, each 3/8 r beyond the cylinder's end
  const double across = rod.inertia.matrix(0, 0) + m * (0.4 * r * r + 0.25 * l * l + 0.375 * l * r);
  return {rod.mass + m, Vector3::Zero(), {across, across, axial}};
}

MassProperties convex_hull(const std::vector<Vector3>& points, double density) {
  require::positive(density, "density");
  for (const Vector3& p : points) require::finite(p, "a point of the hull");
  btConvexHullComputer hull;
  if (points.size() >= 4) hull.compute(points[0].data(), sizeof(Vector3), static_cast<int>(points.size()), 0, 0);
  // Tetrahedra from the origin over a fan of each face: volume, first and second moments.
  double volume = 0;
  Vector3 first = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();
  const auto vertex = [&](int i) { return Vector3(hull.vertices[i].x(), hull.vertices[i].y(), hull.vertices[i].z()); };
  for (int f = 0; f < hull.faces.size(); ++f) {
    const btConvexHullComputer::Edge* start = &hull.edges[hull.faces[f]];
    const Vector3 a = vertex(start->getSourceVertex());
    for (const auto* edge = start->getNextEdgeOfFace(); edge->getTargetVertex() != start->getSourceVertex();
         edge = edge->getNextEdgeOfFace()) {
      const Vector3 b = vertex(edge->getSourceVertex()), c = vertex(edge->getTargetVertex());
      const double v = a.dot(b.cross(c)) / 6;
      const Vector3 sum = a + b + c;
      volume += v;
      first += v / 4 * sum;
      second += v / 20 * (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
    }
  }
  if (volume < 0) volume = -volume, first = -first, second = -second;  // faces listed clockwise
  double reach = 0;
  for (const Vector3& p : points) reach = std::max(reach, p.norm());
  if (!(volume > 1e-12 * reach * reach * reach))
    throw SceneError("the points of the hull enclose no volume", "",
                     "give at least four points that do not lie in one plane");
  const Vector3 center = first / volume;
  const Matrix3 about = second - volume * center * center.transpose();
  const Matrix3 J = density * (about.trace() * Matrix3::Identity() - about);
  return {density * volume, center, Matrix3(0.5 * (J + J.transpose()))};
}

}  // namespace lithe
