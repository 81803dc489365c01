// CVODE's Adams method behind projection.
#include <gtest/gtest.h>

#include <array>
#include <stdexcept>

#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/base/error.h"
#include "engine/motion/projection.h"
#include "integrators/adams.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/bushing.h"
#include "joints/forces/joint_friction.h"
#include "joints/revolute_joint.h"
#include "joints/rolling_disc.h"
#include "tests/integrators/smooth_scenes.h"

namespace lithe::test::adams_test {
namespace {

TEST(Adams, MeetsTheTolerance) {
  for (const SmoothScene& smooth : kSmoothScenes) {
    const auto exact = five_states(smooth, runge_kutta8(1e-14));
    for (double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
      const RunErrors errors = run_difference(five_states(smooth, adams(tolerance)), exact);
      const std::string name = "Adams, " + std::string(smooth.name) + ", tolerance " +
                               std::to_string(std::lround(std::log10(tolerance))) + ", ";
      expect_below(name + "q over it", errors.q / tolerance, 10);
      // The rubber's η may err by the tolerance in metres, and its stiff modes press on the pin.
      const double amplified = smooth.name == std::string("rubber pendulum") ? 1e5 : 1e3;
      expect_below(name + "λ (relative)", errors.lambda, amplified * tolerance);
    }
  }
}

TEST(Adams, ItsOrderIsWhatMakesItCheap) {
  long last = 1000000;
  for (int order : {1, 2, 4, 8}) {
    Scene scene = box_chain(4, true);
    Adams method({.tolerance = {1e-7, 1e-7}, .max_order = order});
    scene.run(method, order == 1 ? 0.01 : 0.25);
    const long evaluations = method.statistics().evaluations * (order == 1 ? 25 : 1);
    EXPECT_LT(evaluations, (order == 8 ? 0.8 : 0.5) * static_cast<double>(last)) << "order " << order;
    last = evaluations;
  }
}

TEST(Adams, HandsOutStatesThatAreConsistent) {
  for (const SmoothScene& smooth : kSmoothScenes) {
    Scene scene = smooth.make();
    Method method = adams(1e-6);
    method->start(scene.equations, scene.state);
    double violation = 0, acceleration = 0;
    VectorX v_dot = scene.state.v_dot, lambda = scene.state.lambda;
    while (scene.state.time < smooth.end) {
      ASSERT_TRUE(method->step(scene.equations, scene.state, smooth.end).ok());
      violation = std::max({violation, scene.violation(Level::position), scene.violation(Level::velocity)});
      Projector(scene.equations).accelerations(scene.state.time, scene.state.q, scene.state.v, v_dot, lambda);
      acceleration = std::max({acceleration, (v_dot - scene.state.v_dot).norm() / v_dot.norm(),
                               (lambda - scene.state.lambda).norm() / lambda.norm()});
    }
    expect_below("Adams, " + std::string(smooth.name) + ", |g| and |G v|", violation, 1e-12);
    expect_below("Adams, " + std::string(smooth.name) + ", v̇ and λ (relative)", acceleration, 1e-5);
  }
}

TEST(Adams, DenseOutputErrsNoMoreThanTheSteps) {
  for (const SmoothScene& smooth : kSmoothScenes) {
    const double tolerance = 1e-8;
    Scene scene = smooth.make(), exact = smooth.make();
    Method method = adams(tolerance), reference = runge_kutta8(1e-14);
    method->start(scene.equations, scene.state);
    State from, at;
    RunErrors worst{};
    double ends = 0, acceleration = 0;
    while (scene.state.time < smooth.end / 3) {
      from = scene.state;
      ASSERT_TRUE(method->step(scene.equations, scene.state, smooth.end).ok());
      for (const State* end : {&from, &scene.state}) {
        method->interpolate(scene.system.layout(), from, scene.state, end->time, at);
        ends = std::max({ends, (at.q - end->q).cwiseAbs().maxCoeff(), (at.v - end->v).cwiseAbs().maxCoeff()});
      }
      if (method->statistics().steps % 5 != 0) continue;
      method->interpolate(scene.system.layout(), from, scene.state, (from.time + scene.state.time) / 2, at);
      exact.run(*reference, at.time);
      const RunErrors here = run_difference(at, exact.state);
      worst = {std::max(worst.q, here.q), std::max(worst.v, here.v), std::max(worst.lambda, here.lambda)};
      acceleration = std::max(acceleration, (at.v_dot - exact.state.v_dot).norm() / exact.state.v_dot.norm());
    }
    const std::string name = "Adams, dense output, " + std::string(smooth.name);
    expect_below(name + ", at the ends of the step", ends, 10 * tolerance);
    expect_below(name + ", q within it, over the tolerance", worst.q / tolerance, 10);
    expect_below(name + ", v̇ within it (relative)", acceleration, 1e-3);
    expect_below(name + ", λ within it (relative)", worst.lambda, 1e-2);
  }
}

/// Two runs of a scene from the same consistent start.
void expect_agreement(const std::string& name, Scene (*make)(), double end, double tolerance) {
  Scene exact = make(), scene = make();
  for (Scene* s : {&exact, &scene}) Projector(s->equations).velocity(0, s->state.q, s->state.v);
  const VectorX start = exact.state.q;
  exact.run(*runge_kutta(1e-12), end);
  Method method = adams(tolerance);
  scene.run(*method, end);
  const RunErrors errors = run_difference(scene.state, exact.state);
  EXPECT_GT((start - exact.state.q).norm(), 0.1) << name;
  expect_below("Adams, " + name + ", q over the tolerance", errors.q / tolerance, 20);
  expect_below("Adams, " + name + ", λ (relative)", errors.lambda, 1e4 * tolerance);
  expect_below("Adams, " + name + ", |g| and |ġ|",
               std::max(scene.violation(Level::position), scene.violation(Level::velocity)), 1e-12);
}

TEST(Adams, RollsADiscOnRowsOfVelocities) {
  expect_agreement(
      "rolling disc",
      [] {
        return Scene({0, 0, -9.81}, [](SystemGraph& graph) {
          const Matrix3 axes = rotation_about({1, 0, 0}, 1.2);  // axle z, raised by 0.37 rad
          auto& disc = graph.add<RigidBody>("disc", {.mass = 1,
                                                     .inertia = {0.0025, 0.0025, 0.005},
                                                     .position = {0, 0, 0.1 * std::sin(1.2)},
                                                     .orientation = axes,
                                                     .velocity = {2, 0, 0},
                                                     .angular_velocity = {0, 0, -20}});
          graph.add<RollingDisc>("table", {graph.ground().marker(), disc.marker()}, {.radius = 0.1});
        });
      },
      0.5, 1e-8);
}

TEST(Adams, FollowsADriveAndBearsRedundantRows) {
  expect_agreement(
      "driven four-bar",
      [] {
        return Scene({0, -9.81, 0}, [](SystemGraph& graph) {
          const auto bar = [&](const std::string& name, const Vector3& center) -> RigidBody& {
            return graph.add<RigidBody>(name, {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = center});
          };
          auto &crank = bar("crank", {0, 0.25, 0}), &coupler = bar("coupler", {0.5, 0.75, 0}),
               &rocker = bar("rocker", {1, 0.5, 0});
          auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker(), crank.marker({0, -0.25, 0})});
          graph.add<RevoluteJoint>("first", {crank.marker({0, 0.25, 0}), coupler.marker({-0.5, -0.25, 0})});
          graph.add<RevoluteJoint>("second", {coupler.marker({0.5, 0.25, 0}), rocker.marker({0, 0.5, 0})});
          graph.add<RevoluteJoint>("pivot", {rocker.marker({0, -0.5, 0}), graph.ground().marker({1, 0, 0})});
          graph.add<CoordinateDrive>("motor", {pin.angle()}, {.motion = [](double t) {
                                       return Motion{0.5 * t * t, t, 1};
                                     }});
        });
      },
      1.0, 1e-8);
}

TEST(Adams, IteratesForcesThatKnowTheReactions) {
  expect_agreement(
      "pin with friction",
      [] {
        return Scene({0, -9.81, 0}, [](SystemGraph& graph) {
          auto& bob = graph.add<RigidBody>("bob", {.mass = 2, .inertia = {0.1, 0.1, 0.1}, .position = {1, 0, 0}});
          auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker(), bob.marker({-1, 0, 0})});
          graph.add<JointFriction>(
              "rub", {pin.angle()},
              {.joint = &pin, .coefficient = 0.3, .creep_speed = 0.3, .radius = 0.1, .bending_arm = 0.2});
        });
      },
      0.5, 1e-8);
}

TEST(Adams, KeepsEnergyAndConstraintsForAHundredSeconds) {
  Scene scene = mass_chain({M_PI / 3, M_PI / 3});
  const double start = scene.energy();
  Method method = adams(1e-8);
  double violation = 0;
  for (int second = 1; second <= 100; ++second) {
    scene.run(*method, second);
    violation = std::max({violation, scene.violation(Level::position), scene.violation(Level::velocity)});
  }
  const std::string name = "Adams, " + std::to_string(method->statistics().steps) + " steps, ";
  expect_below(name + "|g| and |G v|", violation, 1e-12);
  expect_below(name + "energy (J)", std::abs(scene.energy() - start), 1e-4);
}

TEST(Adams, HitsStopTimesWithoutSlivers) {
  Scene scene = box_chain(3, true), whole = box_chain(3, true);
  Method method = adams(1e-8), other = adams(1e-8);
  method->start(scene.equations, scene.state);
  for (int k = 1; k <= 50; ++k) {
    const double t_stop = 0.01 * k;
    while (scene.state.time < t_stop) {
      ASSERT_TRUE(method->step(scene.equations, scene.state, t_stop).ok());
      ASSERT_LE(scene.state.time, t_stop);
    }
    EXPECT_EQ(scene.state.time, t_stop);
  }
  whole.run(*other, 0.5);
  expect_below("Adams, fifty stops, difference", (scene.state.q - whole.state.q).norm(), 3e-7);
  EXPECT_LT(method->statistics().steps, 2 * other->statistics().steps);
}

/// Pushes until a time, and then gives no finite value, or throws.
class BrokenForce final : public Force<1, 0> {
 public:
  struct Parameters {
    bool throws = false;
  };
  explicit BrokenForce(Parameters parameters) : throws_(parameters.throws) {}
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override {
    if (time > 0.1 && throws_) throw std::runtime_error("the spring is broken");
    rows.add_load(markers[0], force({0, time > 0.1 ? std::nan("") : 1.0, 0}));
  }

 private:
  bool throws_;
};

TEST(Adams, FailureIsAResultInWords) {
  for (bool throws : {false, true}) {
    Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
      auto& body = graph.add<RigidBody>("probe", {.mass = 2});
      graph.add<BrokenForce>("push", {body.marker()}, {.throws = throws});
    });
    Method method = adams(1e-6);
    method->start(scene.equations, scene.state);
    StepResult result;
    for (int i = 0; i < 10000 && result.ok() && scene.state.time < 1; ++i)
      result = method->step(scene.equations, scene.state, 1);
    EXPECT_FALSE(result.ok());
    EXPECT_LE(scene.state.time, 0.1);
    EXPECT_TRUE(scene.state.q.allFinite() && scene.state.v.allFinite());
    EXPECT_NE(result.why.find(throws ? "the spring is broken" : "no finite"), std::string::npos) << result.why;
  }
}

TEST(Adams, TellsThatItsIterationFailsWhereASceneIsStiffAndWhatLimitsIt) {
  Scene scene({0, 0, -9.81}, [&](SystemGraph& graph) {
    auto& mass = graph.add<RigidBody>("mass", {.mass = 2, .inertia = {1, 1, 1}, .velocity = {1, 0, 0}});
    graph.add<Bushing>(
        "spring", {graph.ground().marker(), mass.marker()},
        {.stiffness = Bushing::diagonal({2e6, 0, 0}, {0, 0, 0}), .damping = Bushing::diagonal({8e4, 0, 0}, {0, 0, 0})});
  });
  Method method = adams(1e-5);
  scene.run(*method, 0.05);
  EXPECT_GT(method->statistics().newton_failures, 10);
  EXPECT_GT(method->statistics().steps, 0.05 * 39975 / 4);  // h |λ| stays near 1
  EXPECT_EQ(scene.system.layout().velocity_name(method->statistics().limiting), "mass: p_x");
  expect_below("Adams, a mass held by a strong damper, speed (m/s)", std::abs(scene.state.v[0]), 0.05);
}

TEST(Adams, RefusesParametersOutOfRange) {
  EXPECT_THROW(Adams({.tolerance = {.relative = 1e-6, .absolute = 0}}), SceneError);
  EXPECT_THROW(Adams({.first_step = -1}), SceneError);
  EXPECT_THROW(Adams({.max_order = 13}), SceneError);
  EXPECT_THROW(Adams({.max_order = 0}), SceneError);
}

}  // namespace
}  // namespace lithe::test::adams_test
