#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "joints/contact/triangle_patch_internal.h"

namespace lithe::narrow {
namespace triangle_parts {

Vector3 from_local(const btTransform& bt, const Vector3& x) { return from_bullet(bt * to_bullet(x)); }

}  // namespace triangle_parts

void TrianglePatch::meet_convex(const btConvexShape& b, const btTransform& bt, double reach, Corners corners,
                                std::vector<PatchTouch>& touches) {
  const std::size_t start = touches.size();
  const auto* polyhedron = static_cast<const Polyhedron*>(b.getUserPointer());
  const bool is_sphere = b.getShapeType() == SPHERE_SHAPE_PROXYTYPE;
  const bool is_round = is_sphere || b.getShapeType() == CAPSULE_SHAPE_PROXYTYPE;
  if (is_sphere) {
    const double radius = b.getMargin();
    meet_ball(from_bullet(bt.getOrigin()), radius, reach, radius, 0, touches);
  } else if (polyhedron) {
    const double radius = is_round ? b.getMargin() : 0;
    corners_.clear();
    for (const Vector3& c : polyhedron->corners) corners_.push_back(triangle_parts::from_local(bt, c));
    meet_corners(*polyhedron, radius, reach, touches);
    meet_edges(b, bt, radius, reach, touches);
    meet_own_corners(b, bt, reach, is_round ? radius : 0.5 * polyhedron->size, corners, touches);
  } else {
    btVector3 low, high;
    b.getAabb(btTransform::getIdentity(), low, high);
    const double size = (high - low)[(high - low).maxAxis()];
    meet_samples(b, bt, reach, size, touches);
    meet_own_corners(b, bt, reach, 0.5 * size, corners, touches);
    meet_by_gjk(b, bt, reach, touches);
  }
  triangle_parts::drop_duplicates(triangles, start, touches);
}

void TrianglePatch::meet_corners(const Polyhedron& b, double radius, double reach, std::vector<PatchTouch>& touches) {
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    found_.clear();
    meet_ball(corners_[i], radius, reach, radius > 0 ? radius : b.size, i, found_);
    for (const PatchTouch& touch : found_) {
      const Vector3 d = touch.touch.normal;
      std::size_t lowest = 0;
      double highest = d.dot(corners_[0]);
      for (std::size_t k = 1; k < corners_.size(); ++k) {
        if (d.dot(corners_[k] - corners_[lowest]) < 0) lowest = k;
        highest = std::max(highest, d.dot(corners_[k]));
      }
      const Vector3 from_lowest = corners_[i] - corners_[lowest];
      const bool inside = touch.touch.gap + radius < 0;
      const double surface = d.dot(touch.touch.position) - 0.5 * touch.touch.gap;
      if (inside ? highest + radius > surface : d.dot(from_lowest) <= triangle_parts::kSlope * from_lowest.norm())
        touches.push_back(touch);
    }
  }
}

/// What has no corners: the lowest point over each plane, and others of a face or line that lies in it.
void TrianglePatch::meet_samples(const btConvexShape& b, const btTransform& bt, double reach, double size,
                                 std::vector<PatchTouch>& touches) {
  constexpr double kTilt = 0.02;
  const auto support = [&](const Vector3& d) {
    return from_bullet(bt * b.localGetSupportingVertexWithoutMargin(to_bullet(d) * bt.getBasis()));
  };
  for (std::size_t first = 0; first < triangles.size(); ++first) {
    const std::uint64_t facet = triangles[first].facet;
    const Vector3 n = triangles[first].normal;
    if (std::any_of(triangles.begin(), triangles.begin() + first,
                    [&](const PatchTriangle& t) { return t.facet == facet && t.normal.dot(n) > 1 - 1e-9; }))
      continue;
    btVector3 across, along;
    btPlaneSpace1(to_bullet(n), across, along);
    corners_.assign(1, support(-n));
    const double top = n.dot(support(n));
    for (int k = 0; k < 8; ++k) {
      const double angle = k * M_PI / 4;
      const Vector3 tilt = std::cos(angle) * from_bullet(across) + std::sin(angle) * from_bullet(along);
      const Vector3 sample = support(kTilt * tilt - n);
      if (std::none_of(corners_.begin(), corners_.end(),
                       [&](const Vector3& c) { return (c - sample).norm() < 2.5 * kTilt * size; }))
        corners_.push_back(sample);
    }
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      found_.clear();
      meet_ball(corners_[i], 0, reach, size, i, found_);
      for (PatchTouch& touch : found_) {
        const PatchTriangle& t = triangles[touch.triangle];
        if (t.facet == facet && touch.touch.normal.dot(n) > 1 - 1e-9 && top > n.dot(t.x[0])) touches.push_back(touch);
      }
    }
  }
}

/// Open edges across edges of the shape, or across the axis of a capsule.
void TrianglePatch::meet_edges(const btConvexShape& shape, const btTransform& bt, double radius, double reach,
                               std::vector<PatchTouch>& touches) {
  const Polyhedron& b = *static_cast<const Polyhedron*>(shape.getUserPointer());
  const double range = std::max(reach + radius, radius > 0 ? radius : 0.5 * b.size);
  constexpr double kRound = triangle_parts::kRound;
  constexpr int kUnknown = -2;
  for (int k = 0; k < static_cast<int>(triangles.size()); ++k)
    for (int i = 0; i < 3; ++i) {
      const PatchTriangle& t = triangles[k];
      if (!t.open[i]) continue;
      const Vector3 &a0 = t.x[i], &a1 = t.x[(i + 1) % 3], along = a1 - a0;
      const Vector3 low = a0.cwiseMin(a1).array() - range, high = a0.cwiseMax(a1).array() + range;
      int j = kUnknown;
      for (std::size_t e = 0; e < b.edges.size(); ++e) {
        const Vector3 &b0 = corners_[b.edges[e].ends[0]], &b1 = corners_[b.edges[e].ends[1]], across = b1 - b0;
        if ((b0.cwiseMin(b1).array() > high.array()).any() || (b0.cwiseMax(b1).array() < low.array()).any()) continue;
        const Vector3 between = b0 - a0, square = along.cross(across);
        const double sine = square.norm();
        if (sine <= 1e-6 * along.norm() * across.norm()) continue;
        // a0 + s along and b0 + u across, joined by a line square to both
        double s = between.cross(across).dot(square) / (sine * sine);
        const double u = between.cross(along).dot(square) / (sine * sine), apart = between.dot(square) / sine;
        const double beyond = std::max(-s, s - 1);
        if (u < -kRound || u > 1 + kRound || (beyond > kRound && beyond * along.norm() > std::abs(apart))) continue;
        if (j == kUnknown) j = twin(k, i);
        if (j >= 0 && j < k) break;  // its turn was before
        const Vector3 facing = j >= 0 ? Vector3(t.normal + triangles[j].normal) : t.normal;
        const double sign = square.dot(facing) < 0 ? -1 : 1;
        const Vector3 d = (sign / sine) * square;
        const double gap = sign * apart - radius;
        if (gap >= reach || !leans(k, i, j, d)) continue;
        if (beyond > kRound) {
          // What went in over the edge may be beyond its end by no more than the corner there is inside.
          const double over = beyond * along.norm();
          if (over > -gap || over > -point_convex(shape, bt, s < 0 ? a0 : a1).distance) continue;
          s = std::clamp(s, 0.0, 1.0);
        }
        // The shape must lie beyond its edge, and not be through the surface.
        double least = std::numeric_limits<double>::infinity(), most = -least;
        for (const Vector3& c : corners_) least = std::min(least, d.dot(c - b0)), most = std::max(most, d.dot(c - b0));
        if (least < -triangle_parts::kParallel * b.size || gap < -0.5 * most - 2 * radius) continue;
        const Vector3 place = a0 + s * along;
        Vector3 weights = Vector3::Zero();
        weights[i] = 1 - s, weights[(i + 1) % 3] = s;
        const std::uint64_t edge = feature_name(3, t.corners[i], 0) + feature_name(3, t.corners[(i + 1) % 3], 0);
        touches.push_back(
            {{place + 0.5 * gap * d, d, gap, radius > 0 ? 0.5 / radius : 0, feature_name(4, e, edge)}, k, weights});
      }
    }
}

/// Corners of the surface that stand out against the shape's faces.
void TrianglePatch::meet_own_corners(const btConvexShape& b, const btTransform& bt, double reach, double size,
                                     Corners corners, std::vector<PatchTouch>& touches) {
  const double rise = corners == Corners::all ? 0.7 : triangle_parts::kParallel;  // a deformed surface is bumpy
  seen_.clear();
  for (int k = 0; k < static_cast<int>(triangles.size()); ++k)
    for (int i = 0; i < 3; ++i) {
      const PatchTriangle& t = triangles[k];
      if (corners == Corners::sharp && !t.open[i] && !t.open[(i + 2) % 3]) continue;
      if (std::find(seen_.begin(), seen_.end(), t.corners[i]) != seen_.end()) continue;
      seen_.push_back(t.corners[i]);
      const PointOnConvex at = point_convex(b, bt, t.x[i]);
      if (at.distance >= reach || at.distance < -size || (at.distance > 0 && !at.on_face)) continue;
      const Vector3 d = -at.normal;
      Vector3 facing = Vector3::Zero();
      bool stands_out = true;
      for (const PatchTriangle& other : triangles) {
        if (std::find(other.x.begin(), other.x.end(), t.x[i]) == other.x.end()) continue;
        facing += other.normal;
        for (const Vector3& x : other.x) stands_out = stands_out && d.dot(x - t.x[i]) <= rise * (x - t.x[i]).norm();
      }
      if (!stands_out || d.dot(facing) < 0.1 * facing.norm()) continue;
      touches.push_back(
          {{t.x[i] + 0.5 * at.distance * d, d, at.distance, 0, feature_name(5, t.corners[i], 0)}, k, Vector3::Unit(i)});
    }
}

/// Open edges against a shape without edges: the deepest point of each.
void TrianglePatch::meet_by_gjk(const btConvexShape& b, const btTransform& bt, double reach,
                                std::vector<PatchTouch>& touches) const {
  struct Nearest final : btDiscreteCollisionDetectorInterface::Result {
    btVector3 normal, on_b;
    btScalar distance = std::numeric_limits<double>::infinity();
    void setShapeIdentifiersA(int, int) override {}
    void setShapeIdentifiersB(int, int) override {}
    void addContactPoint(const btVector3& n, const btVector3& point, btScalar depth) override {
      if (depth < distance) normal = n, on_b = point, distance = depth;
    }
  };
  const std::size_t start = touches.size();
  const Vector3 origin = from_bullet(bt.getOrigin());  // round-off is that of lengths about the shape
  for (int k = 0; k < static_cast<int>(triangles.size()); ++k) {
    const PatchTriangle& t = triangles[k];
    if (!t.open[0] && !t.open[1] && !t.open[2]) continue;
    btTriangleShape shape(to_bullet(t.x[0] - origin), to_bullet(t.x[1] - origin), to_bullet(t.x[2] - origin));
    shape.setMargin(0);
    btVoronoiSimplexSolver simplex;
    btGjkEpaPenetrationDepthSolver penetration;
    btGjkPairDetector detector(&shape, &b, &simplex, &penetration);
    btGjkPairDetector::ClosestPointInput input;
    input.m_transformA.setIdentity();
    input.m_transformB = btTransform(bt.getBasis());
    input.m_maximumDistanceSquared = (reach + t.size) * (reach + t.size);
    Nearest nearest;
    detector.getClosestPoints(input, nearest, nullptr);
    if (!(nearest.distance < reach)) continue;
    const Vector3 d = -from_bullet(nearest.normal);
    const Vector3 place = from_bullet(nearest.on_b) - nearest.distance * d + origin;
    const Vector3 weights = triangle_parts::nearest_weights(t.x, place);
    for (int i = 0; i < 3; ++i) {
      if (!t.open[i] || weights[(i + 2) % 3] > 1e-6 || !leans(k, i, twin(k, i), d)) continue;
      const std::uint64_t edge = feature_name(3, t.corners[i], 0) + feature_name(3, t.corners[(i + 1) % 3], 0);
      const std::uint64_t name = feature_name(6, edge, 0);
      if (std::none_of(touches.begin() + static_cast<std::ptrdiff_t>(start), touches.end(),
                       [&](const PatchTouch& other) { return other.touch.feature == name; }))
        touches.push_back({{place + 0.5 * nearest.distance * d, d, nearest.distance, 0, name}, k, weights});
      break;
    }
  }
}

PointOnConvex point_convex(const btConvexShape& b, const btTransform& bt, const Vector3& point) {
  const Vector3 x = from_bullet(bt.invXform(to_bullet(point)));
  const auto world = [&](const Vector3& n) { return from_bullet(bt.getBasis() * to_bullet(n)); };
  const double off_axis = std::hypot(x[0], x[1]);
  const Vector3 radial = off_axis > 0 ? Vector3(x[0] / off_axis, x[1] / off_axis, 0) : Vector3::UnitX();
  switch (b.getShapeType()) {
    case SPHERE_SHAPE_PROXYTYPE:
    case CAPSULE_SHAPE_PROXYTYPE: {
      double half = 0;
      if (b.getShapeType() == CAPSULE_SHAPE_PROXYTYPE) half = static_cast<const btCapsuleShape&>(b).getHalfHeight();
      const Vector3 way = x - Vector3(0, 0, std::clamp(x[2], -half, half));
      const double distance = way.norm();
      return {distance - b.getMargin(), world(distance > 0 ? Vector3(way / distance) : radial), true};
    }
    case CYLINDER_SHAPE_PROXYTYPE: {
      const btVector3 half = static_cast<const btCylinderShape&>(b).getHalfExtentsWithMargin();
      const double side = off_axis - half.x(), end = std::abs(x[2]) - half.z();
      if (side > end) return {side, world(radial), end <= 0};
      return {end, world({0, 0, x[2] < 0 ? -1.0 : 1.0}), side <= 0};
    }
    case CONE_SHAPE_PROXYTYPE: {
      const auto& cone = static_cast<const btConeShape&>(b);
      const double radius = cone.getRadius(), height = cone.getHeight(), slant = std::hypot(radius, height);
      const double side = ((off_axis - radius) * height + (x[2] + height / 2) * radius) / slant;
      const double base = -(x[2] + height / 2);
      if (base >= side) return {base, world({0, 0, -1}), off_axis <= radius};
      const double foot = x[2] - side * radius / slant;
      return {side, world((height * radial + radius * Vector3::UnitZ()) / slant), std::abs(foot) <= height / 2};
    }
    default:
      break;
  }
  PointOnConvex most{-std::numeric_limits<double>::infinity(), Vector3::Zero(), true};
  const auto* polyhedron = static_cast<const Polyhedron*>(b.getUserPointer());
  if (!polyhedron) return {std::numeric_limits<double>::infinity(), Vector3::UnitZ(), false};
  const auto over = [&](std::size_t face, const Vector3& p) {
    return polyhedron->normals[face].dot(p - polyhedron->corners[polyhedron->loop(static_cast<int>(face))[0]]);
  };
  std::size_t nearest = 0;
  for (std::size_t f = 0; f < polyhedron->normals.size(); ++f)
    if (const double distance = over(f, x); distance > most.distance) most.distance = distance, nearest = f;
  const Vector3 foot = x - most.distance * polyhedron->normals[nearest];
  for (std::size_t f = 0; f < polyhedron->normals.size(); ++f)
    most.on_face = most.on_face && over(f, foot) <= triangle_parts::kParallel * polyhedron->size;
  most.normal = world(polyhedron->normals[nearest]);
  return most;
}

}  // namespace lithe::narrow
