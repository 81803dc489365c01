#pragma once

#include <algorithm>
#include <array>

#include "joints/contact/shape_internal.h"

/// A pair of convex shapes in the axes of its first. For the narrow phase alone.
namespace lithe::narrow {

/// A convex shape as its core (corners and faces, or a cylinder or cone) with a radius around it.
struct Solid {
  const Polyhedron* flat = nullptr;       // null: round
  std::vector<Vector3> corners, normals;  // those of `flat` in the pair's axes
  bool cone = false;                      // of a round one: else a cylinder
  Vector3 centre, axis, across;           // `across`: at right angles to the axis
  double rim = 0, half_length = 0;
  double radius = 0;  // around the core
  double size = 0;    // of the core

  void set(const btConvexShape& shape, const Vector3& position, const Matrix3& orientation);
  Vector3 tip() const { return centre + half_length * axis; }
  /// Largest n·x of the core.
  double support(const Vector3& n) const;
  /// A point of the core where n·x is largest.
  Vector3 extreme(const Vector3& n) const;
  Vector3 middle() const;
  double sin_side() const { return rim / std::hypot(rim, 2 * half_length); }  // of a cone: n·axis of its side's normal

 private:
  Polyhedron triangle_;
};

/// How far apart the cores are along a direction, and where: on_b = on_a + distance normal. The largest over all
/// directions is their distance, or, negative, the least depth.
struct Separation {
  Vector3 normal;  // unit, from A to B
  double distance = -std::numeric_limits<double>::infinity();
  Vector3 on_a;  // NaN: somewhere on a face

  /// Takes another direction if it separates more, by `lead`.
  void offer(const Solid& a, const Solid& b, const Vector3& n, const Vector3& point_on_a, double lead = 0) {
    if (!(std::abs(n.squaredNorm() - 1) < 1e-9)) return;  // features at one place have no direction
    const double d = -b.support(-n) - a.support(n);
    if (d > distance + lead) normal = n, distance = d, on_a = point_on_a;
  }
};

/// Best of the directions square to faces and to pairs of edges: all that two overlapping polyhedra can have.
Separation separation_of_faces(const Solid& a, const Solid& b, double enough);
/// Best of those and of all pairs of features near where Bullet's GJK and EPA see the shapes nearest.
void refine_separation(const btConvexShape& a, const btConvexShape& b, const btTransform& b_in_a, const Solid& A,
                       const Solid& B, Separation& best);
/// Corners of the patch in which A and B face each other along the normal of `at`; in the pair's axes. Returns the
/// least distance of the cores at those that are on both: where it is that of `at`, nothing is nearer.
double patch(const Solid& a, const Solid& b, const Separation& at, std::vector<Touch>& touches);

}  // namespace lithe::narrow
