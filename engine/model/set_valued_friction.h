#pragma once

#include <span>

#include "engine/model/marker.h"

namespace lithe {

class Constraint;

/// A force element whose joint rubs by Coulomb's set-valued law, |F| <= μ N: time-stepping methods find F with the
/// joint's reaction, so that surfaces that stick do not move at all. Its compliant rows, one a direction, carry no
/// friction: they tell how the surfaces slide, s = Σ W·V. What acted in the last step is kept in the velocity of its
/// last marker, a FirstOrderStates body's.
class SetValuedFriction {
 public:
  virtual ~SetValuedFriction() = default;
  /// Whose reaction presses the surfaces.
  virtual const Constraint& pressed_by() const = 0;
  /// N = load() + Σ |P_i R|: R, the joint's reaction (force, moment) at its second marker, world axes.
  virtual double load() const = 0;
  using Press = Eigen::Matrix<double, 3, 6>;
  static constexpr int kMostPresses = 3;
  /// Fills P, at most kMostPresses; returns how many.
  virtual int presses(std::span<const MarkerView> markers, Press* P) const = 0;
  /// How far the surfaces have slid between two near states, one entry a direction, m.
  virtual Vector3 slid(std::span<const MarkerView> from, std::span<const MarkerView> to) const = 0;
  /// μ(s); at zero that of surfaces that stick.
  virtual double friction(double speed) const = 0;
};

}  // namespace lithe
