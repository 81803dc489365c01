// The default integrator: which method it chooses, and that the motion does not notice when it changes.
#include "integrators/automatic.h"

#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "integrators/radau.h"
#include "joints/distance_joint.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "tests/support/methods.h"
#include "tests/support/scenes.h"

namespace lithe::test::automatic_test {
namespace {

std::unique_ptr<Automatic> make(double tolerance) {
  return std::make_unique<Automatic>(
      Automatic::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
}

/// A pendulum of 1 m in air that is thick from 1 s to 2 s: damping of 1e5 N s/m instead of 0.1.
Scene thick_air() {
  return Scene({0, -9.81, 0}, [](SystemGraph& graph) {
    auto& bob = graph.add<RigidBody>("bob", {.mass = 1, .inertia = {1, 1, 1}, .position = {1, 0, 0}});
    graph.add<DistanceJoint>("rod", {graph.ground().marker(), bob.marker()}, {.length = 1});
    graph.add<UserForce>("air", {bob.marker()}, {[](double t, const MarkerView& m) {
                           const double part = std::clamp(std::min((t - 1) / 0.1, (2 - t) / 0.1), 0.0, 1.0);
                           const double thick = part * part * part * (10 - 15 * part + 6 * part * part);
                           return force(-(0.1 + 1e5 * thick) * m.v);
                         }});
  });
}

/// A mass on a damper of 1e5 N s/m and a soft spring, beside a pendulum.
Scene damped() {
  return Scene({0, -9.81, 0}, [](SystemGraph& graph) {
    auto& bob = graph.add<RigidBody>("bob", {.mass = 1, .inertia = {1, 1, 1}, .position = {1, 0, 0}});
    auto& mass = graph.add<RigidBody>("mass", {.mass = 1, .inertia = {1, 1, 1}, .position = {3, -1, 0}});
    graph.add<DistanceJoint>("rod", {graph.ground().marker(), bob.marker()}, {.length = 1});
    graph.add<SpringDamper>("damper", {graph.ground().marker({3, 0, 0}), mass.marker()},
                            {.stiffness = 1e5, .damping = 1e5, .natural_length = 1});
  });
}

TEST(Automatic, StaysExplicitWhereNothingIsStiff) {
  for (double tolerance : {1e-3, 1e-6, 1e-9}) {
    auto method = make(tolerance);
    Scene top = heavy_top(15, 1, 0.234375, 0.46875, {0, 150, -4.61538});
    top.run(*method, 1);
    EXPECT_EQ(method->method(), Automatic::Method::explicit_runge_kutta);
    EXPECT_EQ(method->switches(), 0);
  }
}

TEST(Automatic, TurnsImplicitWhereADamperIsStiff) {
  for (double tolerance : {1e-3, 1e-6, 1e-9}) {
    auto method = make(tolerance);
    Scene scene = damped(), exact = damped();
    scene.run(*method, 3);
    EXPECT_NE(method->method(), Automatic::Method::explicit_runge_kutta);
    exact.run(*radau(1e-11), 3);
    expect_below("automatic on a stiff damper, error over tolerance " + std::to_string(tolerance),
                 (scene.state.q - exact.state.q).cwiseAbs().maxCoeff() / tolerance, 10);
    // 1e5 1/s over 3 s: 8(5,3) alone would need some 5e4 steps.
    expect_below("its steps", static_cast<double>(method->statistics().steps), 3000);
  }
}

TEST(Automatic, GoesBothWaysWithTheStateCarriedOver) {
  for (double tolerance : {1e-4, 1e-6, 1e-8}) {
    auto method = make(tolerance);
    Scene scene = thick_air(), exact = thick_air();
    scene.run(*method, 0.9);
    EXPECT_EQ(method->method(), Automatic::Method::explicit_runge_kutta);
    scene.run(*method, 1.9);
    EXPECT_NE(method->method(), Automatic::Method::explicit_runge_kutta);
    scene.run(*method, 6);
    EXPECT_EQ(method->method(), Automatic::Method::explicit_runge_kutta);
    EXPECT_GE(method->switches(), 2);
    exact.run(*radau(1e-11), 6);
    expect_below("automatic through thick air, error over tolerance",
                 (scene.state.q - exact.state.q).cwiseAbs().maxCoeff() / tolerance, 10);
    expect_below("automatic through thick air, |g|", scene.violation(Level::position), 1e-9);
  }
}

TEST(Automatic, RepeatsBitForBit) {
  Scene one = thick_air(), two = thick_air();
  one.run(*make(1e-6), 3);
  two.run(*make(1e-6), 3);
  EXPECT_EQ(one.state.q, two.state.q);
  EXPECT_EQ(one.state.v, two.state.v);
}

TEST(Automatic, FollowsTheMotionBetweenItsStepsThroughChangesOfMethod) {
  Scene scene = thick_air(), exact = thick_air();
  auto method = make(1e-6);
  Method fine = radau(1e-10);
  method->start(scene.equations, scene.state);
  double worst = 0;
  while (scene.state.time < 2.5) {
    const State from = scene.state;
    ASSERT_TRUE(method->step(scene.equations, scene.state, 2.5).ok());
    State between;
    method->interpolate(scene.system.layout(), from, scene.state, 0.5 * (from.time + scene.state.time), between);
    exact.run(*fine, between.time);
    worst = std::max(worst, (between.q - exact.state.q).cwiseAbs().maxCoeff());
  }
  expect_below("automatic, error between steps", worst, 2e-5);
}

TEST(Automatic, SaysWhichMethodsFailedAndWhy) {
  Scene scene({0, 0, 0}, [](SystemGraph& graph) {
    auto& body = graph.add<RigidBody>("ship", {.mass = 1, .inertia = {1, 1, 1}});
    graph.add<UserForce>("hole", {body.marker()}, {[](double t, const MarkerView&) {
                           return force({t > 0.5 ? NAN : 1.0, 0, 0});
                         }});
  });
  Automatic method;
  method.start(scene.equations, scene.state);
  StepResult result;
  while (result.ok() && scene.state.time < 1) result = method.step(scene.equations, scene.state, 1);
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.why.find("explicit Runge-Kutta"), std::string::npos) << result.why;
  EXPECT_NE(result.why.find("Radau"), std::string::npos) << result.why;
  EXPECT_TRUE(scene.state.q.allFinite());
  EXPECT_NEAR(scene.state.time, 0.5, 1e-3);
}

}  // namespace
}  // namespace lithe::test::automatic_test
