// Events on reactions, which the equations tell at every state of the dense output, at the times of a closed form.
#include <gtest/gtest.h>

#include <cmath>

#include "bodies/rigid_body.h"
#include "engine/run/simulation.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/lie_bdf.h"
#include "integrators/radau.h"
#include "joints/distance_joint.h"

namespace lithe::test::event_reactions_test {
namespace {

constexpr double kGravity = 9.81, kLength = 1.0, kMass = 2.0;
constexpr double kReleased = 1.2, kAt = 0.5;  // rad

/// From rest at kReleased to kAt: sin(θ/2) = k sin φ, t = √(L/g) (K(k) - F(k, φ)).
double time_to(double angle) {
  const double k = std::sin(kReleased / 2), phi = std::asin(std::sin(angle / 2) / k);
  return std::sqrt(kLength / kGravity) * (std::comp_ellint_1(k) - std::ellint_1(k, phi));
}

/// Largest error of the times at which the rod's tension, m g (3 cos θ - 2 cos θ₀), passes its value at ±kAt in the
/// first three swings.
double worst_time(Integrator& method) {
  SystemGraph graph{{.gravity = {0, -kGravity, 0}}};
  auto& bob =
      graph.add<RigidBody>("bob", {.mass = kMass,
                                   .inertia = {0.01, 0.01, 0.01},
                                   .position = {kLength * std::sin(kReleased), -kLength * std::cos(kReleased), 0}});
  auto& rod = graph.add<DistanceJoint>("rod", {graph.ground().marker(), bob.marker()});
  const System system = assemble(graph);
  State state = system.initial_state();
  Simulation simulation{system, method};
  const Sensor load = reaction(rod, 1);
  simulation.on({.name = "tension",
                 .function =
                     [load](Snapshot& now) {
                       Vector6 wrench;
                       load.evaluate(now, {wrench.data(), 6});
                       return wrench.head<3>().norm();
                     },
                 .level = kMass * kGravity * (3 * std::cos(kAt) - 2 * std::cos(kReleased))});
  const double first = time_to(kAt), half = 2 * time_to(0);
  simulation.run(state, 3 * half);
  EXPECT_EQ(simulation.events().size(), 6u);
  double worst = 0;
  for (std::size_t i = 0; i < simulation.events().size(); ++i) {
    const double exact = static_cast<double>(i / 2) * half + (i % 2 ? half - first : first);
    worst = std::max(worst, std::abs(simulation.events()[i].time - exact));
  }
  std::printf("%s: %.2e s\n", method.name().c_str(), worst);
  return worst;
}

TEST(EventReactions, PassTheirLevelsAtTheTimesOfTheClosedForm) {
  const Tolerance tight{.relative = 1e-11, .absolute = 1e-11};
  ExplicitRungeKutta explicit_8({.method = ExplicitRungeKutta::Method::dormand_prince8, .tolerance = tight});
  Radau radau({.tolerance = tight});
  LieBdf bdf({.tolerance = tight});
  EXPECT_LT(worst_time(explicit_8), 1e-8);
  EXPECT_LT(worst_time(radau), 1e-8);
  EXPECT_LT(worst_time(bdf), 1e-8);
}

}  // namespace
}  // namespace lithe::test::event_reactions_test
