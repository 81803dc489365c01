// Linearly implicit Euler for real time: its recurrence, orders, bounded cost, stiffness, no drift.
#include "integrators/linearly_implicit.h"

#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/base/error.h"
#include "joints/forces/spring_damper.h"
#include "tests/integrators/pendulum_errors.h"

namespace lithe::test::linearly_implicit_test {
namespace {

/// A mass of 1 kg on a rod of 1 m that is a spring, horizontal at rest.
Scene spring_pendulum(double stiffness, double damping, double stretch, double gravity) {
  return Scene({0, -gravity, 0}, [&](SystemGraph& graph) {
    auto& mass = graph.add<RigidBody>("mass", {.mass = 1, .inertia = {1, 1, 1}, .position = {1 + stretch, 0, 0}});
    graph.add<SpringDamper>("rod", {graph.ground().marker(), mass.marker()},
                            {.stiffness = stiffness, .damping = damping, .natural_length = 1});
  });
}

TEST(LinearlyImplicit, IsImplicitEulerOnASpringAtAnyStiffness) {
  const double h = 1e-3, damping = 3;
  for (double stiffness : {1e2, 1e6, 1e12}) {
    Scene scene = spring_pendulum(stiffness, damping, 0.1, 0);
    Method method = linearly_implicit(h);
    double x = 0.1, v = 0, worst = 0;
    for (int i = 1; i <= 100; ++i) {
      v = (v - h * stiffness * x) / (1 + h * damping + h * h * stiffness);
      x += h * v;
      scene.run(*method, i * h);
      worst = std::max(worst, std::abs(scene.position(0).x() - 1 - x));
    }
    expect_below("stiffness " + step_text(stiffness) + ", x beside implicit Euler (m)", worst, 1e-11);
  }
}

TEST(LinearlyImplicitOrder, IsOneOrTwoInPositionVelocityAndMultiplier) {
  for (int p : {1, 2}) {
    const auto errors = [&](double h) {
      return pendulum_errors(linearly_implicit(h, p), [&](int i) { return i * h; });
    };
    expect_order("pendulum, order " + std::to_string(p), order(errors(1e-3), errors(5e-4)), p, 0.15);
  }
}

TEST(LinearlyImplicitOrder, HoldsWithFlexibleBodiesRollingDrivesAndFriction) {
  struct Case {
    const char* name;
    Scene (*make)();
    double end, step;  // s
  };
  for (const Case& c : {Case{"flexible pendulum", flexible_pendulum, 0.1, 2.5e-5},
                        {"rolling disc", rolling_disc, 0.3, 2e-4},
                        {"drive and friction", driven_with_friction, 0.3, 2e-4}}) {
    Scene exact = c.make();
    exact.run(*runge_kutta(1e-12), c.end);
    for (int p : {1, 2}) {
      const auto errors = [&](double h) {
        Scene scene = c.make();
        scene.run(*linearly_implicit(h, p), c.end);
        return difference(scene.state, exact.state);
      };
      expect_order(std::string(c.name) + ", order " + std::to_string(p), order(errors(2 * c.step), errors(c.step)), p,
                   0.3);
    }
  }
}

TEST(LinearlyImplicit, CostsTheSameEveryStep) {
  for (int p : {1, 2}) {
    Scene scene = box_chain(4, true);
    Method method = linearly_implicit(1e-3, p);
    method->start(scene.equations, scene.state);
    for (int i = 1; i <= 500; ++i) {
      ASSERT_TRUE(method->step(scene.equations, scene.state, 0.5).ok());
      ASSERT_EQ(method->statistics().factorizations, (p == 1 ? 1 : 3) * i);
      ASSERT_EQ(method->statistics().evaluations, (p == 1 ? 1 : 5) * i);
    }
    EXPECT_EQ(scene.state.time, 0.5);
  }
}

TEST(LinearlyImplicit, IsStableWithStiffSpringsAndModesAtAMillisecond) {
  // Beside the rigid pendulum, which the stiff ones are near to: h ω is 1 and 10 here.
  const double angle = pendulum_angle(1);
  for (int p : {1, 2}) {
    const double bound = p == 1 ? 3e-2 : 5e-3;  // of stiff springs, order 2 falls to 1, with a small constant
    for (double stiffness : {1e6, 1e8}) {
      Scene scene = spring_pendulum(stiffness, 0, 0, 9.81);
      scene.run(*linearly_implicit(1e-3, p), 1);
      expect_below("order " + std::to_string(p) + ", rod of " + step_text(stiffness) + ": position (m)",
                   (scene.position(0) - Vector3(std::sin(angle), -std::cos(angle), 0)).norm(), bound);
    }
    // The bar of rubber, its modes from 90 rad/s on, started bent; a hundred times stiffer than a step resolves.
    Scene bar = flexible_pendulum();
    const double start = bar.energy();
    Method method = linearly_implicit(1e-2, p);
    for (int i = 1; i <= 200; ++i) {
      bar.run(*method, i * 1e-2);
      ASSERT_LT(bar.energy(), start + (p == 1 ? 1e-3 : 2e-2)) << "order " << p << ", step " << i;
    }
    expect_below("bar, |g| at 10 ms", bar.violation(Level::position), 1e-5);
  }
}

TEST(LinearlyImplicit, DoesNotDriftOverAMillionSteps) {
  for (int p : {1, 2}) {
    const long steps = p == 1 ? 1000000 : 100000;
    const double h = p == 1 ? 1e-4 : 1e-3;  // 100 s, in which order 1 loses a tenth of the energy
    Scene scene = mass_chain({M_PI / 2});
    const double start = scene.energy();
    Method method = linearly_implicit(h, p);
    double position = 0, velocity = 0, early = 0;
    for (int i = 1; i <= 1000; ++i) {
      scene.run(*method, 0.1 * i);
      position = std::max(position, scene.violation(Level::position));
      velocity = std::max(velocity, scene.violation(Level::velocity));
      if (i == 10) early = velocity;
    }
    const std::string name = "order " + std::to_string(p) + ", " + std::to_string(steps) + " steps: ";
    EXPECT_EQ(method->statistics().steps, steps);
    expect_below(name + "|g| (m)", position, 1e-12);
    expect_below(name + "|G v| (m/s)", velocity, 1e-5);
    expect_below(name + "|G v| over that of the first second", velocity / early, 1.5);
    expect_below(name + "energy lost (J)", start - scene.energy(), p == 1 ? 2 : 1e-2);
    EXPECT_GT(start - scene.energy(), 0);
  }
}

TEST(LinearlyImplicit, DampsAsItSays) {
  // Amplitude of a spring at h ω = 0.1: damping ratio h ω / 2 for order 1, of third order for order 2.
  const double omega = 100, h = 1e-3;
  const auto ratio = [&](int p) {
    Scene scene = spring_pendulum(omega * omega, 0, 0.1, 0);
    Method method = linearly_implicit(h, p);
    scene.run(*method, 0.2);
    return -std::log(scene.energy() / (0.5 * omega * omega * 0.01)) / 2 / (omega * 0.2);
  };
  EXPECT_NEAR(ratio(1) / (h * omega / 2), 1, 0.02);
  expect_below("damping ratio of order 2 over (h ω)³", ratio(2) / std::pow(h * omega, 3), 0.5);
  EXPECT_GT(ratio(2), 0);
}

/// Pushes its marker with a force that ends in NaN after a while.
class EndingForce final : public Force<1, 0> {
 public:
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override {
    rows.add_load(markers[0], force({0, time > 0.1 ? std::nan("") : 1.0, 0}));
  }
};

TEST(LinearlyImplicit, ReportsWhatIsNoNumber) {
  for (int p : {1, 2}) {
    Scene scene({0, 0, 0}, [](SystemGraph& graph) {
      auto& body = graph.add<RigidBody>("probe", {.mass = 2});
      graph.add<EndingForce>("push", {body.marker()});
    });
    Method method = linearly_implicit(1e-2, p);
    method->start(scene.equations, scene.state);
    StepResult result;
    for (int i = 0; i < 100 && result.ok(); ++i) result = method->step(scene.equations, scene.state, 1);
    EXPECT_FALSE(result.ok());
    EXPECT_LE(scene.state.time, 0.1 + 1e-9);
    EXPECT_TRUE(scene.state.q.allFinite() && scene.state.v.allFinite());
    EXPECT_NE(result.why.find("probe: p_y"), std::string::npos) << result.why;
  }
}

TEST(LinearlyImplicit, RefusesParametersOutOfRange) {
  EXPECT_THROW(LinearlyImplicit({.step = 0}), SceneError);
  EXPECT_THROW(LinearlyImplicit({.step = 1e-3, .order = 3}), SceneError);
}

}  // namespace
}  // namespace lithe::test::linearly_implicit_test
