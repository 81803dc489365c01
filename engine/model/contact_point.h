#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "engine/base/math.h"
#include "engine/model/marker.h"

namespace lithe {

/// Where a contact touches one of its colliders: a point that moves with the collider's marker, or the weighted mean of
/// up to three nodes of a deforming surface (markers of the same body).
struct ContactSide {
  int collider = -1;   // place in the contact's list
  int node_count = 0;  // 0: fixed in the axes of the collider's marker
  std::array<int, 3> nodes{};
  std::array<double, 3> weights{};
};

/// Two surfaces near each other at one state; world axes.
struct ContactPoint {
  ContactSide A, B;
  Vector3 position;           // midway between the surfaces, m; loads on deforming ones act at the node instead
  Vector3 normal;             // unit, out of A, towards B
  double gap = 0;             // along the normal, m; negative: how deep they overlap
  double curvature = 0;       // mean relative curvature, 1/m: 1/R_A + 1/R_B of spheres; 0: flat on flat
  std::uint64_t feature = 0;  // names the point among those of its two colliders, from state to state
};

/// Where the colliders of one contact element are.
class ContactPoses {
 public:
  virtual ~ContactPoses() = default;
  /// Position and axes of the collider's marker; in `A`, `r` and `v`, `w` too, if the state was evaluated so far.
  virtual const MarkerKinematics& collider(int collider) const = 0;
  /// A node of a deforming collider, by the number of its marker on the body.
  virtual void node(int collider, int marker, MarkerKinematics& out) const = 0;
  /// η of the collider's body; empty for a rigid one. For bounds on how far its nodes have moved.
  virtual std::span<const double> deformation(int collider) const = 0;
};

/// Finds the points of one contact element. Has scratch: one a thread.
class ContactDetector {
 public:
  virtual ~ContactDetector() = default;
  /// Appends all points between colliders that may meet whose gap is below reach[a] + reach[b] (m, one a collider).
  /// Ordered, and the same bits, for the same poses and reach, whatever was asked before.
  virtual void find(const ContactPoses& poses, std::span<const double> reach, std::vector<ContactPoint>& points) = 0;
  /// Least gap of two colliders, or `reach` if it is larger.
  virtual double gap(const ContactPoses& poses, int a, int b, double reach) = 0;
  /// How far the collider's surface is from its marker at most, m; 0 for one that has no end. Bounds how fast it moves.
  virtual double extent(int /*collider*/) const { return 0; }
  /// How deep another surface may be in the collider and still be pushed out on the side it came from, m: half its
  /// least thickness; infinite where it has no other side.
  virtual double half_thickness(int /*collider*/) const { return std::numeric_limits<double>::infinity(); }
};

}  // namespace lithe
