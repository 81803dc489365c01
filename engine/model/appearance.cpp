#include "engine/model/appearance.h"

#include "engine/base/checks.h"
#include "engine/base/rotations.h"

namespace lithe {

DrawnShape DrawnShape::at(const Point& place, const Matrix3& turned) const {
  require::finite(place.at, "position of a drawn shape");
  require::rotation(turned, "orientation of a drawn shape");
  DrawnShape moved = *this;
  moved.position = place.at + turned * position;
  moved.orientation = turned * orientation;
  return moved;
}

namespace visual {
namespace {

DrawnShape round_shape(DrawnShape::Kind kind, const char* name, double radius, double length) {
  require::positive(radius, std::string("radius of the ") + name);
  require::positive(length, std::string("length of the ") + name);
  return {.kind = kind, .size = {radius, length}};
}

}  // namespace

DrawnShape sphere(double radius) {
  require::positive(radius, "radius of the sphere");
  return {.kind = DrawnShape::Kind::sphere, .size = {radius}};
}

DrawnShape box(const Vector3& edges) {
  for (double edge : edges) require::positive(edge, "an edge of the box");
  return {.kind = DrawnShape::Kind::box, .size = {edges[0], edges[1], edges[2]}};
}

DrawnShape cylinder(double radius, double length) {
  return round_shape(DrawnShape::Kind::cylinder, "cylinder", radius, length);
}
DrawnShape capsule(double radius, double length) {
  return round_shape(DrawnShape::Kind::capsule, "capsule", radius, length);
}
DrawnShape cone(double radius, double length) { return round_shape(DrawnShape::Kind::cone, "cone", radius, length); }

DrawnShape rod(const Point& from, const Point& to, double radius) {
  const Vector3 along = to.at - from.at;
  require::positive(along.norm(), "distance of the rod's ends");
  const Matrix3 turned = axes_along(along);
  return cylinder(radius, along.norm()).at(Vector3((from.at + to.at) / 2), turned);
}

DrawnShape mesh(const std::vector<Vector3>& points, const std::vector<std::array<int, 3>>& triangles) {
  for (const Vector3& point : points) require::finite(point, "a point of the drawn mesh");
  for (const auto& triangle : triangles)
    for (int corner : triangle)
      if (corner < 0 || corner >= static_cast<int>(points.size()))
        throw SceneError(
            "a triangle has point " + std::to_string(corner) + "; there are " + std::to_string(points.size()), "",
            "number points from 0");
  return {.kind = DrawnShape::Kind::mesh, .points = points, .triangles = triangles};
}

}  // namespace visual
}  // namespace lithe
