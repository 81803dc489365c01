#include "joints/contact/polyhedron_internal.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "engine/base/error.h"

namespace lithe {
namespace polyhedron_parts {

double extent(std::span<const Vector3> points) {
  Vector3 low = points[0], high = points[0];
  for (const Vector3& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return (high - low).maxCoeff();
}

/// Edges, from the loops of a closed surface.
void add_edges(Polyhedron& body) {
  std::map<std::pair<int, int>, int> face_of;  // directed edge: face
  for (int f = 0; f + 1 < static_cast<int>(body.first.size()); ++f) {
    const auto loop = body.loop(f);
    for (std::size_t i = 0; i < loop.size(); ++i) face_of[{loop[i], loop[(i + 1) % loop.size()]}] = f;
  }
  for (const auto& [ends, face] : face_of) {
    const auto other = face_of.find({ends.second, ends.first});
    if (other != face_of.end() && ends.first < ends.second)
      body.edges.push_back({{ends.first, ends.second}, {face, other->second}});
  }
}

struct Triangle {
  std::array<int, 3> corners;
  Vector3 normal;
  double offset;
  bool alive = true;
};

/// Hull of points by adding one after the other, in triangles.
class TriangleHull {
 public:
  explicit TriangleHull(std::span<const Vector3> points) : points_(points), size_(extent(points)) {
    start();
    for (int p = 0; p < static_cast<int>(points.size()); ++p) add(p);
    std::erase_if(triangles, [](const Triangle& t) { return !t.alive; });
  }
  std::vector<Triangle> triangles;

 private:
  [[noreturn]] static void flat() {
    throw SceneError("the points of the convex hull enclose no volume", "", "give four points or more, not in a plane");
  }
  template <class Measure>
  int farthest(Measure&& measure) const {
    int best = 0;
    for (int p = 1; p < static_cast<int>(points_.size()); ++p)
      if (measure(points_[p]) > measure(points_[best])) best = p;
    return best;
  }
  void push(int a, int b, int c) {
    const Vector3 normal = (points_[b] - points_[a]).cross(points_[c] - points_[a]).normalized();
    triangles.push_back({{a, b, c}, normal, normal.dot(points_[a])});
  }
  void start() {
    if (points_.size() < 4) flat();
    const int a = farthest([&](const Vector3& p) { return -p[0]; });
    const int b = farthest([&](const Vector3& p) { return (p - points_[a]).squaredNorm(); });
    const Vector3 along = (points_[b] - points_[a]).normalized();
    int c = farthest([&](const Vector3& p) { return (p - points_[a]).cross(along).squaredNorm(); });
    const Vector3 across = along.cross(points_[c] - points_[a]);
    if (!(across.norm() > 1e-9 * size_)) flat();
    const Vector3 normal = across.normalized();
    const int d = farthest([&](const Vector3& p) { return std::abs(normal.dot(p - points_[a])); });
    const double height = normal.dot(points_[d] - points_[a]);
    if (!(std::abs(height) > 1e-9 * size_)) flat();
    int e = b;
    if (height > 0) std::swap(e, c);  // the fourth corner is below the first face
    push(a, e, c), push(a, d, e), push(e, d, c), push(c, d, a);
  }
  void add(int p) {
    std::map<std::pair<int, int>, bool> rim;  // directed edges of the faces that p sees
    for (Triangle& t : triangles) {
      if (!t.alive || !(t.normal.dot(points_[p]) - t.offset > 1e-11 * size_)) continue;
      t.alive = false;
      for (int i = 0; i < 3; ++i) rim[{t.corners[i], t.corners[(i + 1) % 3]}] = true;
    }
    for (const auto& [edge, seen] : rim)
      if (!rim.contains({edge.second, edge.first})) push(edge.first, edge.second, p);
  }

  std::span<const Vector3> points_;
  double size_;
};

/// Face of each triangle: neighbours in one plane share it.
std::vector<int> flat_groups(const std::vector<Triangle>& triangles, std::span<const Vector3> points, double size) {
  std::map<std::pair<int, int>, int> owner;
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
    for (int i = 0; i < 3; ++i) owner[{triangles[t].corners[i], triangles[t].corners[(i + 1) % 3]}] = t;
  std::vector<int> group(triangles.size());
  std::iota(group.begin(), group.end(), 0);
  const auto area = [&](const Triangle& t) {
    return (points[t.corners[1]] - points[t.corners[0]]).cross(points[t.corners[2]] - points[t.corners[0]]).norm();
  };
  // Large triangles first: a face is as its largest one.
  std::vector<int> order = group;
  std::ranges::stable_sort(order, [&](int a, int b) { return area(triangles[a]) > area(triangles[b]); });
  std::vector<bool> placed(triangles.size(), false);
  for (int seed : order) {
    if (placed[seed]) continue;
    std::vector<int> front{seed};
    placed[seed] = true;
    while (!front.empty()) {
      const Triangle& t = triangles[front.back()];
      front.pop_back();
      for (int i = 0; i < 3; ++i) {
        const int next = owner.at({t.corners[(i + 1) % 3], t.corners[i]});
        const auto in_plane = [&](int c) {
          return std::abs(triangles[seed].normal.dot(points[c]) - triangles[seed].offset) < 1e-9 * size;
        };
        if (placed[next] || !std::ranges::all_of(triangles[next].corners, in_plane)) continue;
        placed[next] = true, group[next] = seed;
        front.push_back(next);
      }
    }
  }
  return group;
}

}  // namespace polyhedron_parts

Polyhedron hull_polyhedron(std::span<const Vector3> points) {
  if (points.size() < 4)
    throw SceneError("the points of the convex hull enclose no volume", "", "give four points or more, not in a plane");
  const auto triangles = polyhedron_parts::TriangleHull(points).triangles;
  const double size = polyhedron_parts::extent(points);
  const auto group = polyhedron_parts::flat_groups(triangles, points, size);

  // The boundary of each face.
  std::map<int, std::map<int, int>> next;  // face: corner: next corner
  std::map<std::pair<int, int>, int> face_of;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int i = 0; i < 3; ++i) face_of[{triangles[t].corners[i], triangles[t].corners[(i + 1) % 3]}] = group[t];
  for (const auto& [edge, face] : face_of)
    if (face_of.at({edge.second, edge.first}) != face) next[face][edge.first] = edge.second;
  std::vector<std::vector<int>> loops;
  std::map<int, int> faces_at;
  for (const auto& [face, step] : next) {
    std::vector<int>& loop = loops.emplace_back();
    int c = step.begin()->first;
    do loop.push_back(c), ++faces_at[c], c = step.at(c);
    while (c != loop.front() && loop.size() <= step.size());
  }

  // Points amid an edge are no corners.
  Polyhedron body;
  body.size = size;
  std::map<int, int> number;
  for (const auto& [point, count] : faces_at)
    if (count >= 3) number[point] = static_cast<int>(body.corners.size()), body.corners.push_back(points[point]);
  body.first = {0};
  for (const auto& loop : loops) {
    Vector3 area = Vector3::Zero();  // Newell's sum, about a corner of the face
    for (std::size_t i = 0; i < loop.size(); ++i)
      area += (points[loop[i]] - points[loop[0]]).cross(points[loop[(i + 1) % loop.size()]] - points[loop[0]]);
    body.normals.push_back(area.normalized());
    for (int c : loop)
      if (number.contains(c)) body.loops.push_back(number[c]);
    body.first.push_back(static_cast<int>(body.loops.size()));
  }
  polyhedron_parts::add_edges(body);
  return body;
}

Polyhedron box_polyhedron(const Vector3& half_edges) {
  Polyhedron box;
  for (int i = 0; i < 8; ++i)
    box.corners.push_back(half_edges.cwiseProduct(Vector3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  box.first = {0};
  for (int axis = 0; axis < 3; ++axis)
    for (int side : {-1, 1}) {
      box.normals.push_back(side * Vector3::Unit(axis));
      const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, base = side > 0 ? 1 << axis : 0;
      if (side > 0)
        box.loops.insert(box.loops.end(), {base, base + u, base + u + v, base + v});
      else
        box.loops.insert(box.loops.end(), {base, base + v, base + u + v, base + u});
      box.first.push_back(static_cast<int>(box.loops.size()));
    }
  box.size = 2 * half_edges.maxCoeff();
  polyhedron_parts::add_edges(box);
  return box;
}

Polyhedron segment_polyhedron(double length) {
  Polyhedron segment;
  segment.corners = {Vector3(0, 0, -length / 2), Vector3(0, 0, length / 2)};
  segment.first = {0};
  segment.edges = {{{0, 1}}};
  segment.size = length;
  return segment;
}

Polyhedron point_polyhedron() {
  Polyhedron point;
  point.corners = {Vector3::Zero()};
  point.first = {0};
  return point;
}

void set_triangle(const Vector3& a, const Vector3& b, const Vector3& c, Polyhedron& triangle) {
  const Vector3 normal = (b - a).cross(c - a).normalized();
  triangle.corners.assign({a, b, c});
  triangle.normals.assign({normal, -normal});
  triangle.loops.assign({0, 1, 2, 0, 2, 1});
  triangle.first.assign({0, 3, 6});
  triangle.edges.assign({{{0, 1}, {0, 1}}, {{1, 2}, {0, 1}}, {{0, 2}, {0, 1}}});
  triangle.size = polyhedron_parts::extent(triangle.corners);
}

}  // namespace lithe
