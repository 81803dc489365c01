#pragma once

#include <cmath>
#include <memory>

#include "bodies/rigid_body.h"
#include "joints/distance_joint.h"
#include "tools/stability/bench.h"

/// P of the published table: the Cartesian pendulum, a point mass of 1 kg on a rod of 1 m, released horizontally; in
/// the plane z = 0, gravity along -y, angle from the downward vertical. g = ½ (|p|² - 1); λ is the tension over 1 m.
namespace lithe::lab {

constexpr double kGravity = 9.81;  // m/s²

struct Angle {
  double value, rate;  // rad, rad/s
  Vector3 position() const { return {std::sin(value), -std::cos(value), 0}; }
  Vector3 velocity() const { return {rate * std::cos(value), rate * std::sin(value), 0}; }
  double multiplier() const { return rate * rate + kGravity * std::cos(value); }
};

/// The exact motion from 90 degrees at rest: classical Runge-Kutta on the angle with steps below 0.2 ms (1e-14).
inline Angle exact_angle(double time) {
  const int count = std::max(1, static_cast<int>(std::ceil(time / 2e-4)));
  const double h = time / count;
  double th = M_PI / 2, w = 0;
  const auto a = [](double angle) { return -kGravity * std::sin(angle); };
  for (int i = 0; i < count; ++i) {
    const double a1 = a(th), w2 = w + h / 2 * a1, a2 = a(th + h / 2 * w), w3 = w + h / 2 * a2, a3 = a(th + h / 2 * w2),
                 w4 = w + h * a3, a4 = a(th + h * w3);
    th += h / 6 * (w + 2 * w2 + 2 * w3 + w4);
    w += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return {th, w};
}

class Pendulum : public Bench {
 public:
  /// At the exact position, speed and time of the motion from rest.
  explicit Pendulum(double time = 0)
      : Bench({0, -kGravity, 0}, [](SystemGraph& graph) {
          auto& mass = graph.add<RigidBody>("mass", {.mass = 1, .inertia = {1, 1, 1}, .position = {1, 0, 0}});
          graph.add<DistanceJoint>("rod", {graph.ground().marker(), mass.marker()}, {.length = 1});
        }) {
    const Angle angle = exact_angle(time);
    state.time = time;
    state.q.head<3>() = angle.position();
    state.v.head<3>() = angle.velocity();
  }

  /// ||p| - 1|, m
  double stretch() const { return std::abs(state.q.head<3>().norm() - 1); }
  double multiplier_error() const { return std::abs(state.lambda[0] - exact_angle(state.time).multiplier()); }
  double position_error() const { return (state.q.head<3>() - exact_angle(state.time).position()).norm(); }
};

}  // namespace lithe::lab
