#pragma once

#include <array>
#include <span>
#include <vector>

#include "engine/model/marker.h"

namespace lithe {

/// Of a sliding joint's markers those of the rail: all but the second, the slider.
struct RailMarkers {
  std::span<const MarkerView> all;
  const MarkerView& operator[](int i) const { return all[static_cast<std::size_t>(of_joint(i))]; }
  int count() const { return static_cast<int>(all.size()) - 1; }
  static int of_joint(int i) { return i == 0 ? 0 : i + 1; }
};

/// A smooth curve through the positions of markers, with a continuous direction: cubic Hermite polynomials between
/// them, whose slopes are those of the parabola through a marker and its two neighbours (Catmull & Rom, 1974, on knots
/// u_i that are the distances as drawn). It goes on straight beyond its ends.
///   r(u) = Σ w_a(u) P_a   over four markers
class RailCurve {
 public:
  /// Where on the curve, and how it depends on the markers there.
  struct Place {
    double u;   // m, as drawn
    int first;  // of four (or three) markers
    int count;
    std::array<double, 4> w, dw, ddw;  // weights and their derivatives by u
  };

  /// `markers`: as drawn. Throws SceneError for fewer than three and for two that coincide.
  void draw(const RailMarkers& markers);
  double length() const { return knots_.back(); }  // m, as drawn

  /// The place nearest to `point`: r' · (point - r) = 0. Of several, one on a stretch beside the nearest marker.
  Place nearest(const RailMarkers& markers, const Vector3& point) const;
  /// Two directions across the curve at a place. They turn with the markers' axes and with the curve, and vary smoothly
  /// along it and in time, unless a stretch of markers whose axes do not turn comes to point backwards.
  std::array<Vector3, 2> across(const RailMarkers& markers, const Place& place) const;

  /// Σ weights · (positions, or velocities, of the markers).
  static Vector3 positions(const RailMarkers& markers, const Place& at, const std::array<double, 4>& weights);
  static Vector3 velocities(const RailMarkers& markers, const Place& at, const std::array<double, 4>& weights);

 private:
  int count() const { return static_cast<int>(knots_.size()); }
  Place place(double u) const;
  void add_slope(int knot, const std::array<double, 3>& factors, Place& place) const;

  std::vector<double> knots_;             // u_i
  std::vector<Vector3> along_, normals_;  // direction and a normal as drawn, in marker axes
};

}  // namespace lithe
