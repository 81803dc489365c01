#include <algorithm>

#include "engine/forward/in_plane.h"
#include "engine/simplify/rows_in_plane.h"
#include "engine/simplify/simplification_internal.h"

namespace lithe {
namespace {

constexpr double kInPlane = 1e-9;  // m and rad

/// A world axis where it is one but for round-off: then components of no use are zero, not nearly so.
Vector3 exact(const Vector3& axis) {
  for (int i = 0; i < 3; ++i)
    if (are_parallel(Vector3::Unit(i), axis)) return Vector3::Unit(i);
  return axis.normalized();
}

Matrix3 axes_about(const Vector3& n) {
  int smallest = 0;
  n.cwiseAbs().minCoeff(&smallest);
  const bool along = n.cwiseAbs().maxCoeff() == 1;
  int k = 0;
  n.cwiseAbs().maxCoeff(&k);
  Matrix3 axes;
  axes.col(0) = along ? Vector3(Vector3::Unit((k + 1) % 3)) : n.cross(Vector3::Unit(smallest)).normalized();
  axes.col(1) = n.cross(axes.col(0));
  axes.col(2) = n;
  return axes;
}

/// Assembly has moved it within the plane alone.
bool moved_in_plane(const FramePose& drawn, const FramePose& start, const Vector3& n) {
  const Matrix3 turn = drawn.axes * start.axes.transpose();
  return std::abs(n.dot(drawn.position - start.position)) < kInPlane && (turn * n - n).norm() < kInPlane;
}

}  // namespace

void Simplifier::find_planes() {
  const int n = static_cast<int>(items_.size());
  Topology all{n, {}};
  bool tree = false;
  const std::vector<LowerPair> joints = lower_pairs(all, tree);
  // Friction feels forces out of the plane: its island stays in space.
  const std::vector<int> island = islands(all);
  std::vector<char> pressed(n, 0);
  for (const Tie& c : whole_.constraints())
    if (consumers_.contains(c.constraint))
      for (const Marker& m : c.markers)
        if (item_of(m) != kGround) pressed[island[item_of(m)]] = 1;
  for (const Vector3& normal : normals(joints)) {
    const std::vector<char> held = held_in_plane(joints, normal);
    for (int i = 0; i < n; ++i) {
      Item& item = items_[i];
      if (!held[i] || item.plane >= 0 || pressed[island[i]] || !moved_in_plane(item.drawn, item.start, normal))
        continue;
      if (planes_.empty() || planes_.back().col(2) != normal) planes_.push_back(axes_about(normal));
      item.plane = static_cast<int>(planes_.size()) - 1;
    }
  }
  if (tree) keep_forward_method();
  std::vector<std::string> names;
  for (const Item& item : items_)
    if (item.plane >= 0) names.push_back(name(item));
  if (names.empty()) return;
  say(quoted(names) + (names.size() > 1 ? " move in planes" : " moves in a plane") + ": three coordinates each.");
  made_.smaller_ = true;
}

/// Those of rigid items, and what all constraints tie. `tree`: there is nothing else, and no loop.
std::vector<Simplifier::LowerPair> Simplifier::lower_pairs(Topology& all, bool& tree) {
  std::vector<LowerPair> joints;
  tree = consumers_.empty();
  for (const Tie& c : whole_.constraints()) {
    if (is_within(c.markers)) continue;
    std::vector<int> tie;
    for (const Marker& m : c.markers) tie.push_back(item_of(m));
    std::sort(tie.begin(), tie.end());
    tie.erase(std::unique(tie.begin(), tie.end()), tie.end());
    const bool rigid = std::all_of(tie.begin(), tie.end(), [&](int i) { return i == kGround || items_[i].rigid; });
    all.ties.push_back(std::move(tie));
    if (const auto freedom = c.constraint->freedom(); freedom && c.markers.size() == 2 && rigid)
      joints.push_back({item_of(c.markers[0]), item_of(c.markers[1]), *freedom, pose(c.markers[0]).axes});
    else
      tree = false;
  }
  tree = tree && !has_loops(all);
  return joints;
}

/// Of planes to try: along the hinges, then across the sliders.
std::vector<Vector3> Simplifier::normals(const std::vector<LowerPair>& joints) const {
  std::vector<Vector3> all;
  const auto add = [&](const Vector3& axis) {
    if (std::none_of(all.begin(), all.end(), [&](const Vector3& n) { return are_parallel(n, axis); }))
      all.push_back(exact(axis));
  };
  for (const LowerPair& j : joints)
    if (j.freedom.rotation == JointFreedom::Rotation::about_z) add(j.axes.col(2));
  for (const LowerPair& j : joints)
    if (j.freedom.rotation == JointFreedom::Rotation::none) add(j.axes.col(0));
  return all;
}

/// Items that joints keep in planes with this normal, from ground outwards.
std::vector<char> Simplifier::held_in_plane(const std::vector<LowerPair>& joints, const Vector3& normal) const {
  const int ground = static_cast<int>(items_.size());
  std::vector<std::pair<int, int>> holds;
  for (const LowerPair& j : joints)
    if (holds_in_plane(j.freedom, j.axes, normal))
      holds.emplace_back(j.a == kGround ? ground : j.a, j.b == kGround ? ground : j.b);
  std::vector<char> held(items_.size() + 1, 0);
  held[ground] = 1;
  return reached_over(holds, std::move(held));
}

/// Explicit integrators solve a tree without constraints if it is all in space, or all in one plane.
void Simplifier::keep_forward_method() {
  const bool one_plane = planes_.size() == 1 && planes_[0].col(2).maxCoeff() == 1;
  if (one_plane && std::all_of(items_.begin(), items_.end(), [](const Item& i) { return i.plane == 0; })) return;
  for (Item& item : items_) item.plane = -1;
}

/// All, unless every body that the constraint ties moves in a plane.
std::vector<int> Simplifier::rows_that_act(const Tie& c) {
  std::vector<MarkerInPlane> markers;
  bool in_plane = c.markers.size() <= kMaxMarkers;
  for (const Marker& m : c.markers) {
    const int i = item_of(m);
    in_plane &= i == kGround || items_[i].plane >= 0;
    if (!in_plane) break;
    markers.push_back({pose(m), i, {}, {}, Matrix3::Identity()});
    if (i == kGround) continue;
    const Item& item = items_[i];
    markers.back().center = item.start.position;
    markers.back().inertia = {item.inertia.mass, item.start.axes * item.inertia.inertia * item.start.axes.transpose()};
    markers.back().plane = planes_[item.plane];
  }
  if (in_plane) return rows_in_plane(*c.constraint, markers);
  std::vector<int> all(c.constraint->row_count());
  for (std::size_t r = 0; r < all.size(); ++r) all[r] = static_cast<int>(r);
  return all;
}

}  // namespace lithe
