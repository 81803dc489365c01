#pragma once

#include <string>

#include "bodies/flexible/flexible_body.h"
#include "tests/support/scenes.h"

/// Scenes and measures for methods that keep what motion keeps.
namespace lithe::test {

/// A bar of rubber with four modes about a three-node frame, so that every term of f_v is at work.
FlexibleBody& add_bar(SystemGraph& graph, const Vector3& velocity, const Vector3& angular_velocity,
                      double deflection = 0);

/// That bar, hinged at its start, falls from the horizontal.
Scene flexible_pendulum();

/// A disc rolls on the plane, leaning and turning: rows on velocities alone.
Scene rolling_disc();

/// A double pendulum of boxes: its first hinge is driven, friction in the second is pressed by its own reaction.
Scene driven_with_friction();

struct Errors {
  double q = 0, v = 0, lambda = 0;
};

Errors difference(const State& a, const State& b);

void expect_order_two(const std::string& what, const Errors& coarse, const Errors& fine, double tolerance);

/// Mean, slope and largest deviation of energy over a run, J and J/s.
struct EnergyRecord {
  double slope, deviation;
};

EnergyRecord record_energy(Scene& scene, Integrator& method, double end, int samples);

/// Two bodies in free flight, held together at a point.
Scene free_pair();

/// Their linear and their angular momentum about the origin.
Vector6 momenta_of_pair(const Scene& scene);

}  // namespace lithe::test
