#include <algorithm>
#include <limits>
#include <numeric>

#include "joints/contact/triangle_patch_internal.h"
#include "joints/contact/triangles_internal.h"

namespace lithe::narrow {
namespace surface_parts {

constexpr double kUnknown = std::numeric_limits<double>::infinity();

/// A deforming surface at one state: the nodes asked for, once each.
struct Nodes {
  const ContactPoses* poses = nullptr;
  const Shape::Data* data = nullptr;
  int collider = -1;
  std::vector<Vector3> x;              // by node
  std::vector<std::uint64_t> read_at;  // the call that read it
  std::vector<std::uint64_t> seen_at;
  std::uint64_t call = 0;
  TrianglePatch patch;
  std::vector<int> found;
  std::vector<int> nodes;        // of the patch
  std::vector<Vector3> normals;  // of those, not unit

  void begin(const ContactPoses& of, int number, const Shape::Data& surface) {
    poses = &of, data = &surface, collider = number, ++call;
    if (x.size() < surface.nodes.size())
      x.resize(surface.nodes.size()), read_at.resize(x.size()), seen_at.resize(x.size());
  }
  const Vector3& at(int node) {
    if (read_at[node] != call) {
      MarkerKinematics k;
      poses->node(collider, data->nodes[node].index, k);
      x[node] = k.p, read_at[node] = call;
    }
    return x[node];
  }
  /// No node has moved further from its place in the frame, m. Halves more, for displacements of second order.
  double spread() const {
    const auto eta = poses->deformation(collider);
    const VectorX& reach = data->reach;
    if (reach.size() == 0) return kUnknown;
    if (eta.empty()) return 0;
    double sum = 0;
    const bool each = reach.size() == static_cast<Eigen::Index>(eta.size());  // else some modes of these
    for (std::size_t i = 0; i < eta.size(); ++i)
      sum += std::abs(eta[i]) * (each ? reach[static_cast<Eigen::Index>(i)] : reach.maxCoeff());
    return 1.5 * sum;
  }
  double depth() const { return push_depth(*data); }
  void find_all() {
    found.resize(data->triangles.size());
    std::iota(found.begin(), found.end(), 0);
  }
  void find(const Vector3& low, const Vector3& high, double margin) {
    if (margin == kUnknown) return find_all();
    const Vector3 m = Vector3::Constant(margin);
    find_triangles(*data, low - m, high + m, found);
  }
  /// Triangles found that meet a box in world axes.
  void fill_patch(const Vector3& low, const Vector3& high, bool all_open) {
    patch.clear();
    for (int k : found) {
      const auto& t = data->triangles[k];
      const std::array<Vector3, 3> now{at(t[0]), at(t[1]), at(t[2])};
      if ((now[0].cwiseMin(now[1]).cwiseMin(now[2]).array() > high.array()).any() ||
          (now[0].cwiseMax(now[1]).cwiseMax(now[2]).array() < low.array()).any())
        continue;
      patch.add(t, all_open ? std::array<bool, 3>{true, true, true} : data->open_edges[k], now,
                {data->points[t[0]], data->points[t[1]], data->points[t[2]]});
    }
  }
  /// Nodes of the patch and their normals.
  void gather_nodes() {
    nodes.clear();
    normals.clear();
    for (const PatchTriangle& t : patch.triangles)
      for (int node : t.corners) {
        if (seen_at[node] != call) nodes.push_back(node), seen_at[node] = call;
      }
    std::sort(nodes.begin(), nodes.end());
    normals.assign(nodes.size(), Vector3::Zero());
    for (const PatchTriangle& t : patch.triangles)
      for (int node : t.corners)
        normals[std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin()] += t.normal;
  }
  ContactSide side(int node) const { return {collider, 1, {data->nodes[node].index, 0, 0}, {1, 0, 0}}; }
  ContactSide side(const PatchTouch& touch) const { return side(touch.triangle, touch.weights); }
  ContactSide side(int triangle, const Vector3& of_corners) const {
    ContactSide side{collider, 3, {}, {}};
    const Vector3 weights = of_corners.cwiseMax(0) / of_corners.cwiseMax(0).sum();
    for (int i = 0; i < 3; ++i) {
      side.nodes[i] = data->nodes[patch.triangles[triangle].corners[i]].index;
      side.weights[i] = weights[i];
    }
    return side;
  }
};

struct Scratch {
  Nodes surface, other;
  TrianglePatch mesh;
  std::vector<int> found;
  std::vector<PatchTouch> touches;
  std::vector<EdgeTouch> crossings;
};

/// Where a collider, or a part of it, is.
struct Pose {
  Vector3 p;
  Matrix3 R;
};

struct Meeting {
  const ContactPoses& poses;
  int surface_collider, other_collider;
  double reach;
  Scratch& work;
  std::vector<ContactPoint>& points;

  Pose frame() const {
    const MarkerKinematics& k = poses.collider(surface_collider);
    return {k.p, k.R};
  }

  /// The touch has its normal out of the surface.
  void add(const Touch& touch, const ContactSide& on_surface, const ContactSide& on_other) {
    const bool first = surface_collider < other_collider;
    const Vector3 normal = first ? touch.normal : Vector3(-touch.normal);
    points.push_back({first ? on_surface : on_other, first ? on_other : on_surface, touch.position, normal, touch.gap,
                      touch.curvature, touch.feature});
  }
  ContactSide fixed() const { return {other_collider, 0, {}, {}}; }

  void half_space(const Pose& plane) {
    Nodes& s = work.surface;
    const Pose f = frame();
    const Vector3 up = plane.R.col(2), local = f.R.transpose() * up;
    const double offset = up.dot(plane.p - f.p) + reach, spread = s.spread();
    if (spread == kUnknown) {
      s.find_all();
    } else {
      Vector3 low, high;
      if (!bounds_below(*s.data, local, offset + spread, low, high)) return;
      s.find(low, high, 0);
    }
    s.nodes.clear();
    for (int k : s.found)
      for (int node : s.data->triangles[k]) {
        if (s.seen_at[node] == s.call) continue;
        s.seen_at[node] = s.call;
        if (spread == kUnknown || local.dot(s.data->points[node]) <= offset + spread) s.nodes.push_back(node);
      }
    std::sort(s.nodes.begin(), s.nodes.end());
    for (int node : s.nodes) {
      const Vector3& x = s.at(node);
      const double gap = up.dot(x - plane.p);
      if (gap < reach) add({x - 0.5 * gap * up, -up, gap, 0, static_cast<std::uint64_t>(node)}, s.side(node), fixed());
    }
  }

  void convex(const btConvexShape& b, const Pose& pose) {
    Nodes& s = work.surface;
    const Pose f = frame();
    const btTransform bt = to_bullet(pose.p, pose.R);
    btVector3 low, high;
    b.getAabb(to_bullet(f.p, f.R).inverseTimes(bt), low, high);
    s.find(from_bullet(low), from_bullet(high), reach + s.spread());
    if (s.found.empty()) return;
    b.getAabb(bt, low, high);
    const Vector3 margin = Vector3::Constant(reach);
    const bool sphere = b.getShapeType() == SPHERE_SHAPE_PROXYTYPE;  // exact over every edge, however it is bent
    s.fill_patch(from_bullet(low) - margin, from_bullet(high) + margin, sphere);
    work.touches.clear();
    s.patch.meet_convex(b, bt, reach, TrianglePatch::Corners::all, work.touches);
    for (const PatchTouch& touch : work.touches) add(touch.touch, s.side(touch), fixed());
  }

  /// Nodes of one surface against triangles of the other; `on_patch` and `on_node` tell the sides.
  template <class OnPatch, class Add>
  void meet_nodes(Nodes& nodes, TrianglePatch& patch, const OnPatch& on_patch, const Add& add_touch) {
    const double depth = nodes.depth();
    for (std::size_t i = 0; i < nodes.nodes.size(); ++i) {
      const int node = nodes.nodes[i];
      work.touches.clear();
      patch.meet_ball(nodes.at(node), 0, reach, depth, static_cast<std::uint64_t>(node), work.touches);
      for (const PatchTouch& touch : work.touches)
        if (touch.touch.normal.dot(nodes.normals[i]) < 0.5 * nodes.normals[i].norm())
          add_touch(touch.touch, on_patch(touch), nodes.side(node));
    }
  }

  void mesh(const Shape::Data& data, const Pose& pose) {
    Nodes& s = work.surface;
    const Pose f = frame();
    const btTransform at = to_bullet(pose.p, pose.R), surface_in_mesh = at.inverseTimes(to_bullet(f.p, f.R));
    const double spread = s.spread();
    btVector3 low, high;
    // Triangles of the mesh near the whole surface, then nodes of the surface near those.
    if (spread == kUnknown) {
      s.find_all();
      bounds_now(at, low, high);
    } else {
      s.data->concave->getAabb(surface_in_mesh, low, high);
    }
    const Vector3 margin = Vector3::Constant(reach + (spread == kUnknown ? 0 : spread));
    find_triangles(data, from_bullet(low) - margin, from_bullet(high) + margin, work.found);
    if (work.found.empty()) return;
    Vector3 least = Vector3::Constant(kUnknown), most = -least, least_world = least, most_world = most;
    work.mesh.clear();
    for (int k : work.found) {
      const auto& t = data.triangles[k];
      const std::array<Vector3, 3> local{data.points[t[0]], data.points[t[1]], data.points[t[2]]};
      std::array<Vector3, 3> x;
      for (int i = 0; i < 3; ++i) {
        x[i] = pose.p + pose.R * local[i];
        const Vector3 in_frame = f.R.transpose() * (x[i] - f.p);
        least = least.cwiseMin(in_frame), most = most.cwiseMax(in_frame);
        least_world = least_world.cwiseMin(x[i]), most_world = most_world.cwiseMax(x[i]);
      }
      work.mesh.add(t, data.open_edges[k], x, local);
    }
    if (spread != kUnknown) s.find(least, most, std::max(reach, s.depth()) + spread);
    const double depth = s.depth();
    const Vector3 around = Vector3::Constant(std::max(reach, depth));
    s.fill_patch(least_world - around, most_world + around, false);
    s.gather_nodes();
    meet_nodes(
        s, work.mesh, [&](const PatchTouch&) { return fixed(); },
        [&](Touch touch, const ContactSide& of_mesh, const ContactSide& of_node) {
          touch.normal = -touch.normal;
          add(touch, of_node, of_mesh);
        });
    // Corners of the mesh that stand out.
    s.found.clear();  // corners seen
    for (const PatchTriangle& t : work.mesh.triangles)
      for (int i = 0; i < 3; ++i) {
        if ((!t.open[i] && !t.open[(i + 2) % 3]) ||
            std::find(s.found.begin(), s.found.end(), t.corners[i]) != s.found.end())
          continue;
        s.found.push_back(t.corners[i]);
        work.touches.clear();
        s.patch.meet_ball(t.x[i], 0, reach, depth, feature_name(8, static_cast<std::uint64_t>(t.corners[i]), 0),
                          work.touches);
        for (const PatchTouch& touch : work.touches)
          if (touch.touch.normal.dot(t.normal) < 0.5) add(touch.touch, s.side(touch), fixed());
      }
    work.crossings.clear();
    s.patch.meet_edges_of(work.mesh, reach, depth, work.crossings);
    for (const EdgeTouch& edge : work.crossings) add(edge.touch, s.side(edge.triangle, edge.weights), fixed());
  }

  /// Bounds of all nodes in the axes of a mesh.
  void bounds_now(const btTransform& mesh, btVector3& low, btVector3& high) {
    low.setValue(kUnknown, kUnknown, kUnknown);
    high = -low;
    for (int node = 0; node < static_cast<int>(work.surface.data->nodes.size()); ++node) {
      const btVector3 x = mesh.invXform(to_bullet(work.surface.at(node)));
      low.setMin(x), high.setMax(x);
    }
  }

  void surface(const Shape::Data& data) {
    Nodes &s = work.surface, &o = work.other;
    o.begin(poses, other_collider, data);
    const Pose f = frame();
    const MarkerKinematics& k = poses.collider(other_collider);
    const btTransform at = to_bullet(f.p, f.R), other_at = to_bullet(k.p, k.R);
    const double spread = s.spread() + o.spread();
    // Bounds of either in the other's axes, undeformed.
    btVector3 low, high;
    data.concave->getAabb(at.inverseTimes(other_at), low, high);
    s.find(from_bullet(low), from_bullet(high), reach + spread);
    if (s.found.empty()) return;
    s.data->concave->getAabb(other_at.inverseTimes(at), low, high);
    o.find(from_bullet(low), from_bullet(high), reach + spread);
    if (o.found.empty()) return;
    const Vector3 everywhere = Vector3::Constant(kUnknown);
    s.fill_patch(-everywhere, everywhere, false);
    // Once more, as deformed: what is near the other's patch.
    const auto bounds = [](const TrianglePatch& patch, double margin) {
      std::pair<Vector3, Vector3> box{Vector3::Constant(kUnknown), Vector3::Constant(-kUnknown)};
      for (const PatchTriangle& t : patch.triangles) box = {box.first.cwiseMin(t.low), box.second.cwiseMax(t.high)};
      box.first.array() -= margin, box.second.array() += margin;
      return box;
    };
    const auto near_s = bounds(s.patch, std::max(reach, o.depth()));
    o.fill_patch(near_s.first, near_s.second, false);
    const auto near_o = bounds(o.patch, std::max(reach, s.depth()));
    s.fill_patch(near_o.first, near_o.second, false);
    s.gather_nodes();
    o.gather_nodes();
    meet_nodes(
        o, s.patch, [&](const PatchTouch& touch) { return s.side(touch); },
        [&](Touch touch, const ContactSide& of_patch, const ContactSide& of_node) { add(touch, of_patch, of_node); });
    meet_nodes(
        s, o.patch, [&](const PatchTouch& touch) { return o.side(touch); },
        [&](Touch touch, const ContactSide& of_patch, const ContactSide& of_node) {
          touch.normal = -touch.normal;
          touch.feature = feature_name(7, touch.feature, 0);
          add(touch, of_node, of_patch);
        });
    work.crossings.clear();
    s.patch.meet_edges_of(o.patch, reach, std::min(s.depth(), o.depth()), work.crossings);
    for (const EdgeTouch& edge : work.crossings)
      add(edge.touch, s.side(edge.triangle, edge.weights), o.side(edge.other, edge.other_weights));
  }

  void meet(const Shape::Data& other, const Pose& pose) {
    switch (other.kind) {
      case Shape::Kind::half_space:
        return half_space(pose);
      case Shape::Kind::mesh:
      case Shape::Kind::height_field:
        return mesh(other, pose);
      case Shape::Kind::surface:
        return surface(other);
      default:
        return convex(*other.convex, pose);
    }
  }
};

}  // namespace surface_parts

void surface_contacts(const ContactPoses& poses, int surface_collider, const Shape::Data& surface, int other_collider,
                      const Shape::Data& other, double reach, std::vector<ContactPoint>& points) {
  thread_local surface_parts::Scratch work;
  work.surface.begin(poses, surface_collider, surface);
  const MarkerKinematics& k = poses.collider(other_collider);
  surface_parts::Meeting{poses, surface_collider, other_collider, reach, work, points}.meet(other, {k.p, k.R});
}

}  // namespace lithe::narrow
