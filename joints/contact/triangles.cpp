#include "joints/contact/triangles_internal.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "joints/contact/triangle_patch_internal.h"

namespace lithe::narrow {
namespace mesh_parts {

struct Scratch {
  TrianglePatch patch;
  std::vector<int> found;
  std::vector<PatchTouch> touches;
};
Scratch& scratch() {
  thread_local Scratch one;
  return one;
}

}  // namespace mesh_parts

void find_triangles(const Shape::Data& mesh, const Vector3& low, const Vector3& high, std::vector<int>& found) {
  struct Collect final : btTriangleCallback {
    std::vector<int>& found;
    explicit Collect(std::vector<int>& into) : found(into) {}
    void processTriangle(btVector3*, int /*part*/, int triangle) override { found.push_back(triangle); }
  };
  found.clear();
  Collect collect(found);
  mesh.concave->processAllTriangles(&collect, to_bullet(low), to_bullet(high));
  // Bullet's boxes are coarse ones.
  std::erase_if(found, [&](int k) {
    const auto& t = mesh.triangles[k];
    const auto &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
    return (a.cwiseMin(b).cwiseMin(c).array() > high.array()).any() ||
           (a.cwiseMax(b).cwiseMax(c).array() < low.array()).any();
  });
  std::sort(found.begin(), found.end());
}

void fill_patch(const Shape::Data& mesh, const btTransform& at, std::span<const int> numbers, TrianglePatch& patch) {
  for (int k : numbers) {
    const auto& t = mesh.triangles[k];
    const std::array<Vector3, 3> local{mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]};
    std::array<Vector3, 3> x;
    for (int i = 0; i < 3; ++i) x[i] = from_bullet(at * to_bullet(local[i]));
    patch.add(t, mesh.open_edges[k], x, local);
  }
}

double push_depth(const Shape::Data& surface) {
  btVector3 low, high;
  surface.concave->getAabb(btTransform::getIdentity(), low, high);
  const Vector3 extent = from_bullet(high - low);
  return std::max(0.5 * extent.minCoeff(), 0.01 * extent.maxCoeff());
}

bool bounds_below(const Shape::Data& mesh, const Vector3& normal, double offset, Vector3& low, Vector3& high) {
  btVector3 least, most;
  mesh.concave->getAabb(btTransform::getIdentity(), least, most);
  const Vector3 ends[2] = {from_bullet(least), from_bullet(most)};
  low.setConstant(std::numeric_limits<double>::infinity());
  high = -low;
  const auto corner = [&](int bits) { return Vector3(ends[bits & 1][0], ends[bits >> 1 & 1][1], ends[bits >> 2][2]); };
  const auto take = [&](const Vector3& x) { low = low.cwiseMin(x), high = high.cwiseMax(x); };
  for (int bits = 0; bits < 8; ++bits) {
    const Vector3 x = corner(bits);
    const double over = normal.dot(x) - offset;
    if (over <= 0) take(x);
    for (int axis = 0; axis < 3; ++axis) {  // where the plane cuts edges
      if (bits >> axis & 1) continue;
      const Vector3 y = corner(bits | 1 << axis);
      const double beyond = normal.dot(y) - offset;
      if ((over <= 0) != (beyond <= 0)) take(x + over / (over - beyond) * (y - x));
    }
  }
  return low[0] <= high[0];
}

void mesh_convex(const Shape::Data& mesh, const btTransform& at, const btConvexShape& b, const btTransform& bt,
                 double reach, std::vector<Touch>& touches) {
  auto& [patch, found, touching] = mesh_parts::scratch();
  btVector3 low, high;
  b.getAabb(at.inverseTimes(bt), low, high);
  const Vector3 margin = Vector3::Constant(reach);
  find_triangles(mesh, from_bullet(low) - margin, from_bullet(high) + margin, found);
  patch.clear();
  fill_patch(mesh, at, found, patch);
  touching.clear();
  patch.meet_convex(b, bt, reach, TrianglePatch::Corners::sharp, touching);
  for (const PatchTouch& touch : touching) touches.push_back(touch.touch);
}

void triangle_convex(const Vector3 (&corners)[3], const std::array<bool, 3>& open, const btConvexShape& b,
                     const btTransform& bt, double reach, std::vector<Touch>& touches) {
  auto& [patch, found, touching] = mesh_parts::scratch();
  const std::array<Vector3, 3> x{corners[0], corners[1], corners[2]};
  patch.clear();
  patch.add({0, 1, 2}, open, x, x);
  touching.clear();
  patch.meet_convex(b, bt, reach, TrianglePatch::Corners::sharp, touching);
  for (const PatchTouch& touch : touching) touches.push_back(touch.touch);
}

void mesh_plane(const btTransform& plane, const Shape::Data& mesh, const btTransform& at, double reach,
                std::vector<Touch>& touches) {
  auto& found = mesh_parts::scratch().found;
  const Vector3 normal = from_bullet(plane.getBasis().getColumn(2)), origin = from_bullet(plane.getOrigin());
  const Vector3 local = from_bullet(to_bullet(normal) * at.getBasis());
  const double offset = normal.dot(origin - from_bullet(at.getOrigin()));
  Vector3 low, high;
  if (!bounds_below(mesh, local, offset + reach, low, high)) return;
  find_triangles(mesh, low, high, found);
  for (int& k : found) k = -1 - k;  // then points, once each
  const std::size_t triangles = found.size();
  for (std::size_t i = 0; i < triangles; ++i)
    for (int corner : mesh.triangles[-1 - found[i]]) found.push_back(corner);
  found.erase(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(triangles));
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  for (int corner : found) {
    const Vector3 x = from_bullet(at * to_bullet(mesh.points[corner]));
    const double gap = normal.dot(x - origin);
    if (gap < reach)
      touches.push_back(
          {x - 0.5 * gap * normal, normal, gap, 0, feature_name(5, static_cast<std::uint64_t>(corner), 0)});
  }
}

}  // namespace lithe::narrow
