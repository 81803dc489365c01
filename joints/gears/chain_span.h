#pragma once

#include <span>

#include "engine/model/force_element.h"

namespace lithe {

/// A roller chain or a toothed belt.
struct ChainDrive {
  double pitch = 0;            // p, m
  double axial_stiffness = 0;  // EA, N
  double damping = 0;          // c of a straight part, N s/m
  double pretension = 0;       // as drawn, N
  double slack = 0;            // of each straight part as drawn, m; where there is no pretension
  bool polygon = true;         // false: a toothed belt
  /// Throws SceneError for a pitch or stiffness that is not positive, and for what is negative or not finite.
  void check() const;
};

/// A sprocket as a chain that runs from A to B sees it.
struct Sprocket {
  int teeth = 0;
  double radius = 0;  // m: of the joints of a chain, p/(2 sin(π/z)), or of the pitch circle of a belt, p z/2π
  int side = 1;       // 1: the span lies to the left of the way from A to B seen against z, -1: to the right

  /// Throws SceneError for fewer than five teeth and a pitch that is not positive.
  Sprocket(int teeth, const ChainDrive& chain, int side);
};

struct ChainMaterial;

/// One straight part of a chain or toothed belt, along the common tangent of two sprockets, crossed where they lie on
/// different sides of it.
struct ChainSpan {
  double normal_A, normal_B;  // outward normals of A and B where it touches, in the axes of either marker, rad, turns
                              // counted
  double straight;            // its length, m
  double length;              // with what the sprockets have taken in since an origin of its own, m
  Wrench on_A, on_B;          // ∂length

  /// Angles 0 and 1 of `memory`: those that an element measures by bearings().
  static ChainSpan between(const Sprocket& A, const Sprocket& B, const ChainDrive& chain,
                           std::span<const MarkerView> markers, const AngleMemory& memory);
  static std::vector<MeasuredAngle> bearings() {
    return {{.A = 0, .B = 1, .axis = 2, .to_point = true}, {.A = 1, .B = 0, .axis = 2, .to_point = true}};
  }
  /// Pulls as an elastic row, T = max(0, k (Λ - L)) + LimitedDamping.
  void pull(const ChainMaterial& material, double damping, std::span<const MarkerView> markers, ForceRows& rows) const;
  /// Throws SceneError for axes that are not about parallel, and for sprockets that overlap.
  static void check(const Sprocket& A, const Sprocket& B, std::span<const MarkerView> markers);
};

/// What a span is made of, from its drawing: EA (straight - L₀)/L₀ is the pretension.
struct ChainMaterial {
  double stiffness = 0, length = 0;  // EA/L₀, N/m; at rest, with what the sprockets have taken in, m
  ChainMaterial() = default;
  ChainMaterial(const ChainSpan& drawn, const ChainDrive& chain);
};

/// The direction at `angle` in the xy plane of a marker.
Vector3 in_plane_direction(const MarkerView& m, double angle);

}  // namespace lithe
