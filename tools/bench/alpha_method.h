#pragma once

namespace lithe::bench {

/// The constants of generalized-alpha (GeneralizedAlpha in integrators/) for one fixed step, and its two moves, for a
/// small vector of whatever size: what the hand-written programs share with each other.
struct AlphaMethod {
  double step, am, af, gamma, beta;
  double acceleration_weight, velocity_weight;  // v̇ and v gain that much of a correction of the increment
  double mean_weight;                           // a gains that much of a correction of v̇

  AlphaMethod(double step, double rho) : step(step) {
    am = (2 * rho - 1) / (1 + rho);
    af = rho / (1 + rho);
    gamma = 0.5 + af - am;
    beta = (gamma + 0.5) * (gamma + 0.5) / 4;
    mean_weight = (1 - af) / (1 - am);
    velocity_weight = gamma / (beta * step);
    acceleration_weight = 1 / (mean_weight * beta * step * step);
  }

  /// Velocity and mean acceleration a over the step if v̇ stays; returns the increment of position.
  template <class Vector>
  Vector predict(Vector& velocity, const Vector& acceleration, Vector& mean) const {
    const Vector next = (af * acceleration - am * mean) / (1 - am) + mean_weight * acceleration;
    const Vector increment = step * (velocity + step * ((0.5 - beta) * mean + beta * next));
    velocity += step * ((1 - gamma) * mean + gamma * next);
    mean = next;
    return increment;
  }

  /// The same quantities after a correction of the increment.
  template <class Vector>
  void correct(const Vector& correction, Vector& velocity, Vector& acceleration, Vector& mean) const {
    velocity += velocity_weight * correction;
    acceleration += acceleration_weight * correction;
    mean += (mean_weight * acceleration_weight) * correction;
  }
};

}  // namespace lithe::bench
