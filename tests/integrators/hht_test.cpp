// HHT-I3: its recurrence, orders on constraints, steps that change, what it damps.
#include "integrators/hht.h"

#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/base/error.h"
#include "joints/forces/spring_damper.h"
#include "tests/integrators/pendulum_errors.h"

namespace lithe::test::hht_test {
namespace {

TEST(Hht, FollowsTheRecurrenceOfHilberHughesAndTaylor) {
  // One mass on a spring, 0.1 m out: x, v, a of the scalar method, from a consistent start.
  const double h = 0.01, stiffness = 400;
  for (double alpha : {0.0, -0.1, -1.0 / 3}) {
    Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
      auto& mass = graph.add<RigidBody>("mass", {.mass = 1, .inertia = {1, 1, 1}, .position = {1.1, 0, 0}});
      graph.add<SpringDamper>("spring", {graph.ground().marker(), mass.marker()},
                              {.stiffness = stiffness, .natural_length = 1});
    });
    const double gamma = 0.5 - alpha, beta = 0.25 * (1 - alpha) * (1 - alpha);
    double x = 0.1, v = 0, a = -stiffness * x, worst = 0;
    Method method = hht(h, alpha);
    for (int i = 1; i <= 300; ++i) {
      // a' = -k ((1 + α) x' - α x),  x' = known + h² β a'
      const double known = x + h * v + h * h * (0.5 - beta) * a;
      const double next = -stiffness * ((1 + alpha) * known - alpha * x) / (1 + (1 + alpha) * stiffness * h * h * beta);
      x = known + h * h * beta * next;
      v += h * ((1 - gamma) * a + gamma * next);
      a = next;
      scene.run(*method, i * h);
      worst = std::max(worst, std::abs(scene.position(0).x() - 1 - x));
    }
    expect_below("alpha " + std::to_string(alpha) + ", x beside the recurrence (m)", worst, 1e-11);
  }
}

TEST(HhtOrder, IsTwoInPositionVelocityAndMultiplier) {
  for (double alpha : {-0.05, -0.1, -0.3}) {
    const auto errors = [&](double h) { return pendulum_errors(hht(h, alpha), [&](int i) { return i * h; }); };
    expect_order("pendulum, alpha " + std::to_string(alpha).substr(0, 5), order(errors(5e-3), errors(2.5e-3)), 2, 0.15);
  }
}

TEST(HhtOrder, IsTwoWithFlexibleBodiesRollingDrivesAndFriction) {
  struct Case {
    const char* name;
    Scene (*make)();
    double end, step;  // s
  };
  for (const Case& c : {Case{"flexible pendulum", flexible_pendulum, 0.1, 5e-5},
                        {"rolling disc", rolling_disc, 0.3, 1e-3},
                        {"drive and friction", driven_with_friction, 0.3, 1e-3}}) {
    Scene exact = c.make();
    exact.run(*runge_kutta(1e-12), c.end);
    const auto errors = [&](double h) {
      Scene scene = c.make();
      scene.run(*hht(h, -0.3), c.end);
      return difference(scene.state, exact.state);
    };
    expect_order(c.name, order(errors(2 * c.step), errors(c.step)), 2, 0.25);
  }
}

TEST(HhtOrder, StaysTwoWhenStepsAlternate) {
  // Stability laboratory S30: carried over unchanged, the acceleration-like state spoils λ to 17 N/m at 0.01 s.
  const auto errors = [&](double h) {
    return pendulum_errors(hht(h), [&](int i) { return (i / 2) * 1.5 * h + (i % 2) * h; });
  };
  const Errors coarse = errors(5e-3), fine = errors(2.5e-3);
  expect_order("steps h, h/2", order(coarse, fine), 2, 0.35);
  expect_below("error of λ at alternating steps of 5 ms and 2.5 ms (N/m)", coarse.lambda, 2e-2);
}

TEST(Hht, DampsWhatTheStepDoesNotResolveAndKeepsTheSwing) {
  // A pendulum on a stiff spring that starts stretched: the stretch dies out within some steps, the swing does not.
  const double h = 2e-3, stretch = 1e-4, stiffness = 1e8;
  const auto left = [&](double alpha) {
    Scene scene({0, -9.81, 0}, [&](SystemGraph& graph) {
      auto& mass = graph.add<RigidBody>("mass", {.mass = 1, .inertia = {1, 1, 1}, .position = {1 + stretch, 0, 0}});
      graph.add<SpringDamper>("rod", {graph.ground().marker(), mass.marker()},
                              {.stiffness = stiffness, .natural_length = 1});
    });
    Method method = hht(h, alpha);
    scene.run(*method, 0.2);
    double most = 0;
    for (int i = 0; i < 20; ++i) {
      scene.run(*method, 0.2 + i * h);
      most = std::max(most, std::abs(scene.position(0).norm() - 1) / stretch);
    }
    // What was in the stretch, 0.5 J, goes with it; the swing loses none of its 2.7 J.
    if (alpha < 0) {
      EXPECT_NEAR(scene.energy(), 0, 1e-3);
    }
    return most;
  };
  expect_below("share of the stretch after 100 steps, alpha -0.3", left(-0.3), 1e-2);
  EXPECT_GT(left(0), 0.5) << "the trapezoidal rule damps nothing";
}

TEST(Hht, MeetsItsToleranceAutomatically) {
  Scene exact = box_chain(3, true);
  exact.run(*runge_kutta(1e-13), 0.5);
  double last = 1e300;
  for (double tolerance : {1e-3, 1e-4, 1e-5, 1e-6}) {
    Scene scene = box_chain(3, true);
    Hht method({.tolerance = {.relative = tolerance, .absolute = tolerance}});
    scene.run(method, 0.5);
    const double error = (scene.state.q - exact.state.q).cwiseAbs().maxCoeff();
    expect_below(std::to_string(method.statistics().steps) + " steps, error over tolerance^(2/3)",
                 error / std::pow(tolerance, 2. / 3), 10);
    EXPECT_LT(error, 0.7 * last);
    last = error;
  }
}

TEST(Hht, RefusesParametersOutOfRange) {
  EXPECT_THROW(Hht({.alpha = 0.1}), SceneError);
  EXPECT_THROW(Hht({.alpha = -0.4}), SceneError);
  EXPECT_THROW(Hht({.step = -1}), SceneError);
}

}  // namespace
}  // namespace lithe::test::hht_test
