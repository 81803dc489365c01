// Radau IIA: orders, the tolerance, stiff scenes, what makes Newton work.
#include "integrators/radau.h"

#include <gtest/gtest.h>

#include <array>

#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/base/error.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/spring_damper.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/rolling_disc.h"
#include "tests/bodies/flexible_models.h"
#include "tests/support/methods.h"
#include "tests/support/scenes.h"

namespace lithe::test::radau_test {
namespace {

struct Errors {
  double q = 0, v = 0, lambda = 0;
};
Errors errors(const State& state, const State& exact) {
  return {(state.q - exact.q).norm(), (state.v - exact.v).norm(), (state.lambda - exact.lambda).norm()};
}
void expect_order(const std::string& what, const Errors& coarse, const Errors& fine, double expected, double slack) {
  expect_below(what + ", order of q off by", std::abs(std::log2(coarse.q / fine.q) - expected), slack);
  expect_below(what + ", order of v off by", std::abs(std::log2(coarse.v / fine.v) - expected), slack);
  expect_below(what + ", order of λ off by", std::abs(std::log2(coarse.lambda / fine.lambda) - expected), slack);
}

/// State that `draw`n scene reaches at `end`.
template <class Draw>
State reached(Draw&& draw, Method method, double end) {
  Scene scene = draw();
  scene.run(*method, end);
  return scene.state;
}

// ---- order ----

TEST(RadauOrder, IsFiveInPositionVelocityAndMultiplier) {
  const auto pendulum = [] { return mass_chain({M_PI / 2}); };
  const State exact_pendulum = reached(pendulum, runge_kutta(1e-13), 0.6);
  expect_order("Radau, pendulum", errors(reached(pendulum, radau_fixed(2e-2), 0.6), exact_pendulum),
               errors(reached(pendulum, radau_fixed(1e-2), 0.6), exact_pendulum), 5, 0.5);
  const auto chain = [] { return box_chain(4, true); };
  const State exact_chain = reached(chain, runge_kutta(1e-13), 0.25);
  const Errors coarse = errors(reached(chain, radau_fixed(0.25 / 28), 0.25), exact_chain);
  const Errors fine = errors(reached(chain, radau_fixed(0.25 / 56), 0.25), exact_chain);
  expect_order("Radau, chain of revolute joints", coarse, fine, 5, 0.5);
  expect_below("Radau, chain at 4.5 ms, error of q", fine.q, 1e-10);
}

/// A rod on a hinge, let go horizontal with its first mode strained, so that it vibrates.
Scene flexible_pendulum(const FiniteElementModel& model) {
  return Scene({0, 0, -9.81}, [&](SystemGraph& graph) {
    FlexibleBody::Parameters parameters{.basis = make_basis(model, frame_of(model, "hinge"), 2)};
    parameters.modal_coordinates = VectorX::Zero(2);
    parameters.modal_coordinates[0] = 1e-3;
    auto& rod = graph.add<FlexibleBody>("rod", parameters);
    const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
    graph.add<RevoluteJoint>(
        "hinge", {graph.ground().marker({0, 0.005, 0}, along_y), rod.average(model.node_set("hinge"), along_y)});
  });
}

TEST(RadauOrder, IsFiveOnAFlexiblePendulumThatVibrates) {
  const FiniteElementModel model = pendulum_model("hex8i");
  const auto draw = [&] { return flexible_pendulum(model); };
  const double end = 0.5;
  const State exact = reached(draw, runge_kutta(1e-13), end);
  const Errors coarse = errors(reached(draw, radau_fixed(end / 40), end), exact);
  const Errors fine = errors(reached(draw, radau_fixed(end / 80), end), exact);
  expect_order("Radau, flexible pendulum", coarse, fine, 5, 0.6);
  EXPECT_GT(std::abs(exact.q.tail(2)[0]), 1e-6);
}

TEST(RadauOrder, IsFiveForAFreeBodyInTheChart) {
  const auto body = [] { return free_body({1, 2, 3}, {0.4, 1, 0.3}); };
  const State exact = reached(body, runge_kutta(1e-14), 2);
  const Errors coarse = errors(reached(body, radau_fixed(0.2), 2), exact);
  const Errors fine = errors(reached(body, radau_fixed(0.1), 2), exact);
  expect_below("Radau, free body, order of q off by", std::abs(std::log2(coarse.q / fine.q) - 5), 0.4);
  expect_below("Radau, free body, order of v off by", std::abs(std::log2(coarse.v / fine.v) - 5), 0.4);
}

TEST(RadauOrder, HoldsForRowsOnVelocitiesAloneAndForRedundantRows) {
  // A disc rolls in a curve, tilting; a link hangs on the same pin twice.
  const auto disc = [] {
    const Vector3 omega(0.5, 6, 0.8), p(0, 0, 0.3);
    return Scene({0, 0, -9.81}, [&](SystemGraph& graph) {
      auto& body = graph.add<RigidBody>("disc", {.mass = 2,
                                                 .inertia = {0.05, 0.1, 0.05},
                                                 .position = p,
                                                 .velocity = omega.cross(p),
                                                 .angular_velocity = omega});
      const Matrix3 axle = rotation_about({1, 0, 0}, -M_PI / 2);
      graph.add<RollingDisc>("contact", {graph.ground().marker(), body.marker({0, 0, 0}, axle)}, {.radius = 0.3});
    });
  };
  const auto twice = [] {
    return Scene({0, 0, -9.81}, [](SystemGraph& graph) {
      auto& link = graph.add<RigidBody>("link", {.mass = 1, .inertia = {0.1, 0.2, 0.3}, .position = {0.5, 0, 0}});
      const Matrix3 axes = rotation_about({1, 0, 0}, -M_PI / 2);
      for (const char* name : {"pin", "same pin"})
        graph.add<RevoluteJoint>(name, {graph.ground().marker({0, 0, 0}, axes), link.marker({-0.5, 0, 0}, axes)});
    });
  };
  const auto check = [](const std::string& name, const auto& draw) {
    const State exact = reached(draw, runge_kutta(1e-13), 0.4);
    const Errors coarse = errors(reached(draw, radau_fixed(2e-2), 0.4), exact);
    const Errors fine = errors(reached(draw, radau_fixed(1e-2), 0.4), exact);
    expect_below("Radau, " + name + ", order of q off by", std::abs(std::log2(coarse.q / fine.q) - 5), 0.7);
    expect_below("Radau, " + name + ", order of v off by", std::abs(std::log2(coarse.v / fine.v) - 5), 0.7);
    expect_below("Radau, " + name + ", error of q", fine.q, 1e-7);
  };
  check("rolling disc", disc);
  check("link on two pins in one place", twice);
}

// ---- automatic steps ----

TEST(RadauStep, KeepsTheErrorBelowTheToleranceFromAThousandthToRoundOff) {
  const auto chain = [] { return box_chain(4, true); };
  const State exact = reached(chain, runge_kutta(1e-13), 0.5);
  for (double tolerance = 1e-3; tolerance > 5e-12; tolerance /= 10) {
    Scene scene = chain();
    const Method method = radau(tolerance);
    scene.run(*method, 0.5);
    const std::string name =
        "Radau, tolerance " + step_text(tolerance) + " (" + std::to_string(method->statistics().steps) + " steps)";
    expect_below(name + ", error of q over tolerance", (scene.state.q - exact.q).cwiseAbs().maxCoeff() / tolerance, 10);
    expect_below(name + ", error of v over tolerance", (scene.state.v - exact.v).cwiseAbs().maxCoeff() / tolerance,
                 100);
    EXPECT_LT(method->statistics().rejected, 1 + method->statistics().steps / 4);
  }
}

TEST(RadauStep, EndsConsistentAndHitsTheStopTime) {
  const Method method = radau(1e-6), fixed = radau_fixed(3e-3);
  for (Integrator* of : {method.get(), fixed.get()}) {
    Scene scene = box_chain(4, true);
    of->start(scene.equations, scene.state);
    for (double t_stop : {0.1, 0.1 + 1e-7, 1.0 / 3}) {
      while (scene.state.time < t_stop) {
        ASSERT_TRUE(of->step(scene.equations, scene.state, t_stop).ok());
        EXPECT_LE(scene.state.time, t_stop);
      }
      EXPECT_EQ(scene.state.time, t_stop);
    }
    expect_below(of->name() + ", |g|", scene.violation(Level::position), 1e-9);
    expect_below(of->name() + ", |G v|", scene.violation(Level::velocity), 1e-6);
    VectorX v_dot = scene.state.v_dot, lambda = scene.state.lambda;
    Projector(scene.equations).accelerations(scene.state.time, scene.state.q, scene.state.v, v_dot, lambda);
    expect_below("accelerations, relative", (v_dot - scene.state.v_dot).norm() / v_dot.norm(), 1e-12);
    expect_below("multipliers, relative", (lambda - scene.state.lambda).norm() / lambda.norm(), 1e-12);
  }
}

TEST(RadauStep, SplitInTwoGivesTheSameAnswer) {
  const auto chain = [] { return box_chain(3, true); };
  Scene split = chain();
  const Method method = radau(1e-9);
  split.run(*method, 0.20337);
  split.run(*method, 0.5);
  const State whole = reached(chain, radau(1e-9), 0.5);
  expect_below("Radau, t_stop split, q", (whole.q - split.state.q).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(RadauStep, NamesWhatLimitsIt) {
  // Of two free bodies the second turns fast about its middle axis.
  Scene scene({0, 0, 0}, [](SystemGraph& graph) {
    graph.add<RigidBody>("rest", {.mass = 1});
    graph.add<RigidBody>("top", {.mass = 1, .inertia = {1, 2, 3}, .angular_velocity = {0.1, 10, 0}});
  });
  const Method method = radau(1e-8);
  scene.run(*method, 1);
  ASSERT_GE(method->statistics().limiting, 0);
  EXPECT_EQ(scene.system.layout().velocity_name(method->statistics().limiting).substr(0, 4), "top:");
}

// ---- stiffness ----

/// Two masses hang on springs, one of 1 rad/s and one of `omega` rad/s with critical damping, under their weight.
Scene stiff_springs(double omega) {
  return Scene({0, 0, -9.81}, [omega](SystemGraph& graph) {
    Marker last = graph.ground().marker();
    double z = 0;
    for (double frequency : {1.0, omega}) {
      z -= 1;
      auto& mass = graph.add<RigidBody>("mass " + std::to_string(frequency), {.mass = 1, .position = {0, 0, z}});
      graph.add<SpringDamper>(
          "spring " + std::to_string(frequency), {last, mass.marker()},
          {.stiffness = frequency * frequency, .damping = frequency > 1 ? 2 * frequency : 0, .natural_length = 1});
      last = mass.marker();
    }
  });
}

TEST(RadauStiffness, TakesStepsByTheMotionNotByTheStiffestSpring) {
  // Both masses move as one, of 2 kg, on the soft spring: z = -1 - 2 g (1 - cos(t/√2)); the stiff spring carries the
  // lower one. A frequency of 1e6 rad/s would bind an explicit method to some 3e6 steps.
  Scene scene = stiff_springs(1e6);
  const Method method = radau(1e-7);
  scene.run(*method, 3);
  const double exact = -1 - 2 * 9.81 * (1 - std::cos(3 / std::sqrt(2.0)));
  expect_below("Radau, masses on springs of 1 and 1e6 rad/s, z (m)", std::abs(scene.position(0).z() - exact), 1e-5);
  expect_below("the stiff spring's length (m)", std::abs(scene.position(0).z() - scene.position(1).z() - 1), 1e-9);
  expect_below("steps", static_cast<double>(method->statistics().steps), 200);
}

TEST(RadauStiffness, DampsWhatItDoesNotResolve) {
  // L-stable: a fixed step of 500 periods of the stiff mode leaves nothing of its start.
  Scene scene = stiff_springs(1e6);
  scene.state.v[8] += 1;  // the lower mass is pushed
  const Method method = std::make_unique<Radau>(Radau::Parameters{.step = 1e-3});
  scene.run(*method, 0.02);
  expect_below("relative speed of the stiff pair (m/s)", std::abs(scene.state.v[8] - scene.state.v[2]), 1e-4);
}

TEST(RadauStiffness, BearsDryFrictionThatKnowsTheReaction) {
  // A block slides up a slope and slows by g (μ cos α + sin α).
  const double mu = 0.3, slope = 0.2, end = 0.3, v0 = -2;
  const Matrix3 along = rotation_about({0, 1, 0}, M_PI / 2 + slope);
  Scene scene({0, 0, -9.81}, [&](SystemGraph& graph) {
    auto& block = graph.add<RigidBody>("block", {.mass = 3, .velocity = v0 * along.col(2)});
    auto& slide = graph.add<PrismaticJoint>("slide", {graph.ground().marker({}, along), block.marker({}, along)});
    graph.add<JointFriction>("rub", {slide.displacement()}, {.joint = &slide, .coefficient = mu});
  });
  scene.run(*radau(1e-9), end);
  const double a = 9.81 * (std::sin(slope) + mu * std::cos(slope)), gone = v0 * end + 0.5 * a * end * end;
  expect_below("block on a slope with friction, m", std::abs(scene.position(0).dot(along.col(2)) - gone), 1e-8);
}

/// Newton's corrections shrink ever faster here, by 1e-2 and then by 1e-9: the first correction of a step was taken for
/// the last one by the second rate of the step before, and velocities were off by 1.3e-5.
TEST(RadauStep, TakesNoFirstCorrectionByARateThatOnlyLaterOnesHave) {
  constexpr double kAmplitude = 0.3, kRate = 10;  // rad, rad/s
  const Matrix3 axes = rotation_about(Vector3(1, 2, 3).normalized(), 0.8);
  const Vector3 arm(0.4, 0.1, 0.2);
  Scene scene({0, 0, -9.81}, [&](SystemGraph& graph) {
    auto& lever = graph.add<RigidBody>("lever", {.mass = 2, .inertia = {0.03, 0.02, 0.01}, .position = arm});
    auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, axes), lever.marker(-arm, axes)});
    graph.add<CoordinateDrive>("drive", {pin.angle()}, {.motion = harmonic(kAmplitude, kRate)});
  });
  const Method method = radau(1e-9);
  double worst = 0;
  for (int k = 1; k <= 6; ++k) {
    scene.run(*method, 0.1 * k);
    const double angle = kAmplitude * std::sin(kRate * scene.state.time),
                 speed = kAmplitude * kRate * std::cos(kRate * scene.state.time);
    const Vector3 exact = speed * axes.col(2).cross(rotation_about(axes.col(2), angle) * arm);
    worst = std::max(worst, (scene.state.v.head<3>() - exact).norm());
  }
  expect_below("velocity of a driven lever, m/s", worst, 1e-9);
}

// ---- trouble ----

TEST(RadauStep, TakesNoSecondCorrectionByARateFromFarOff) {
  // A light mass on a stiff spring, in a step of seventy periods: the first correction of Newton is of 1e5 m, the
  // second of centimetres, and their ratio no rate. What the step leaves must be no more than Newton may leave.
  Scene scene({0, 0, -9.81}, [](SystemGraph& graph) {
    auto& mass = graph.add<RigidBody>("mass", {.mass = 0.047714549525426385,
                                               .inertia = {0.01, 0.01, 0.01},
                                               .position = {0.92983888226153799, 0, 0},
                                               .velocity = {2.4468307160681144, 0, 0}});
    graph.add<SpringDamper>("spring", {graph.ground().marker(), mass.marker()},
                            {.stiffness = 59258.494338215118, .damping = 2.2662435949235453, .natural_length = 1});
  });
  Evaluator equations(scene.system), again(scene.system);
  State state = scene.state;
  again.evaluate(0, state.q, state.v, Level::acceleration);
  Radau radau({.step = 0.065550323316806922});
  radau.start(equations, state);
  for (const double end : {0.049789197126977207, 0.12243892850227989})
    while (state.time < end) {
      const State from = state;
      ASSERT_TRUE(radau.step(equations, state, end, Multipliers::later).ok());
      const auto record = radau.step_record();
      const auto repeated = radau.repeated_step(again);  // to round-off, from where this one ended
      State to = state;
      MatrixX history = repeated->history(from, record.get());
      repeated->take(from, record.get(), history, to);
      EXPECT_LT((state.q - to.q).lpNorm<Eigen::Infinity>(), 1e-7) << state.time;
    }
}

TEST(RadauStep, SplitsAFixedStepThatDoesNotConverge) {
  // A fast top at a fifth of a turn a step.
  const auto top = [] { return heavy_top(15, 1, 0.234375, 0.46875, {0, 150, -4.61538}); };
  const State exact = reached(top, runge_kutta(1e-12), 0.1);
  Scene scene = top();
  const Method method = radau_fixed(1e-2);
  scene.run(*method, 0.1);
  EXPECT_GT(method->statistics().newton_failures, 0);
  EXPECT_EQ(method->statistics().newton_failures, method->statistics().rejected);
  expect_below("fast top, steps of 10 ms split, q", (scene.state.q - exact.q).norm(), 1e-5);
}

/// Pushes its marker with a force that ends in NaN after a while.
class BrokenForce final : public Force<1, 0> {
 public:
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override {
    rows.add_load(markers[0], force({0, time > 0.1 ? std::nan("") : 1.0, 0}));
  }
};

TEST(RadauStep, FailsWithANameNotWithNumbersThatAreNone) {
  for (const Method& method : std::array<Method, 2>{radau(1e-6), radau_fixed(1e-2)}) {
    Scene scene({0, 0, 0}, [](SystemGraph& graph) {
      auto& body = graph.add<RigidBody>("probe", {.mass = 2});
      graph.add<BrokenForce>("push", {body.marker()});
    });
    method->start(scene.equations, scene.state);
    StepResult result;
    for (int i = 0; i < 10000 && result.ok() && scene.state.time < 1; ++i)
      result = method->step(scene.equations, scene.state, 1);
    EXPECT_FALSE(result.ok());
    EXPECT_LE(scene.state.time, 0.1);
    EXPECT_TRUE(scene.state.q.allFinite() && scene.state.v.allFinite());
    EXPECT_NE(result.why.find("probe: "), std::string::npos) << result.why;
  }
}

TEST(RadauStep, RefusesParametersOutOfRange) {
  EXPECT_THROW(Radau({.step = -1}), SceneError);
  EXPECT_THROW(Radau({.tolerance = {.relative = 1e-6, .absolute = 0}}), SceneError);
  EXPECT_THROW(Radau({.newton_tolerance = -1}), SceneError);
}

}  // namespace
}  // namespace lithe::test::radau_test
