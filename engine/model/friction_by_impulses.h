#pragma once

#include <span>

#include "engine/model/marker.h"

namespace lithe {

class Constraint;

/// A force element whose friction in a joint time-stepping methods find as impulses, together with the joint's reaction
/// and with the impulses of contact that press it. While they do its compliant rows, one a direction, tell how the
/// surfaces slide, s = Σ W·V, and carry no friction.
class FrictionByImpulses {
 public:
  virtual ~FrictionByImpulses() = default;
  /// Whether surfaces that stick hold |F| <= μ N, Coulomb's law. Others cannot do without time stepping then: what
  /// acted in the last step is kept in the velocity of the last marker, a FirstOrderStates body's. Else its rows carry
  /// its friction wherever nobody leaves it out (ForceRows::friction_left_out()).
  virtual bool is_set_valued() const = 0;
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
  /// μ over a step, by the speeds at its start and end, m/s; at a speed of zero at the end that of surfaces that stick.
  virtual double friction(double before, double after) const = 0;
};

}  // namespace lithe
