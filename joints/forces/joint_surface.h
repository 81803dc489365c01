#pragma once

#include <vector>

#include "engine/model/force_element.h"
#include "engine/model/friction_by_impulses.h"
#include "engine/model/joint_coordinate.h"

namespace lithe {

/// The surfaces on which a joint rubs: how they slide on each other, and what presses them together.
///   pin, slide       one coordinate: s = r φ̇ or ẋ
///   sleeve, screw    an angle and a displacement along its axis: s = (r φ̇, ẋ), so that friction acts against the
///                    helix on which the surfaces slide
///   ball             no coordinate: s = r (ω_B - ω_A), in the axes of A
///   N = |F_lat| + |(F_ax, T_ax / r)| + |T_lat| / l + N₀
/// F, T: the joint's reaction at its second marker, along the coordinate's axis and across it. Of a screw, F_ax and
/// T_ax / r are the parts of the force normal to its thread. A slide has no F_ax, a pin no T_ax; a ball has |F| + N₀.
class JointSurface {
 public:
  struct Parameters {
    const Constraint* joint;  // its reaction presses
    double radius;            // r, m; all but a slide need it
    double bending_arm;       // l, m: between the bearing's halves; 0: bending does not press
    double preload;           // N₀, N
  };
  /// Throws SceneError without a joint, without a radius where one is needed, for coordinates that are none of the
  /// above, and for what is negative or not finite.
  JointSurface(CoordinateSet coordinates, Parameters parameters);

  /// Of sliding: 1, 2 or 3.
  int directions() const { return ball() ? 3 : coordinates_.count(); }
  /// Of the coordinates, or the joint's own two.
  int marker_count() const { return ball() ? 2 : 2 * coordinates_.count(); }
  std::vector<MeasuredAngle> angles() const { return coordinates_.angles(); }
  const Constraint* joint() const { return parameters_.joint; }
  double preload() const { return parameters_.preload; }
  /// Force over sliding speed, N s/m, of a viscous friction that a pin and a ball have in N m s/rad.
  double viscous(double given) const;

  struct Sliding {
    Vector3 speed{0, 0, 0};   // s, m/s
    Wrench on_A[3], on_B[3];  // of a unit force along each direction
  };
  Sliding sliding(std::span<const MarkerView> markers, const AngleMemory& memory) const;
  /// Wrenches of a unit force along `direction`, one for each of marker_count().
  void fill(const Sliding& sliding, const Vector3& direction, Wrench* wrenches) const;

  /// Between two near states, along each direction, m.
  Vector3 slid(std::span<const MarkerView> from, std::span<const MarkerView> to) const;
  /// N = N₀ + Σ |P_i R|: fills P (FrictionByImpulses), returns how many.
  int presses(std::span<const MarkerView> markers, FrictionByImpulses::Press* P) const;
  struct Press {
    double force;  // N
    Wrench by;     // ∂N/∂reaction
  };
  Press press(std::span<const MarkerView> markers, const Wrench& reaction) const;

 private:
  bool ball() const { return coordinates_.count() == 0; }
  bool turns() const { return ball() || coordinates_.is_angle(0); }
  bool slides() const { return !ball() && !coordinates_.is_angle(coordinates_.count() - 1); }

  const CoordinateSet coordinates_;
  const Parameters parameters_;
};

}  // namespace lithe
