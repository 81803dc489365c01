#pragma once

#include <vector>

#include "engine/model/connector.h"
#include "engine/model/marker.h"

namespace lithe {

/// A scalar between two markers A and B:
///   angle         about axis k of A, from the next axis of A (k = z: x) to the same axis of B; rad
///   bearing       about axis k of A, from the next axis of A to the line from A to B; rad
///   displacement  of B from A along axis k of A; m
///   distance      of B from A; m
struct JointCoordinate {
  enum class Kind { angle, bearing, displacement, distance } kind = Kind::angle;
  Marker A, B;
  int axis = 2;     // k: 0 x, 1 y, 2 z
  double sign = 1;  // -1: counted the other way
  bool is_angle() const { return kind == Kind::angle || kind == Kind::bearing; }
  JointCoordinate operator-() const { return {kind, A, B, axis, -sign}; }
};

/// The angle about, the displacement along an axis of A, from A to B: for markers without a joint that provides one.
inline JointCoordinate angle_between(const Marker& A, const Marker& B, int axis = 2) {
  return {JointCoordinate::Kind::angle, A, B, axis};
}
inline JointCoordinate displacement_between(const Marker& A, const Marker& B, int axis = 2) {
  return {JointCoordinate::Kind::displacement, A, B, axis};
}

/// A coordinate at one state. Its rate is Σ W·V over the two markers, its second derivative Σ W·V_dot + bias.
struct MeasuredCoordinate {
  double value, rate, bias;
  Wrench on_A, on_B;  // W: the wrench of a unit force along the coordinate; world axes
};

/// Angles in (-pi, pi]: AngleMemory::wound() adds the turns.
MeasuredCoordinate measure(JointCoordinate::Kind kind, int axis, const MarkerView& A, const MarkerView& B);

/// The coordinates that a connector acts on; its markers come in pairs, A and B of each. A type whose constructor takes
/// (CoordinateSet, Parameters) is added to a graph between coordinates instead of markers.
class CoordinateSet {
 public:
  explicit CoordinateSet(std::vector<JointCoordinate> coordinates) : coordinates_(std::move(coordinates)) {}

  int count() const { return static_cast<int>(coordinates_.size()); }
  const JointCoordinate& operator[](int i) const { return coordinates_[i]; }
  bool is_angle(int i) const { return coordinates_[i].is_angle(); }
  /// Throws SceneError unless there is one: "a spring acts on one coordinate".
  void require_one(const char* element) const;
  /// Throws SceneError for an axis other than 0, 1, 2.
  std::vector<Marker> markers() const;
  std::vector<MeasuredAngle> angles() const;  // one a coordinate, so that places are alike
  /// Its axis k, world axes.
  Vector3 axis(int i, std::span<const MarkerView> markers) const { return markers[2 * i].R.col(coordinates_[i].axis); }
  /// Coordinate i, its turns counted.
  MeasuredCoordinate measure(int i, std::span<const MarkerView> markers, const AngleMemory& memory) const;

 private:
  std::vector<JointCoordinate> coordinates_;
};

}  // namespace lithe
