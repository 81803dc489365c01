#include "joints/contact/shapes.h"

#include <algorithm>
#include <map>

#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "joints/contact/shape_internal.h"

namespace lithe {

Shape::Kind Shape::kind() const { return data_->kind; }

namespace shape {
namespace shape_parts {

using Data = Shape::Data;
using Kind = Shape::Kind;

Shape convex(Kind kind, std::unique_ptr<btConvexShape> bullet, std::unique_ptr<Polyhedron> polyhedron = nullptr) {
  auto data = std::make_shared<Data>();
  data->kind = kind;
  if (kind != Kind::sphere && kind != Kind::capsule) bullet->setMargin(0);
  bullet->setUserPointer(polyhedron.get());
  data->polyhedron = std::move(polyhedron);
  data->convex = std::move(bullet);
  return Shape(std::move(data));
}

/// Fills `open_edges`: no neighbour there that rises above the triangle, or goes on in its plane to 1e-9 rad. Points at
/// one place are one.
void open_edges(Data& data) {
  std::map<std::array<double, 3>, int> number;
  std::vector<int> merged;
  for (const Vector3& p : data.points)
    merged.push_back(number.try_emplace({p[0], p[1], p[2]}, static_cast<int>(number.size())).first->second);
  const auto key = [&](const std::array<int, 3>& t, int i) {
    return std::minmax({merged[t[i]], merged[t[(i + 1) % 3]]});
  };
  std::map<std::pair<int, int>, std::vector<std::pair<int, int>>> at_edge;  // triangle and its edge there
  for (int t = 0; t < static_cast<int>(data.triangles.size()); ++t)
    for (int i = 0; i < 3; ++i) at_edge[key(data.triangles[t], i)].push_back({t, i});

  for (int t = 0; t < static_cast<int>(data.triangles.size()); ++t) {
    const auto& corners = data.triangles[t];
    const Vector3& a = data.points[corners[0]];
    const Vector3 normal = (data.points[corners[1]] - a).cross(data.points[corners[2]] - a).normalized();
    std::array<bool, 3>& open = data.open_edges.emplace_back();
    for (int i = 0; i < 3; ++i) {
      const Vector3& start = data.points[corners[i]];
      const Vector3 along = (data.points[corners[(i + 1) % 3]] - start).normalized();
      open[i] = std::ranges::all_of(at_edge[key(corners, i)], [&](const std::pair<int, int>& other) {
        if (other.first == t) return true;
        const Vector3 d = data.points[data.triangles[other.first][(other.second + 2) % 3]] - start;
        return normal.dot(d) < -1e-9 * along.cross(d).norm();
      });
    }
  }
}

void check(const std::vector<Vector3>& points, const std::vector<std::array<int, 3>>& triangles) {
  if (triangles.empty()) throw SceneError("the shape has no triangle", "", "give at least one");
  for (const Vector3& p : points) require::finite(p, "a point of the triangles");
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const std::string name = "triangle " + std::to_string(t);
    for (int c : triangles[t])
      if (c < 0 || c >= static_cast<int>(points.size()))
        throw SceneError(name + " has point " + std::to_string(c) + "; there are " + std::to_string(points.size()), "",
                         "number points from 0");
    const Vector3 u = points[triangles[t][1]] - points[triangles[t][0]];
    const Vector3 v = points[triangles[t][2]] - points[triangles[t][0]];
    const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (u - v).squaredNorm()});
    if (!(u.cross(v).norm() > 1e-12 * longest))
      throw SceneError(name + " has no area", "", "leave it out, or give it three corners that are not in line");
  }
}

std::shared_ptr<Data> of_triangles(Kind kind, const std::vector<Vector3>& points,
                                   const std::vector<std::array<int, 3>>& triangles) {
  check(points, triangles);
  auto data = std::make_shared<Data>();
  data->kind = kind;
  data->points = points;
  data->triangles = triangles;
  open_edges(*data);

  btIndexedMesh part;
  part.m_numTriangles = static_cast<int>(triangles.size());
  part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(data->triangles.data());
  part.m_triangleIndexStride = sizeof(std::array<int, 3>);
  part.m_numVertices = static_cast<int>(points.size());
  part.m_vertexBase = reinterpret_cast<const unsigned char*>(data->points.data());
  part.m_vertexStride = sizeof(Vector3);
  part.m_vertexType = PHY_DOUBLE;
  auto mesh = std::make_unique<btTriangleIndexVertexArray>();
  mesh->addIndexedMesh(part, PHY_INTEGER);
  data->mesh = std::move(mesh);
  data->concave = std::make_unique<btBvhTriangleMeshShape>(data->mesh.get(), /*useQuantizedAabbCompression=*/true);
  data->concave->setMargin(0);
  return data;
}

}  // namespace shape_parts
using shape_parts::convex, shape_parts::Kind, shape_parts::of_triangles;

Shape sphere(double radius) {
  require::positive(radius, "radius of the sphere");
  return convex(Kind::sphere, std::make_unique<btSphereShape>(radius),
                std::make_unique<Polyhedron>(point_polyhedron()));
}

Shape box(const Vector3& edges) {
  for (double edge : edges) require::positive(edge, "an edge of the box");
  return convex(Kind::box, std::make_unique<btBoxShape>(to_bullet(Vector3(edges / 2))),
                std::make_unique<Polyhedron>(box_polyhedron(edges / 2)));
}

Shape cylinder(double radius, double length) {
  require::positive(radius, "radius of the cylinder");
  require::positive(length, "length of the cylinder");
  return convex(Kind::cylinder, std::make_unique<btCylinderShapeZ>(btVector3(radius, radius, length / 2)));
}

Shape capsule(double radius, double length) {
  require::positive(radius, "radius of the capsule");
  require::positive(length, "length of the capsule");
  return convex(Kind::capsule, std::make_unique<btCapsuleShapeZ>(radius, length),
                std::make_unique<Polyhedron>(segment_polyhedron(length)));
}

Shape cone(double radius, double length) {
  require::positive(radius, "radius of the cone");
  require::positive(length, "length of the cone");
  return convex(Kind::cone, std::make_unique<btConeShapeZ>(radius, length));
}

Shape convex_hull(const std::vector<Vector3>& points) {
  for (const Vector3& p : points) require::finite(p, "a point of the hull");
  auto polyhedron = std::make_unique<Polyhedron>(hull_polyhedron(points));
  auto hull = std::make_unique<btConvexHullShape>();
  for (const Vector3& p : polyhedron->corners) hull->addPoint(to_bullet(p), false);
  hull->setMargin(0);
  hull->recalcLocalAabb();
  return convex(Kind::hull, std::move(hull), std::move(polyhedron));
}

Shape half_space() {
  auto data = std::make_shared<Shape::Data>();
  data->kind = Kind::half_space;
  return Shape(std::move(data));
}

Shape mesh(const std::vector<Vector3>& points, const std::vector<std::array<int, 3>>& triangles) {
  return Shape(of_triangles(Kind::mesh, points, triangles));
}

Shape height_field(const MatrixX& heights, double spacing_x, double spacing_y) {
  require::positive(spacing_x, "spacing of the height field along x");
  require::positive(spacing_y, "spacing of the height field along y");
  const int nx = static_cast<int>(heights.rows()), ny = static_cast<int>(heights.cols());
  if (nx < 2 || ny < 2)
    throw SceneError("the height field has " + std::to_string(nx) + " x " + std::to_string(ny) + " heights", "",
                     "give at least 2 x 2");
  std::vector<Vector3> points;
  std::vector<std::array<int, 3>> triangles;
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      points.emplace_back((i - (nx - 1) / 2.0) * spacing_x, (j - (ny - 1) / 2.0) * spacing_y, heights(i, j));
      if (i + 1 == nx || j + 1 == ny) continue;
      const int here = i * ny + j;
      triangles.push_back({here, here + ny, here + ny + 1});
      triangles.push_back({here, here + ny + 1, here + 1});
    }
  return Shape(of_triangles(Kind::height_field, points, triangles));
}

Shape compound(const std::vector<std::pair<Placement, Shape>>& parts) {
  if (parts.empty()) throw SceneError("the compound has no part", "", "give at least one");
  for (const auto& [placement, part] : parts) {
    require::finite(placement.position, "position of a part");
    require::rotation(placement.orientation, "orientation of a part");
    if (part.kind() == Kind::surface)
      throw SceneError("a deforming surface is part of a compound", "", "make it a collider of its own");
  }
  auto data = std::make_shared<Shape::Data>();
  data->kind = Kind::compound;
  data->parts = parts;
  return Shape(std::move(data));
}

Shape surface(const std::vector<Marker>& nodes, const std::vector<Vector3>& points,
              const std::vector<std::array<int, 3>>& triangles, const VectorX& reach) {
  if (nodes.size() != points.size())
    throw SceneError(
        "the surface has " + std::to_string(nodes.size()) + " nodes and " + std::to_string(points.size()) + " points",
        "", "give one point a node");
  for (const Marker& node : nodes)
    if (node.body == nullptr || node.body != nodes[0].body)
      throw SceneError("the nodes of the surface are not of one body", "", "take all markers from the same body");
  require::finite(reach, "reach of the surface");
  for (double r : reach) require::not_negative(r, "reach of the surface");
  auto data = of_triangles(Kind::surface, points, triangles);
  data->nodes = nodes;
  data->reach = reach;
  return Shape(std::move(data));
}

}  // namespace shape
}  // namespace lithe
