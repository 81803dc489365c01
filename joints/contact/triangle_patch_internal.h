#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "joints/contact/shape_internal.h"

/// Triangles near another shape, world axes. For joints/contact alone.
namespace lithe::narrow {

/// A number that names a point by three others.
std::uint64_t feature_name(std::uint64_t kind, std::uint64_t a, std::uint64_t b);

struct PatchTriangle {
  std::array<int, 3> corners;  // of the mesh
  std::array<bool, 3> open;    // edge i -> i + 1
  std::array<Vector3, 3> x;
  Vector3 normal, low, high;  // unit, outwards; bounds
  double size;                // longest edge
  std::uint64_t facet;        // the same for triangles in one plane
};

/// The surface is A of the touch; its point is Σ weights x of the triangle.
struct PatchTouch {
  Touch touch;
  int triangle;  // place in the patch
  Vector3 weights;
};

/// Where edges of two surfaces cross, A the first: its point is Σ weights x of the triangle, as that of B.
struct EdgeTouch {
  Touch touch;
  int triangle, other;  // places in the patches
  Vector3 weights, other_weights;
};

/// Part of a surface, and what of it a shape touches. Keeps scratch.
class TrianglePatch {
 public:
  enum class Corners { sharp, all };  // of the surface, against a convex shape

  std::vector<PatchTriangle> triangles;

  void clear() { triangles.clear(); }
  /// `local`: corners in the axes of the mesh, undeformed: they name the facet.
  void add(const std::array<int, 3>& corners, const std::array<bool, 3>& open, const std::array<Vector3, 3>& x,
           const std::array<Vector3, 3>& local);
  /// A ball, or a point if its radius is zero. Outside the surface: every place that is nearer than those around it (a
  /// point: over faces alone), with gap < reach. Inside: the nearest place, no deeper than `depth`. `arms`: of a
  /// corner, to its neighbours; a normal against which its body goes on is not its own.
  void meet_ball(const Vector3& center, double radius, double reach, double depth, std::uint64_t name,
                 std::vector<PatchTouch>& touches, std::span<const Vector3> arms = {});
  void meet_convex(const btConvexShape& b, const btTransform& bt, double reach, Corners corners,
                   std::vector<PatchTouch>& touches);
  /// Corners of another surface that stand out, no deeper than `depth`.
  void meet_corners_of(const TrianglePatch& other, double reach, double depth, std::vector<PatchTouch>& touches);
  /// Open edges of both that cross, no deeper than `depth`.
  void meet_edges_of(TrianglePatch& other, double reach, double depth, std::vector<EdgeTouch>& touches);

 private:
  struct OpenEdge {
    int triangle, edge, other;  // and the triangle behind it; -1: none
  };
  /// Each once.
  const std::vector<OpenEdge>& find_open_edges();
  struct Near {
    int triangle;
    Vector3 weights, place;
    double distance, height;  // from the triangle; over its plane
  };
  bool is_nearest_around(const Near& near) const;
  bool on_border(const Near& near) const;
  void meet_samples(const btConvexShape& b, const btTransform& bt, double reach, double size,
                    std::vector<PatchTouch>& touches);
  void meet_corners(const Polyhedron& b, double radius, double reach, std::vector<PatchTouch>& touches);
  void meet_edges(const btConvexShape& b, const btTransform& bt, double radius, double reach,
                  std::vector<PatchTouch>& touches);
  void meet_own_corners(const btConvexShape& b, const btTransform& bt, double reach, double size, Corners corners,
                        std::vector<PatchTouch>& touches);
  void meet_by_gjk(const btConvexShape& b, const btTransform& bt, double reach, std::vector<PatchTouch>& touches) const;
  /// The other triangle at edge i of a triangle; -1: none.
  int twin(int triangle, int i) const;
  /// How deep a point is inside, where that is no more than `most`; 0: outside.
  double depth_of(const Vector3& x, double most);
  /// Whether edges that lie `depth` across each other, along d, about `middle`, do so because their bodies overlap that
  /// far there. If not, there is a shorter way out.
  bool overlaps(const OpenEdge& mine, TrianglePatch& other, const OpenEdge& theirs, const Vector3& middle,
                const Vector3& d, double depth);
  /// Whether a contact with direction d may lean over edge i.
  bool leans(int triangle, int i, int other, const Vector3& d) const;

  std::vector<Near> near_;
  std::vector<Vector3> corners_;  // of the convex shape, world axes
  std::vector<int> seen_;
  std::vector<PatchTouch> found_;
  std::vector<OpenEdge> open_;
  std::vector<Vector3> arms_;
};

namespace triangle_parts {
constexpr double kRound = 1e-8;     // places closer than this part of a triangle are one
constexpr double kParallel = 1e-7;  // rad
constexpr double kSlope = 0.2;      // corners of a face that faces the surface rise less over the lowest one
/// Weights of the place of a triangle nearest to x; those of the corners that it does not lie between are zero.
Vector3 nearest_weights(const std::array<Vector3, 3>& corners, const Vector3& x);
/// Drops points that are there already, from `start` on: same place and same normal.
void drop_duplicates(const std::vector<PatchTriangle>& triangles, std::size_t start, std::vector<PatchTouch>& touches);
}  // namespace triangle_parts

/// A point and a convex shape: distance to its surface (negative inside), its normal there, and whether that is of a
/// face rather than an edge or a corner. World axes.
struct PointOnConvex {
  double distance;
  Vector3 normal;
  bool on_face;
};
PointOnConvex point_convex(const btConvexShape& b, const btTransform& bt, const Vector3& point);

/// Adds triangles of a mesh by their numbers.
void fill_patch(const Shape::Data& mesh, const btTransform& at, std::span<const int> numbers, TrianglePatch& patch);
/// How deep a corner of a surface may be and still be pushed back the way it came: half the surface's thickness, m.
double push_depth(const Shape::Data& surface);

/// Triangles of a mesh whose boxes meet a box in its axes: indices, rising; replaces what was there.
void find_triangles(const Shape::Data& mesh, const Vector3& low, const Vector3& high, std::vector<int>& found);
/// Bounds of the part of a mesh, undeformed, that lies in the half space normal · x <= offset of its axes; false: none.
bool bounds_below(const Shape::Data& mesh, const Vector3& normal, double offset, Vector3& low, Vector3& high);

}  // namespace lithe::narrow
