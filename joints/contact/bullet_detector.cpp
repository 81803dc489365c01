#include "joints/contact/bullet_detector.h"

#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include <algorithm>
#include <limits>

#include "engine/base/error.h"
#include "joints/contact/contact.h"
#include "joints/contact/triangle_patch_internal.h"
#include "joints/contact/triangles_internal.h"

namespace lithe {
namespace detector_parts {

using Kind = Shape::Kind;

/// A shape of a collider, or of a compound in one, and where it is at the state in hand.
struct Part {
  const Shape::Data* shape;
  Placement placement;
  bool placed;             // not in the axes of the marker itself
  btVector3 local_centre;  // of a ball around it, in its axes
  double radius;           // of that ball; negative: endless
  btTransform at{};        // its axes to the world's
  btVector3 centre{};
  double mesh_half = 0;  // of triangles: how deep others of triangles may be, each side's half of it, m

  const btCollisionShape* bullet() const {
    return shape->convex ? static_cast<const btCollisionShape*>(shape->convex.get()) : shape->concave.get();
  }
  bool triangles() const { return shape->kind == Kind::mesh || shape->kind == Kind::height_field; }
};

void flatten(const Shape::Data& shape, const Placement& placement, bool placed, std::vector<Part>& parts) {
  if (shape.kind == Kind::compound) {
    for (const auto& [inner, part] : shape.parts)
      flatten(part.data(),
              {placement.position + placement.orientation * inner.position, placement.orientation * inner.orientation},
              true, parts);
    return;
  }
  Part part{&shape, placement, placed, btVector3(0, 0, 0), -1};
  if (part.bullet() != nullptr && shape.kind != Kind::surface)
    part.bullet()->getBoundingSphere(part.local_centre, part.radius);
  if (shape.kind == Kind::sphere) part.radius = static_cast<const btSphereShape*>(part.bullet())->getRadius();
  parts.push_back(part);
}

/// Other poses, but for one collider, which is where a part of it is.
class PosesOfPart final : public ContactPoses {
 public:
  PosesOfPart(const ContactPoses& poses, int collider, const Placement& placement)
      : poses_(poses), collider_(collider), placed_(poses.collider(collider)) {
    const Vector3 arm = placed_.R * placement.position;
    placed_.p += arm;
    if (placed_.A != nullptr) placed_.r += placed_.A->transpose() * arm;
    placed_.R = placed_.R * placement.orientation;
  }
  const MarkerKinematics& collider(int c) const override { return c == collider_ ? placed_ : poses_.collider(c); }
  void node(int c, int marker, MarkerKinematics& out) const override { poses_.node(c, marker, out); }
  std::span<const double> deformation(int c) const override { return poses_.deformation(c); }

 private:
  const ContactPoses& poses_;
  int collider_;
  MarkerKinematics placed_;
};

/// Names a point among those of all parts of two compounds.
std::uint64_t mixed(std::uint64_t feature, std::uint64_t part_a, std::uint64_t part_b) {
  std::uint64_t x = feature + 0x9e3779b97f4a7c15u * (part_a << 32 | (part_b + 1));
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

double width(const Shape::Data& shape, const btVector3& direction) {
  const btVector3 far = shape.convex->localGetSupportingVertexWithoutMargin(direction),
                  near = shape.convex->localGetSupportingVertexWithoutMargin(-direction);
  return (far - near).dot(direction);
}

/// The least width: of a polyhedron between a face and the corner farthest from it, of round shapes along or across
/// their axis. Triangles of a deforming surface have what they enclose; of meshes see mesh_half.
double thickness(const Shape::Data& shape) {
  double least = std::numeric_limits<double>::infinity();
  switch (shape.kind) {
    case Kind::half_space:
      return least;
    case Kind::sphere:
      return 2 * static_cast<const btSphereShape*>(shape.convex.get())->getRadius();
    case Kind::capsule:
      return 2 * static_cast<const btCapsuleShape*>(shape.convex.get())->getRadius();
    case Kind::surface: {
      Vector3 low = shape.points.front(), high = low;
      for (const Vector3& p : shape.points) low = low.cwiseMin(p), high = high.cwiseMax(p);
      return (high - low).minCoeff();
    }
    default:
      break;
  }
  if (shape.polyhedron && !shape.polyhedron->normals.empty())
    for (const Vector3& normal : shape.polyhedron->normals) least = std::min(least, width(shape, to_bullet(normal)));
  else
    for (int axis = 0; axis < 3; ++axis) {
      btVector3 along(0, 0, 0);
      along[axis] = 1;
      least = std::min(least, width(shape, along));
    }
  return least;
}

struct Pair {
  int a, b;  // a < b
  auto operator<=>(const Pair&) const = default;
};

/// Pairs of colliders whose boxes meet, by Bullet's tree of boxes. Each box in the tree is larger than the collider's,
/// and only those that it has left are looked up again: the pairs are a superset that depends on history, the points do
/// not.
class BroadPhase {
 public:
  BroadPhase(const Contact& contact, std::vector<int> colliders) : contact_(contact), colliders_(std::move(colliders)) {
    leaves_.resize(contact.colliders().size(), nullptr);
    moved_.resize(leaves_.size(), false);
  }
  /// The collider's box, grown by its reach. `spare`: by how much that in the tree is larger.
  void place(int collider, const btDbvtVolume& box, double spare) {
    const btVector3 extents = box.Lengths();
    if (!(std::isfinite(extents.x()) && std::isfinite(extents.y()) && std::isfinite(extents.z()))) return;
    btDbvtNode*& leaf = leaves_[collider];
    if (leaf != nullptr && leaf->volume.Contain(box)) return;
    btDbvtVolume wide = box;
    wide.Expand(btVector3(spare, spare, spare));
    if (leaf != nullptr)
      tree_.update(leaf, wide);
    else
      leaf = tree_.insert(wide, nullptr), leaf->dataAsInt = collider;
    moved_[collider] = true, changed_ = true;
  }
  const std::vector<int>& colliders() const { return colliders_; }
  /// In order.
  const std::vector<Pair>& pairs() {
    if (!changed_) return pairs_;
    added_.clear();
    for (int c : colliders_) {
      if (!moved_[c]) continue;
      Found found(*this, c);
      tree_.collideTVNoStackAlloc(tree_.m_root, leaves_[c]->volume, stack_, found);
    }
    std::ranges::sort(added_);
    merged_.clear();
    auto next = added_.begin();
    for (const Pair& old : pairs_) {
      if (moved_[old.a] || moved_[old.b]) continue;
      while (next != added_.end() && *next < old) merged_.push_back(*next++);
      merged_.push_back(old);
    }
    merged_.insert(merged_.end(), next, added_.end());
    pairs_.swap(merged_);
    std::ranges::fill(moved_, false);
    changed_ = false;
    return pairs_;
  }

 private:
  struct Found final : btDbvt::ICollide {
    BroadPhase& phase;
    int collider;
    Found(BroadPhase& p, int c) : phase(p), collider(c) {}
    void Process(const btDbvtNode* leaf) override {
      const int other = leaf->dataAsInt;
      if (other == collider || (other < collider && phase.moved_[other])) return;  // the other finds it too
      const auto [a, b] = std::minmax(collider, other);
      if (phase.contact_.may_meet(a, b)) phase.added_.push_back({a, b});
    }
  };

  const Contact& contact_;
  std::vector<int> colliders_;
  btDbvt tree_;
  std::vector<btDbvtNode*> leaves_;
  std::vector<char> moved_;
  bool changed_ = false;
  std::vector<Pair> pairs_, added_, merged_;
  btNodeStack stack_;
};

class BulletDetector final : public ContactDetector {
 public:
  explicit BulletDetector(const Contact& contact) {
    std::vector<int> boxed;
    std::vector<char> endless;
    const int n = static_cast<int>(contact.colliders().size());
    for (int c = 0; c < n; ++c) {
      first_.push_back(static_cast<int>(parts_.size()));
      flatten(contact.colliders()[c].shape.data(), {}, false, parts_);
      endless.push_back(false);
      for (std::size_t p = first_[c]; p < parts_.size(); ++p)
        if (parts_[p].radius < 0) endless[c] = endless[c] || parts_[p].shape->kind != Kind::surface;
      if (!endless[c]) boxed.push_back(c);
    }
    first_.push_back(static_cast<int>(parts_.size()));
    bool few = true;
    for (int a = 0; a < n; ++a)
      for (int b = a + 1; b < n; ++b) {
        if (!contact.may_meet(a, b)) continue;
        check(a, b);
        thicken(a, b);
        if (few || endless[a] || endless[b]) always_.push_back({a, b});
        few = few && always_.size() <= kFew;
      }
    if (few) return;
    std::erase_if(always_, [&](const Pair& p) { return !endless[p.a] && !endless[p.b]; });
    tree_ = std::make_unique<BroadPhase>(contact, std::move(boxed));
  }

  void find(const ContactPoses& poses, std::span<const double> reach, std::vector<ContactPoint>& points) override {
    for (int c = 0; c + 1 < static_cast<int>(first_.size()); ++c) place(poses, c);
    if (tree_ == nullptr) {
      for (const Pair& p : always_) meet(poses, p.a, p.b, reach[p.a] + reach[p.b], points);
      return;
    }
    for (int c : tree_->colliders()) box(poses, c, reach[c]);
    auto next = always_.begin();
    for (const Pair& p : tree_->pairs()) {
      for (; next != always_.end() && *next < p; ++next)
        meet(poses, next->a, next->b, reach[next->a] + reach[next->b], points);
      meet(poses, p.a, p.b, reach[p.a] + reach[p.b], points);
    }
    for (; next != always_.end(); ++next) meet(poses, next->a, next->b, reach[next->a] + reach[next->b], points);
  }

  double gap(const ContactPoses& poses, int a, int b, double reach) override {
    place(poses, a), place(poses, b);
    found_.clear();
    meet(poses, std::min(a, b), std::max(a, b), reach, found_);
    double least = reach;
    for (const ContactPoint& p : found_) least = std::min(least, p.gap);
    return least;
  }

  double extent(int collider) const override {
    double farthest = 0;
    for (int i = first_[collider]; i < first_[collider + 1]; ++i) {
      const Part& part = parts_[i];
      if (part.radius >= 0)
        farthest = std::max(
            farthest, (part.placement.position + part.placement.orientation * from_bullet(part.local_centre)).norm() +
                          part.radius);
      for (const Vector3& p : part.shape->points)
        farthest = std::max(farthest, (part.placement.position + part.placement.orientation * p).norm());
    }
    return farthest;
  }

  double half_thickness(int collider) const override {
    double least = std::numeric_limits<double>::infinity();
    for (int i = first_[collider]; i < first_[collider + 1]; ++i)
      least = std::min(least, parts_[i].triangles() ? parts_[i].mesh_half : thickness(*parts_[i].shape) / 2);
    return least;
  }

 private:
  static constexpr std::size_t kFew = 64;   // so many pairs need no tree
  static constexpr std::size_t kMany = 32;  // points that are worth a sort of their own

  /// A deforming surface whose nodes may be anywhere.
  static bool unbounded(const Part& part) { return part.shape->kind == Kind::surface && part.shape->reach.size() == 0; }

  /// Throws SceneError for kinds that have no contact.
  void check(int a, int b) const {
    for (int i = first_[a]; i < first_[a + 1]; ++i)
      for (int j = first_[b]; j < first_[b + 1]; ++j)
        if (parts_[i].shape->kind == Kind::half_space && parts_[j].shape->kind == Kind::half_space)
          throw SceneError("colliders " + std::to_string(a) + " and " + std::to_string(b) +
                               " are both half spaces, which do not meet each other",
                           "", "use a box or a mesh for one of them, or groups that keep them apart");
  }

  /// Meshes push each other out from no deeper than the thinner one's share; alone, triangles have no thickness.
  void thicken(int a, int b) {
    for (int i = first_[a]; i < first_[a + 1]; ++i)
      for (int j = first_[b]; j < first_[b + 1]; ++j) {
        if (!parts_[i].triangles() || !parts_[j].triangles()) continue;
        const double half = std::min(narrow::push_depth(*parts_[i].shape), narrow::push_depth(*parts_[j].shape)) / 2;
        for (Part* part : {&parts_[i], &parts_[j]})
          part->mesh_half = part->mesh_half > 0 ? std::min(part->mesh_half, half) : half;
      }
  }

  void place(const ContactPoses& poses, int collider) {
    const MarkerKinematics& marker = poses.collider(collider);
    for (int i = first_[collider]; i < first_[collider + 1]; ++i) {
      Part& part = parts_[i];
      part.at = part.placed
                    ? to_bullet(marker.p + marker.R * part.placement.position, marker.R * part.placement.orientation)
                    : to_bullet(marker.p, marker.R);
      part.centre = part.at(part.local_centre);
    }
  }

  void box(const ContactPoses& poses, int collider, double reach) {
    btVector3 low(1, 1, 1), high(-1, -1, -1);
    for (int i = first_[collider]; i < first_[collider + 1]; ++i) {
      const Part& part = parts_[i];
      btVector3 l, h;
      if (part.shape->kind == Kind::sphere) {
        const btVector3 half(part.radius, part.radius, part.radius);
        l = part.centre - half, h = part.centre + half;
      } else if (unbounded(part)) {
        l = btVector3(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT), h = -l;
        for (const Marker& node : part.shape->nodes) {
          poses.node(collider, node.index, node_);
          l.setMin(to_bullet(node_.p)), h.setMax(to_bullet(node_.p));
        }
      } else {
        part.bullet()->getAabb(part.at, l, h);
      }
      if (part.shape->kind == Kind::surface && !unbounded(part)) {
        double moved = 0;
        for (double eta : poses.deformation(collider)) moved += std::abs(eta);
        moved *= part.shape->reach.maxCoeff();
        l -= btVector3(moved, moved, moved), h += btVector3(moved, moved, moved);
      }
      if (i == first_[collider])
        low = l, high = h;
      else
        low.setMin(l), high.setMax(h);
    }
    const btVector3 grown(reach, reach, reach);
    const double spare = 0.1 * (high - low)[(high - low).minAxis()] + 0.5 * reach;
    tree_->place(collider, btDbvtVolume::FromMM(low - grown, high + grown), spare);
  }

  /// Points of all parts of two colliders, by feature.
  void meet(const ContactPoses& poses, int a, int b, double reach, std::vector<ContactPoint>& points) {
    const std::size_t start = points.size();
    for (int i = first_[a]; i < first_[a + 1]; ++i)
      for (int j = first_[b]; j < first_[b + 1]; ++j) {
        const std::size_t before = points.size();
        meet(poses, a, parts_[i], b, parts_[j], reach, points);
        if (first_[a + 1] - first_[a] + first_[b + 1] - first_[b] == 2) continue;
        for (std::size_t p = before; p < points.size(); ++p)
          points[p].feature = mixed(points[p].feature, i - first_[a], j - first_[b]);
      }
    if (points.size() - start > kMany)
      return std::sort(points.begin() + static_cast<std::ptrdiff_t>(start), points.end(),
                       [](const ContactPoint& p, const ContactPoint& q) { return p.feature < q.feature; });
    // Few points, and mostly in order.
    for (std::size_t i = start + 1; i < points.size(); ++i)
      for (std::size_t j = i; j > start && points[j].feature < points[j - 1].feature; --j)
        std::swap(points[j], points[j - 1]);
  }

  void meet(const ContactPoses& poses, int a, const Part& A, int b, const Part& B, double reach,
            std::vector<ContactPoint>& points) {
    if (A.shape->kind == Kind::surface || B.shape->kind == Kind::surface) {
      const bool first = A.shape->kind == Kind::surface;
      const Part& other = first ? B : A;
      const auto contacts = [&](const ContactPoses& where) {
        narrow::surface_contacts(where, first ? a : b, *(first ? A : B).shape, first ? b : a, *other.shape, reach,
                                 points);
      };
      if (other.placed)
        contacts(PosesOfPart(poses, first ? b : a, other.placement));
      else
        contacts(poses);
      return;
    }
    touches_.clear();
    bool swapped = false;
    if (A.radius >= 0 && B.radius >= 0) {
      const double far = A.radius + B.radius + reach;
      if (!((A.centre - B.centre).length2() < far * far)) return;
      if (A.triangles() && B.triangles())
        narrow::mesh_mesh(*A.shape, A.at, *B.shape, B.at, reach, touches_);
      else if (B.triangles())
        swapped = true, narrow::mesh_convex(*B.shape, B.at, *A.shape->convex, A.at, reach, touches_);
      else if (A.triangles())
        narrow::mesh_convex(*A.shape, A.at, *B.shape->convex, B.at, reach, touches_);
      else
        narrow::convex_convex(*A.shape->convex, A.at, *B.shape->convex, B.at, reach, touches_);
    } else {
      swapped = A.radius >= 0;
      const Part &plane = swapped ? B : A, &other = swapped ? A : B;
      const double height = plane.at.getBasis().getColumn(2).dot(other.centre - plane.at.getOrigin());
      if (!(height < other.radius + reach)) return;
      if (other.triangles())
        narrow::mesh_plane(plane.at, *other.shape, other.at, reach, touches_);
      else
        narrow::plane_convex(plane.at, *other.shape->convex, other.at, reach, touches_);
    }
    for (const narrow::Touch& t : touches_) {
      ContactPoint& p = points.emplace_back();
      p.A.collider = a, p.B.collider = b;
      p.position = t.position, p.normal = swapped ? Vector3(-t.normal) : t.normal;
      p.gap = t.gap, p.curvature = t.curvature, p.feature = t.feature;
    }
  }

  std::vector<Part> parts_;
  std::vector<int> first_;            // part of each collider; the end
  std::vector<Pair> always_;          // looked at each time
  std::unique_ptr<BroadPhase> tree_;  // of the others; none where there are few
  std::vector<narrow::Touch> touches_;
  std::vector<ContactPoint> found_;
  MarkerKinematics node_;
};

}  // namespace detector_parts

std::unique_ptr<ContactDetector> make_bullet_detector(const Contact& contact) {
  return std::make_unique<detector_parts::BulletDetector>(contact);
}

}  // namespace lithe
