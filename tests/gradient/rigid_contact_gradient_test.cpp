// Derivatives of the steps of Moreau-Jean, with the same points open, sticking and sliding, forwards and backwards.
#include "bodies/rigid_body.h"
#include "engine/observe/contact_sensors.h"
#include "integrators/generalized_alpha.h"
#include "integrators/moreau_jean.h"
#include "joints/contact/contact.h"
#include "joints/distance_joint.h"
#include "joints/forces/point_force.h"
#include "tests/gradient/gradient_support.h"

namespace lithe::test {
namespace {

constexpr double kRigidGravity = 9.81;
using Mode = GradientOptions::Mode;

/// Impulses to round-off, so that differences of runs are as good as they can be.
MakeIntegrator moreau_jean(double step) {
  return [=] {
    return std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = step, .contact = {.tolerance = 1e-14}});
  };
}

/// One body on the plane z = 0.
ParametricScene on_a_plane(const char* name, double duration, double step,
                           std::function<std::vector<Sensor>(SystemGraph&, const SweepPoint&)> draw) {
  return {.name = name,
          .duration = duration,
          .gravity = {0, 0, -kRigidGravity},
          .draw = std::move(draw),
          .integrator = moreau_jean(step)};
}

std::vector<Sensor> touch_plane(SystemGraph& graph, RigidBody& body, Shape shape, double friction, double restitution) {
  auto& contact =
      graph.add<Contact>("contact", {{graph.ground().marker(), shape::half_space()}, {body.marker(), std::move(shape)}},
                         {.law = RigidSurfaces{.restitution = restitution}, .friction = {.coefficient = friction}});
  return {position(body.marker(), "p"), velocity(body.marker(), "v"), contact_force(contact, 1, "load")};
}

RigidBody& ball(SystemGraph& graph, const SweepPoint& p, double radius, const Vector3& position, const Vector3& speed) {
  const double J = 0.4 * p["mass"] * radius * radius;
  return graph.add<RigidBody>("ball",
                              {.mass = p["mass"], .inertia = {J, J, J}, .position = position, .velocity = speed});
}

/// Tangent and adjoint against a closed form.
void expect_closed_form(const char* name, const ParametricScene& scene, const std::vector<Quantity>& quantities,
                        const std::vector<DesignParameter>& parameters, const MatrixX& expected, double tolerance) {
  for (const Mode mode : {Mode::tangent, Mode::adjoint}) {
    const Gradient found = gradient(scene, quantities, parameters, {.mode = mode});
    const double off = (found.derivatives - expected).lpNorm<Eigen::Infinity>();
    EXPECT_LE(off, tolerance) << found.derivatives << "\nexpected\n" << expected;
    if (std::getenv("LITHE_SHOW_ERRORS")) std::printf("%s: off %.1e\n", name, off);
  }
}

/// The largest difference of tangent and adjoint, in units of the parameters.
double apart(const ParametricScene& scene, const std::vector<Quantity>& quantities,
             const std::vector<DesignParameter>& parameters) {
  MatrixX off = gradient(scene, quantities, parameters, {.mode = Mode::tangent}).derivatives -
                gradient(scene, quantities, parameters, {.mode = Mode::adjoint}).derivatives;
  for (std::size_t k = 0; k < parameters.size(); ++k) off.col(static_cast<Eigen::Index>(k)) *= parameters[k].value;
  if (std::getenv("LITHE_SHOW_ERRORS"))
    std::printf("%s: tangent and adjoint apart by %.1e\n", scene.name.c_str(), off.lpNorm<Eigen::Infinity>());
  return off.lpNorm<Eigen::Infinity>();
}

/// A block that slides along x.
ParametricScene sliding_block(double duration) {
  return on_a_plane("sliding block", duration, 5e-3, [](SystemGraph& graph, const SweepPoint& p) {
    const double m = p["mass"];
    auto& block = graph.add<RigidBody>("block", {.mass = m,
                                                 .inertia = {0.01 * m, 0.02 * m, 0.02 * m},
                                                 .position = {0, 0, 0.05},
                                                 .velocity = {p["speed"], 0, 0}});
    return touch_plane(graph, block, shape::box({0.4, 0.3, 0.1}), p["friction"], 0);
  });
}
const std::vector<DesignParameter> kBlockNumbers{{"speed", 2}, {"friction", 0.3}, {"mass", 1.5}};

/// It stops after v²/(2 μ g): steps do so to 3e-8 m, a saw-tooth over where in a step it stops, whose slope is 1e-4.
TEST(RigidContactGradients, OfABlockThatSlidesToRest) {
  const double way = 2 / (0.3 * kRigidGravity);
  EXPECT_NEAR(gradient(sliding_block(0.8), {value_at("p_x", 0.8)}, kBlockNumbers).values[0], way, 1e-7);
  MatrixX expected(2, 3);
  expected << way, -way / 0.3, 0, 0, 0, 0;
  expect_closed_form("block", sliding_block(0.8), {value_at("p_x", 0.8), value_at("v_x", 0.8)}, kBlockNumbers, expected,
                     1e-3);
  expect_of_near_runs(sliding_block(0.8), {value_at("p_x", 0.8)}, kBlockNumbers, 1e-8);
  expect_of_near_runs(sliding_block(0.3), {value_at("p_x", 0.3), integral("v_x")}, kBlockNumbers, 1e-8);
}

/// Two bounces: z of the run, whose impacts are at their times, is that of the motion.
TEST(RigidContactGradients, OfABallThatBounces) {
  const ParametricScene scene = on_a_plane("bouncing ball", 1.2, 8e-3, [](SystemGraph& graph, const SweepPoint& p) {
    auto& body = ball(graph, p, 0.1, {0, 0, 0.1 + p["height"]}, {p["speed"], 0, 0});
    return touch_plane(graph, body, shape::sphere(0.1), 0, p["restitution"]);
  });
  const double height = 0.5, e = 0.8, g = kRigidGravity, T = 1.2;
  // z(T) of the second arc: v₂ t - g t²/2 with t = T - t₀ (1 + 2 e), t₀ = sqrt(2 height/g), v₂ = e² g t₀.
  const double t0 = std::sqrt(2 * height / g), t = T - t0 * (1 + 2 * e), t0_height = 1 / (g * t0);
  const auto slope = [&](double dt0, double de) {
    const double dt = -dt0 * (1 + 2 * e) - 2 * t0 * de, dv = 2 * e * de * g * t0 + e * e * g * dt0;
    return dv * t + (e * e * g * t0 - g * t) * dt;
  };
  MatrixX expected(2, 4);
  expected << slope(t0_height, 0), slope(0, 1), 0, 0, 0, 0, T, 0;
  expect_closed_form("bounces", scene, {value_at("p_z", T), value_at("p_x", T)},
                     {{"height", height}, {"restitution", e}, {"speed", 0.3}, {"mass", 2}}, expected, 1e-10);
}

/// A ball thrown along the plane slides, then rolls: x(T) = 5/7 v T + 2 v²/(49 μ g).
TEST(RigidContactGradients, OfABallThatSlidesAndRolls) {
  const ParametricScene scene = on_a_plane("rolling ball", 1, 4e-3, [](SystemGraph& graph, const SweepPoint& p) {
    auto& body = ball(graph, p, 0.1, {0, 0, 0.1}, {p["speed"], 0, 0});
    return touch_plane(graph, body, shape::sphere(0.1), p["friction"], 0);
  });
  const double v = 2, mu = 0.2, g = kRigidGravity;
  MatrixX expected(1, 3);
  expected << 5.0 / 7 + 4 * v / (49 * mu * g), -2 * v * v / (49 * mu * mu * g), 0;
  expect_closed_form("rolls", scene, {value_at("p_x", 1)}, {{"speed", v}, {"friction", mu}, {"mass", 2}}, expected,
                     1e-9);
}

/// With spins about all axes it slides along a curve: friction turns with the slip, lever arms with the steps.
TEST(RigidContactGradients, OfASpinningBallThatSlides) {
  const ParametricScene scene = on_a_plane("spinning ball", 0.2, 5e-3, [](SystemGraph& graph, const SweepPoint& p) {
    const double m = p["mass"];
    auto& body = graph.add<RigidBody>("ball", {.mass = m,
                                               .inertia = {4e-3 * m, 5e-3 * m, 6e-3 * m},
                                               .position = {0, 0, 0.1},
                                               .velocity = {p["speed"], 0.4, 0},
                                               .angular_velocity = {2, -3, p["spin"]}});
    return touch_plane(graph, body, shape::sphere(0.1), p["friction"], 0);
  });
  expect_of_near_runs(scene, {value_at("p_x", 0.2), value_at("p_y", 0.2), value_at("v_y", 0.2)},
                      {{"speed", 2}, {"friction", 0.3}, {"mass", 1.5}, {"spin", 3}}, 1e-8);
}

/// Pushed through its centre it rolls along a slope, whose normal is no axis of the velocities:
///   x(T) = v T + 5/14 (F/m - g sin α) T²
TEST(RigidContactGradients, OfABallThatRollsAlongASlope) {
  constexpr double kSlope = 0.3, kRadius = 0.1;
  const Matrix3 R = rotation_about({0, 1, 0}, -kSlope);
  const ParametricScene scene = on_a_plane("slope", 0.5, 5e-3, [=](SystemGraph& graph, const SweepPoint& p) {
    const Vector3 up = R * Vector3::UnitX();
    const double m = p["mass"], J = 0.4 * m * kRadius * kRadius;
    auto& body = graph.add<RigidBody>("ball", {.mass = m,
                                               .inertia = {J, J, J},
                                               .position = R * Vector3(0, 0, kRadius),
                                               .velocity = p["speed"] * up,
                                               .angular_velocity = {0, p["speed"] / kRadius, 0}});
    graph.add<PointForce>("push", {body.marker()}, {.force = p["push"] * up});
    graph.add<Contact>("contact",
                       {{graph.ground().marker({}, R), shape::half_space()}, {body.marker(), shape::sphere(kRadius)}},
                       {.law = RigidSurfaces{}, .friction = {.coefficient = 0.6}});
    return std::vector<Sensor>{position(body.marker(), "p")};
  });
  const double F = 3, m = 2, T = 0.5;
  MatrixX expected(1, 3);
  expected << T, 5.0 / 14 * T * T / m, -5.0 / 14 * T * T * F / (m * m);
  expect_closed_form("slope", scene, {value_at("p_x", T)}, {{"speed", 0.7}, {"push", F}, {"mass", m}},
                     std::cos(kSlope) * expected, 1e-9);
}

/// A ball slides in a circle on a rod from a pin above: joints and contacts in one step.
ParametricScene tethered_ball() {
  return on_a_plane("tethered ball", 0.3, 5e-3, [](SystemGraph& graph, const SweepPoint& p) {
    const double m = p["mass"];
    auto& body = graph.add<RigidBody>("ball", {.mass = m,
                                               .inertia = {4e-3 * m, 5e-3 * m, 6e-3 * m},
                                               .position = {0.5, 0, 0.1},
                                               .velocity = {0, p["speed"], 0},
                                               .angular_velocity = {2, -3, p["spin"]}});
    graph.add<DistanceJoint>("rod", {graph.ground().marker({0, 0, 0.4}), body.marker()});
    return touch_plane(graph, body, shape::sphere(0.1), p["friction"], 0);
  });
}
const std::vector<DesignParameter> kTethered{{"speed", 1.2}, {"friction", 0.2}, {"mass", 1.5}, {"spin", 3}};

TEST(RigidContactGradients, OfABallOnARod) {
  expect_of_near_runs(tethered_ball(), {value_at("p_x", 0.3), value_at("v_y", 0.2)}, kTethered, 1e-8);
}

TEST(RigidContactGradients, AreThoseOfTheTangentBackwards) {
  const std::vector<Quantity> block{value_at("p_x", 0.8), integral("v_x"), value_at("p_x", 0.3)};
  EXPECT_LT(apart(sliding_block(0.8), block, kBlockNumbers), 1e-10);
  EXPECT_LT(apart(tethered_ball(), {value_at("p_x", 0.3), integral("v_y")}, kTethered), 1e-8);
}

/// Stretches are run again from checkpoints, with the same bits.
TEST(RigidContactGradients, BackwardsFromCheckpoints) {
  const std::vector<Quantity> end{value_at("p_x", 0.3)};
  const Gradient all = gradient(tethered_ball(), end, kTethered, {.mode = Mode::adjoint}),
                 some = gradient(tethered_ball(), end, kTethered, {.mode = Mode::adjoint, .memory = 12000});
  EXPECT_EQ(all.stretches, 1);
  EXPECT_GE(some.stretches, 2);
  EXPECT_EQ(all.derivatives, some.derivatives);
}

TEST(RigidContactGradients, LeaveTheRunItsBits) {
  expect_bits_of_the_run(sliding_block(0.8), kBlockNumbers, {"p_x", "v_x"});
}

std::string refusal(const ParametricScene& scene, const Quantity& quantity, const std::vector<DesignParameter>& numbers,
                    Mode mode = Mode::tangent) {
  try {
    gradient(scene, {quantity}, numbers, {.mode = mode});
  } catch (const Error& error) {
    return error.what();
  }
  return "none";
}

TEST(RigidContactGradients, RefuseByName) {
  // Its load is that of a step.
  EXPECT_NE(refusal(sliding_block(0.1), value_at("load_force_z", 0.1), kBlockNumbers).find("has no derivative"),
            std::string::npos);
  ParametricScene scene = sliding_block(0.1);
  scene.integrator = exact_alpha(1e-3);
  EXPECT_NE(refusal(scene, value_at("p_x", 0.1), kBlockNumbers).find("rigid surfaces"), std::string::npos);
}

/// A ball that rests: it cannot follow the height that it starts from, up or down, nor a larger radius.
TEST(RigidContactGradients, RefuseWhatContactsBlock) {
  const ParametricScene resting = on_a_plane("resting ball", 0.1, 5e-3, [](SystemGraph& graph, const SweepPoint& p) {
    auto& body = ball(graph, p, 0.1, {0, 0, p["height"]}, {p["speed"], 0, 0});
    return touch_plane(graph, body, shape::sphere(0.1), 0.2, 0);
  });
  for (const Mode mode : {Mode::tangent, Mode::adjoint}) {
    EXPECT_NE(
        refusal(resting, value_at("p_z", 0.1), {{"height", 0.1}, {"mass", 2}, {"speed", 1}}, mode).find("contacts"),
        std::string::npos);
    ParametricScene still = resting;
    still.draw = [=](SystemGraph& graph, const SweepPoint& p) {
      auto& body = ball(graph, p, 0.1, {0, 0, 0.1}, {p["speed"], 0, 0});
      return touch_plane(graph, body, shape::sphere(0.1), 0.2, 0);
    };
    EXPECT_EQ(refusal(still, value_at("p_z", 0.1), {{"mass", 2}, {"speed", 1}}, mode), "none");
  }
}

/// A ball thrown up to a ceiling that it just does not reach, v²/(2 g): thrown faster it meets it, more slowly it does
/// not.
TEST(RigidContactGradients, RefuseAGrazingBall) {
  constexpr double kSpeed = 0.05 * kRigidGravity;
  const auto thrown = [](double below) {
    return on_a_plane("grazing ball", 0.1, 5e-3, [=](SystemGraph& graph, const SweepPoint& p) {
      auto& body = ball(graph, p, 0.1, {0, 0, 0}, {0, 0, p["speed"]});
      const Vector3 ceiling(0, 0, 0.1 + kSpeed * kSpeed / (2 * kRigidGravity) - below);
      graph.add<Contact>("ceiling",
                         {{graph.ground().marker(ceiling, rotation_about({1, 0, 0}, M_PI)), shape::half_space()},
                          {body.marker(), shape::sphere(0.1)}},
                         {.law = RigidSurfaces{.restitution = 0.5}});
      return std::vector<Sensor>{position(body.marker(), "p")};
    });
  };
  const std::vector<DesignParameter> numbers{{"speed", kSpeed}, {"mass", 2}};
  for (const Mode mode : {Mode::tangent, Mode::adjoint}) {
    EXPECT_NE(refusal(thrown(0), value_at("p_z", 0.1), numbers, mode).find("contacts"), std::string::npos);
    EXPECT_EQ(refusal(thrown(2e-3), value_at("p_z", 0.1), numbers, mode), "none");   // meets it
    EXPECT_EQ(refusal(thrown(-2e-3), value_at("p_z", 0.1), numbers, mode), "none");  // does not
  }
}

TEST(RigidContactGradients, RefuseADegenerateSetOfContacts) {
  const ParametricScene pushed = on_a_plane("pushed block", 0.1, 5e-3, [](SystemGraph& graph, const SweepPoint& p) {
    const double J = 0.01;
    auto& block = graph.add<RigidBody>("block", {.mass = 1, .inertia = {J, J, J}, .position = {0, 0, 0.05}});
    graph.add<PointForce>("push", {block.marker()}, {.force = {p["push"], 0, 0}});
    return touch_plane(graph, block, shape::box({0.4, 0.3, 0.1}), 0.25, 0);
  });
  // At rest on the border of the cone: it holds for less, and slides for more.
  EXPECT_NE(refusal(pushed, value_at("p_x", 0.1), {{"push", 0.25 * kRigidGravity}}).find("contacts"),
            std::string::npos);
  EXPECT_EQ(refusal(pushed, value_at("p_x", 0.1), {{"push", 0.2 * kRigidGravity}}), "none");
}

}  // namespace
}  // namespace lithe::test
