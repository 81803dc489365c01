// BDF on the group: orders in q, v and λ, automatic steps, the chart of the past, Newton's factor.
#include "integrators/lie_bdf.h"

#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/base/error.h"
#include "engine/motion/projection.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/spring_damper.h"
#include "tests/integrators/pendulum_errors.h"

namespace lithe::test::lie_bdf_test {
namespace {

TEST(LieBdfOrder, IsThatOfTheFormulaInPositionVelocityAndMultiplier) {
  for (int k = 1; k <= 5; ++k) {
    const double h = k < 3 ? 2.5e-3 : 1e-2;
    const auto errors = [&](double step) {
      return pendulum_errors(bdf_fixed(step, k), [&](int i) { return i * step; });
    };
    expect_order("BDF " + std::to_string(k), order(errors(2 * h), errors(h)), k, 0.15);
  }
}

TEST(LieBdfOrder, HoldsWithFlexibleBodiesRollingDrivesAndFriction) {
  struct Case {
    const char* name;
    Scene (*make)();
    double end, step;  // s; the step of order 3
  };
  for (const Case& c : {Case{"flexible pendulum", flexible_pendulum, 0.1, 1e-4},
                        {"rolling disc", rolling_disc, 0.3, 2e-3},
                        {"drive and friction", driven_with_friction, 0.3, 2e-3}}) {
    Scene exact = c.make();
    exact.run(*runge_kutta(1e-13), c.end);
    for (int k = 1; k <= 4; ++k) {  // nearer to k than to another order: a wrong coefficient lowers it by one at least
      // Of order 4 the error in q falls below 3e-11 m at the step of order 3, where 3e-12 m of it are round-off.
      const double h = k == 1 ? c.step / 8 : k == 2 ? c.step / 2 : k == 3 ? c.step : 1.5 * c.step;
      const auto errors = [&](double step) {
        Scene scene = c.make();
        scene.run(*bdf_fixed(step, k), c.end);
        return difference(scene.state, exact.state);
      };
      expect_order(std::string(c.name) + ", BDF " + std::to_string(k), order(errors(2 * h), errors(h)), k, 0.5);
    }
  }
}

TEST(LieBdfOrder, StaysWhenStepsAlternate) {
  // The coefficients are those of the points as they lie in time.
  for (int k = 1; k <= 3; ++k) {
    const auto errors = [&](double h) {
      return pendulum_errors(bdf_fixed(h, k), [&](int i) { return (i / 2) * 1.5 * h + (i % 2) * h; });
    };
    expect_order("BDF " + std::to_string(k) + ", steps h, h/2", order(errors(1e-2), errors(5e-3)), k, 0.35);
  }
}

TEST(LieBdfOrder, BearsASliverOfAStep) {
  const double h = 5e-3;
  const Errors plain = pendulum_errors(bdf_fixed(h, 3), [&](int i) { return i * h; });
  const Errors split = pendulum_errors(bdf_fixed(h, 3), [&](int i) { return (i / 2) * h + (i % 2) * 1e-6 * h; });
  expect_below("BDF 3, slivers of 5 ns between steps of 5 ms, error of q over that without", split.q / plain.q, 2);
  expect_below("BDF 3, slivers of 5 ns between steps of 5 ms, error of λ over that without",
               split.lambda / plain.lambda, 5);
}

TEST(LieBdf, ErrsInProportionToItsTolerance) {
  Scene exact = box_chain(3, true);
  exact.run(*runge_kutta(1e-13), 0.5);
  double last = 1e300;
  for (double tolerance : {1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10}) {
    Scene scene = box_chain(3, true);
    Method method = bdf(tolerance);
    scene.run(*method, 0.5);
    char text[16];
    std::snprintf(text, sizeof text, "%.0e", tolerance);
    const std::string name = std::string("tolerance ") + text + ", " + std::to_string(method->statistics().steps) +
                             " steps, " + std::to_string(method->statistics().rejected) + " rejected";
    const Errors error = difference(scene.state, exact.state);
    expect_below(name + ", error of q over tolerance", error.q / tolerance, 100);
    expect_below(name + ", error of λ over tolerance (relative)", error.lambda / exact.state.lambda.norm() / tolerance,
                 300);
    EXPECT_LT(error.q, 0.7 * last) << name << ": no better than at ten times the tolerance";
    EXPECT_GE(method->statistics().limiting, 0);
    last = error.q;
  }
}

TEST(LieBdf, LeavesAConsistentState) {
  Scene scene = box_chain(4, true);
  scene.run(*bdf(1e-8), 0.4);
  expect_below("|g|", scene.violation(Level::position), 1e-9);
  expect_below("|G v|", scene.violation(Level::velocity), 1e-8);
  VectorX v_dot = scene.state.v_dot, lambda = scene.state.lambda;
  Projector(scene.equations).accelerations(scene.state.time, scene.state.q, scene.state.v, v_dot, lambda);
  expect_below("accelerations (relative)", (v_dot - scene.state.v_dot).norm() / v_dot.norm(), 1e-5);
  expect_below("multipliers (relative)", (lambda - scene.state.lambda).norm() / lambda.norm(), 1e-5);
}

TEST(LieBdf, KeepsItsFactorOverSteps) {
  Scene scene = box_chain(16, true);
  Method method = bdf(1e-6);
  scene.run(*method, 0.3);
  const auto& s = method->statistics();
  expect_below("factors a step", static_cast<double>(s.factorizations) / static_cast<double>(s.steps), 0.6);
  expect_below("evaluations a step", static_cast<double>(s.evaluations) / static_cast<double>(s.steps), 3.6);
  EXPECT_EQ(s.newton_failures, 0);
}

TEST(LieBdf, TakesStiffDampersInStepsOfTheSlowMotion) {
  // Decay within 1 µs beside a swing of a second: an explicit method would need 1e6 steps.
  const auto make = [] {
    return Scene({0, -9.81, 0}, [](SystemGraph& graph) {
      auto& mass = graph.add<RigidBody>("mass", {.mass = 1, .inertia = {1, 1, 1}, .position = {1, 0, 0}});
      graph.add<SpringDamper>("rod", {graph.ground().marker(), mass.marker()},
                              {.stiffness = 1e8, .damping = 1e6, .natural_length = 1});
    });
  };
  Scene scene = make();
  Method method = bdf(1e-6);
  scene.run(*method, 1);
  const double angle = pendulum_angle(1);
  expect_below("position beside the rigid pendulum (m)",
               (scene.position(0) - Vector3(std::sin(angle), -std::cos(angle), 0)).norm(), 1e-4);
  expect_below("steps", static_cast<double>(method->statistics().steps), 250);
}

TEST(LieBdf, TellsFastTurnsApart) {
  // A chart of the past holds less than half a turn: steady spin would let steps outgrow it.
  const double spin = 200;
  Scene scene = free_body({1, 1, 2}, {0, 0, spin});
  scene.run(*bdf(1e-4), 1);
  const Vector4 expected(std::cos(spin / 2), 0, 0, std::sin(spin / 2));
  expect_below("attitude after 32 turns (rad)",
               2 * std::acos(std::min(1.0, std::abs(expected.dot(scene.state.q.segment<4>(3))))), 1e-6);
}

TEST(LieBdf, HitsStopTimesAndGivesTheSameAnswerSplit) {
  Scene whole = box_chain(3, true), split = box_chain(3, true);
  Method first = bdf(1e-8), second = bdf(1e-8);
  whole.run(*first, 0.5);
  for (double stop : {0.1, 0.1 + 1e-9, 0.20337, 0.5}) {
    split.run(*second, stop);
    EXPECT_EQ(split.state.time, stop);
  }
  const Errors between = difference(whole.state, split.state);
  expect_below("t_stop split, q", between.q, 5e-7);
  expect_below("t_stop split, λ (relative)", between.lambda / whole.state.lambda.norm(), 1e-5);
  // Many outputs, closer than the steps would be.
  Scene observed = box_chain(3, true);
  Method third = bdf(1e-8);
  for (int i = 1; i <= 500; ++i) observed.run(*third, i * 1e-3);
  expect_below("500 outputs, q", difference(whole.state, observed.state).q, 5e-7);
  expect_below("500 outputs, steps", static_cast<double>(third->statistics().steps), 700);
}

/// Pushes its marker with a force that ends in NaN after a while.
class BreakingForce final : public Force<1, 0> {
 public:
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override {
    rows.add_load(markers[0], force({0, time > 0.1 ? std::nan("") : 1.0, 0}));
  }
};

TEST(LieBdf, NamesTheCoordinateThatStopsIt) {
  Scene scene({0, 0, 0}, [](SystemGraph& graph) {
    auto& body = graph.add<RigidBody>("probe", {.mass = 2});
    graph.add<BreakingForce>("push", {body.marker()});
  });
  Method method = bdf(1e-6);
  method->start(scene.equations, scene.state);
  StepResult result;
  for (int i = 0; i < 1000 && result.ok() && scene.state.time < 1; ++i)
    result = method->step(scene.equations, scene.state, 1);
  EXPECT_FALSE(result.ok());
  EXPECT_LE(scene.state.time, 0.1);
  EXPECT_TRUE(scene.state.q.allFinite() && scene.state.v.allFinite());
  EXPECT_NE(result.why.find("probe: p_y"), std::string::npos) << result.why;
}

TEST(LieBdf, RefusesParametersOutOfRange) {
  EXPECT_THROW(LieBdf({.max_order = 6}), SceneError);
  EXPECT_THROW(LieBdf({.step = -1}), SceneError);
  EXPECT_THROW(LieBdf({.tolerance = {.relative = 1e-6, .absolute = 0}}), SceneError);
}

/// A mass flies 31 m, then a jet is lit at once. Steps up to there are a billion times shorter than before; in the
/// chart of where it began their d was round-off, v = d / h erred by more than its tolerance, and no step was short
/// enough.
TEST(LieBdfSteps, ShrinkAsFarAsAForceThatJumpsAsks) {
  constexpr double kSpeed = 10, kForce = 1e3, kEnd = 3.2;
  for (const double tolerance : {1e-6, 1e-8, 1e-9, 1e-10}) {
    Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
      const Matrix3 along = rotation_about({0, 1, 0}, M_PI / 2);  // z along x
      auto& body = graph.add<RigidBody>("body", {.mass = 1, .velocity = {kSpeed, 0, 0}});
      graph.add<CoordinateMotor>("jet",
                                 {displacement_between(graph.ground().marker({}, along), body.marker({}, along))},
                                 {.effort = [](double t, double, double) { return t < M_PI ? 0 : kForce; }});
    });
    scene.run(*bdf(tolerance), kEnd);
    EXPECT_NEAR(scene.state.v[0], kSpeed + kForce * (kEnd - M_PI), 300 * tolerance * kSpeed) << tolerance;
  }
}

}  // namespace
}  // namespace lithe::test::lie_bdf_test
