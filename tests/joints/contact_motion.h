#pragma once

#include "joints/contact/laws.h"

/// What tests of contact laws share: a motion to start from and a Runge-Kutta of their own, to do without the engine.
namespace lithe::test {

/// Order 4; `rate` of a state and a time since the start of the step.
template <class State, class Rate>
State runge_kutta(const Rate& rate, double h, const State& y) {
  const State k1 = rate(y, 0.0), k2 = rate(State(y + h / 2 * k1), h / 2), k3 = rate(State(y + h / 2 * k2), h / 2),
              k4 = rate(State(y + h * k3), h);
  return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
}

/// Surfaces at rest.
inline ContactMotion still(double gap) {
  const Vector3 none = Vector3::Zero();
  return {.gap = gap, .velocity = none, .spin = none, .slip = none, .bristle = none};
}

/// A law whose normal force is the depth: N newtons at gap -N.
inline const Compliance kPlain{.stiffness = 1, .exponent = 1};

}  // namespace lithe::test
