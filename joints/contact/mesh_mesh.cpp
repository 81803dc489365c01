#include <algorithm>

#include "joints/contact/triangle_patch_internal.h"
#include "joints/contact/triangles_internal.h"

namespace lithe::narrow {

void mesh_mesh(const Shape::Data& a, const btTransform& at, const Shape::Data& b, const btTransform& bt, double reach,
               std::vector<Touch>& touches) {
  struct Scratch {
    TrianglePatch a, b;
    std::vector<int> found;
    std::vector<PatchTouch> corners;
    std::vector<EdgeTouch> crossings;
  };
  thread_local Scratch work;
  const double depth = std::min(push_depth(a), push_depth(b));
  const Vector3 margin = Vector3::Constant(std::max(reach, depth));
  // Triangles within the bounds of the other mesh.
  const auto fill = [&](const Shape::Data& mesh, const btTransform& its, const Shape::Data& other,
                        const btTransform& others, TrianglePatch& patch) {
    btVector3 low, high;
    other.concave->getAabb(its.inverseTimes(others), low, high);
    find_triangles(mesh, from_bullet(low) - margin, from_bullet(high) + margin, work.found);
    patch.clear();
    fill_patch(mesh, its, work.found, patch);
    return !work.found.empty();
  };
  if (!fill(a, at, b, bt, work.a) || !fill(b, bt, a, at, work.b)) return;

  const std::size_t start = touches.size();
  const auto add = [&](const Touch& touch) {
    // Corners over corners, or on edges, are found both ways.
    const double same = triangle_parts::kRound * (work.a.triangles[0].size + work.b.triangles[0].size);
    if (std::none_of(touches.begin() + static_cast<std::ptrdiff_t>(start), touches.end(), [&](const Touch& kept) {
          return (kept.position - touch.position).norm() < same && (kept.normal - touch.normal).norm() < 1e-5;
        }))
      touches.push_back(touch);
  };
  work.corners.clear();
  work.a.meet_corners_of(work.b, reach, depth, work.corners);
  for (const PatchTouch& corner : work.corners) add(corner.touch);
  work.corners.clear();
  work.b.meet_corners_of(work.a, reach, depth, work.corners);
  for (PatchTouch& corner : work.corners) {
    corner.touch.normal = -corner.touch.normal;
    corner.touch.feature = feature_name(7, corner.touch.feature, 0);
    add(corner.touch);
  }
  work.crossings.clear();
  work.a.meet_edges_of(work.b, reach, depth, work.crossings);
  for (const EdgeTouch& edge : work.crossings) add(edge.touch);
}

}  // namespace lithe::narrow
