// Derivatives of the steps of Moreau-Jean, with the same points open, sticking and sliding.
#include "bodies/rigid_body.h"
#include "engine/observe/contact_sensors.h"
#include "integrators/generalized_alpha.h"
#include "integrators/moreau_jean.h"
#include "joints/contact/contact.h"
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
  const Gradient found = gradient(sliding_block(0.8), {value_at("p_x", 0.8), value_at("v_x", 0.8)}, kBlockNumbers);
  EXPECT_NEAR(found.values[0], way, 1e-7);
  MatrixX expected(2, 3);
  expected << way, -way / 0.3, 0, 0, 0, 0;
  EXPECT_LE((found.derivatives - expected).lpNorm<Eigen::Infinity>(), 1e-3) << found.derivatives;
  if (std::getenv("LITHE_SHOW_ERRORS"))
    std::printf("block: off %.1e\n", (found.derivatives - expected).lpNorm<Eigen::Infinity>());
  expect_of_near_runs(sliding_block(0.8), {value_at("p_x", 0.8)}, kBlockNumbers, 1e-8, false);
  expect_of_near_runs(sliding_block(0.3), {value_at("p_x", 0.3), integral("v_x")}, kBlockNumbers, 1e-8, false);
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
  const Gradient found = gradient(scene, {value_at("p_z", T), value_at("p_x", T)},
                                  {{"height", height}, {"restitution", e}, {"speed", 0.3}, {"mass", 2}});
  EXPECT_LE((found.derivatives - expected).lpNorm<Eigen::Infinity>(), 1e-8) << found.derivatives << "\nexpected\n"
                                                                            << expected;
  if (std::getenv("LITHE_SHOW_ERRORS"))
    std::printf("bounces: off %.1e\n", (found.derivatives - expected).lpNorm<Eigen::Infinity>());
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
  const Gradient found = gradient(scene, {value_at("p_x", 1)}, {{"speed", v}, {"friction", mu}, {"mass", 2}});
  EXPECT_LE((found.derivatives - expected).lpNorm<Eigen::Infinity>(), 1e-8) << found.derivatives << "\nexpected\n"
                                                                            << expected;
  if (std::getenv("LITHE_SHOW_ERRORS"))
    std::printf("rolls: off %.1e\n", (found.derivatives - expected).lpNorm<Eigen::Infinity>());
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
                      {{"speed", 2}, {"friction", 0.3}, {"mass", 1.5}, {"spin", 3}}, 1e-8, false);
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
  EXPECT_NE(refusal(sliding_block(0.1), value_at("p_x", 0.1), kBlockNumbers, Mode::adjoint).find("no adjoint"),
            std::string::npos);
  ParametricScene scene = sliding_block(0.1);
  scene.integrator = exact_alpha(1e-3);
  EXPECT_NE(refusal(scene, value_at("p_x", 0.1), kBlockNumbers).find("rigid surfaces"), std::string::npos);
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
