// Contacts as forces: through Runge-Kutta and Radau by steps taken again, through generalized-alpha by its equations.
#include <complex>

#include "bodies/rigid_body.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/lie_bdf.h"
#include "integrators/radau.h"
#include "joints/contact/contact.h"
#include "joints/revolute_joint.h"
#include "tests/gradient/gradient_scenes.h"

namespace lithe::test {
namespace {

using Mode = GradientOptions::Mode;

MakeIntegrator touch_runge_kutta(double step, double tolerance = 0) {
  return [=] {
    return std::make_unique<ExplicitRungeKutta>(
        ExplicitRungeKutta::Parameters{.method = ExplicitRungeKutta::Method::dormand_prince5,
                                       .step = step,
                                       .tolerance = {.relative = tolerance > 0 ? tolerance : 1e-6,
                                                     .absolute = tolerance > 0 ? tolerance / 10 : 1e-9}});
  };
}
MakeIntegrator touch_radau(double step) {
  return [=] { return std::make_unique<Radau>(Radau::Parameters{.step = step, .newton_tolerance = 1e-13}); };
}

MakeIntegrator touch_bdf(double step) {
  return [=] {
    return std::make_unique<LieBdf>(LieBdf::Parameters{
        .step = step, .tolerance = {.relative = 1e-12, .absolute = 1e-13}, .newton_tolerance = 1e-2});
  };
}

constexpr double kBallRadius = 0.1;

/// A ball and the plane z = 0.
std::vector<Sensor> ball_on_plane(SystemGraph& graph, const SweepPoint& p, const Contact::Parameters& law,
                                  const Vector3& position_of, const Vector3& speed, const Vector3& spin = {0, 0, 0}) {
  const double J = 0.4 * p["mass"] * kBallRadius * kBallRadius;
  auto& ball = graph.add<RigidBody>(
      "ball",
      {.mass = p["mass"], .inertia = {J, J, J}, .position = position_of, .velocity = speed, .angular_velocity = spin});
  graph.add<Contact>(
      "contact", {{graph.ground().marker(), shape::half_space()}, {ball.marker(), shape::sphere(kBallRadius)}}, law);
  return {position(ball.marker(), "p"), velocity(ball.marker(), "v")};
}

/// A ball meets a plane that pushes like a spring, without gravity: it touches for half a period, π sqrt(m/k), and
/// leaves as fast as it came.
ParametricScene half_period(MakeIntegrator method) {
  return {.name = "half a period",
          .duration = 0.1,
          .gravity = {0, 0, 0},
          .draw =
              [](SystemGraph& graph, const SweepPoint& p) {
                return ball_on_plane(graph, p, {.law = Compliance{.stiffness = p["stiffness"], .exponent = 1}},
                                     {0, 0, kBallRadius + p["gap"]}, {0, 0, -p["speed"]});
              },
          .integrator = std::move(method)};
}

/// z(T) = r - gap + v (T - π sqrt(m/k)).
TEST(ContactGradients, OfTheHalfPeriodOfASpring) {
  const double m = 2, k = 8000, v = 1.5, T = 0.1, touch = M_PI * std::sqrt(m / k);
  const std::vector<DesignParameter> numbers{{"stiffness", k}, {"mass", m}, {"speed", v}, {"gap", 0.0203}};
  // Relative, in units of the parameters' values.
  Eigen::RowVectorXd expected(4), scales(4);
  scales << k, m, v, 0.0203;
  expected << v * touch / 2, -v * touch / 2, v * (T - touch), -0.0203;
  const auto off = [&](MakeIntegrator method, Mode mode) {
    const Gradient found = gradient(half_period(std::move(method)), {value_at("p_z", T)}, numbers, {.mode = mode});
    const double error = (found.derivatives.cwiseProduct(scales) - expected).lpNorm<Eigen::Infinity>() /
                         expected.lpNorm<Eigen::Infinity>();
    if (std::getenv("LITHE_SHOW_ERRORS")) std::printf("%ld steps: off %.1e\n", found.steps, error);
    return error;
  };
  for (const Mode mode : {Mode::tangent, Mode::adjoint}) {
    // Steps end where the force begins and ends; error control makes them short before it has seen that.
    EXPECT_LT(off(touch_runge_kutta(2e-4), mode), 1e-8);
    EXPECT_LT(off(touch_radau(5e-4), mode), 1e-8);
    EXPECT_LT(off(touch_runge_kutta(0, 1e-11), mode), 1e-4);
    const double coarse = off(exact_alpha(2e-4), mode), fine = off(exact_alpha(5e-5), mode);
    EXPECT_LT(fine, 2e-4);
    EXPECT_LT(fine, coarse / 3);
  }
}

/// It stays in touch, so that the runs that are compared see no kink: Hertz's law with damping, sliding with
/// regularised friction.
ParametricScene sliding_ball(MakeIntegrator method, const std::function<Contact::Parameters(const SweepPoint&)>& law) {
  return {.name = "sliding ball",
          .duration = 0.1,
          .draw =
              [=](SystemGraph& graph, const SweepPoint& p) {
                return ball_on_plane(graph, p, law(p), {0, 0, kBallRadius - 2.5e-3}, {p["speed"], 0.2, 0}, {1, 3, 2});
              },
          .integrator = std::move(method)};
}
Contact::Parameters hertz_and_creep(const SweepPoint& p) {
  return {.law = Compliance{.stiffness = p["stiffness"], .dissipation = Dissipation::fixed, .damping = p["damping"]},
          .friction = {
              .coefficient = p["friction"], .creep_speed = 0.1, .viscous = 0.02, .rolling = 1e-3, .creep_spin = 1}};
}
const std::vector<DesignParameter> kBallNumbers{
    {"stiffness", 1.5e5}, {"damping", 0.5}, {"friction", 0.3}, {"mass", 2}, {"speed", 0.8}};
const std::vector<Quantity> kBallEnd{value_at("p_x", 0.1), value_at("p_z", 0.1), value_at("v_y", 0.07),
                                     integral("v_z")};

TEST(ContactGradients, RungeKutta5OfASlidingBall) {
  expect_gradient(sliding_ball(touch_runge_kutta(1e-3), hertz_and_creep), kBallEnd, kBallNumbers);
}
/// Velocities differ between runs by what Newton leaves in each step: their differences are not as good.
TEST(ContactGradients, RadauOfASlidingBall) {
  expect_gradient(sliding_ball(touch_radau(2e-3), hertz_and_creep),
                  {value_at("p_x", 0.1), value_at("p_z", 0.1), integral("v_z")}, kBallNumbers);
}
TEST(ContactGradients, GeneralizedAlphaOfASlidingBall) {
  expect_gradient(sliding_ball(exact_alpha(1e-3), hertz_and_creep), kBallEnd, kBallNumbers);
}

/// Its start is by steps of their own, which change with the parameters: against Runge-Kutta of long steps. Velocities
/// are off by 3e-8.
TEST(ContactGradients, LieBdfOfASlidingBall) {
  const std::vector<Quantity> end{value_at("p_x", 0.1), value_at("p_z", 0.1), integral("v_z")};
  const Gradient expected = gradient(sliding_ball(touch_runge_kutta(2e-4), hertz_and_creep), end, kBallNumbers);
  for (const Mode mode : {Mode::tangent, Mode::adjoint})
    expect_close(gradient(sliding_ball(touch_bdf(2e-4), hertz_and_creep), end, kBallNumbers, {.mode = mode}), expected,
                 kBallNumbers);
}

/// What contacts remember is carried along: the deflection of bristles and the speed of the impact.
TEST(ContactGradients, OfBristlesThatSlideAndStick) {
  const auto bristles = [](const SweepPoint& p) -> Contact::Parameters {
    return {.law = Compliance{.stiffness = p["stiffness"], .dissipation = Dissipation::fixed, .damping = p["damping"]},
            .friction = {.coefficient = p["friction"], .bristle_stiffness = 200, .bristle_damping = 0.5}};
  };
  for (const MakeIntegrator& method : {touch_runge_kutta(1e-3), touch_radau(1e-3)})
    expect_of_near_runs(sliding_ball(method, bristles), {value_at("p_x", 0.1), value_at("p_z", 0.1)}, kBallNumbers,
                        1e-7);
}

/// A damped impact leaves with e v, whatever stiffness and mass.
TEST(ContactGradients, OfARestitution) {
  const auto draw = [](SystemGraph& graph, const SweepPoint& p) {
    return ball_on_plane(graph, p, {.law = Compliance{.stiffness = p["stiffness"], .restitution = p["restitution"]}},
                         {0, 0, kBallRadius + 1e-3}, {0, 0, -p["speed"]});
  };
  const ParametricScene scene{.name = "damped impact",
                              .duration = 0.05,
                              .gravity = {0, 0, 0},
                              .draw = draw,
                              .integrator = touch_runge_kutta(0, 1e-10)};
  const double v = 1.5, e = 0.6;
  Eigen::RowVectorXd expected(4);
  expected << e, v, 0, 0;
  for (const Mode mode : {Mode::tangent, Mode::adjoint}) {
    const Gradient found =
        gradient(scene, {value_at("v_z", 0.05)}, {{"speed", v}, {"restitution", e}, {"stiffness", 1e6}, {"mass", 2}},
                 {.mode = mode});
    Eigen::RowVectorXd off = found.derivatives - expected;
    off[2] *= 1e6;
    EXPECT_LE(off.lpNorm<Eigen::Infinity>(), 1e-6) << found.derivatives;
    if (std::getenv("LITHE_SHOW_ERRORS")) std::printf("restitution: off %.1e\n", off.lpNorm<Eigen::Infinity>());
  }
}

/// A rod that bends, hinged at one end, leans with a ball at its tip on a soft floor.
ParametricScene leaning_rod(MakeIntegrator method) {
  ParametricScene scene{.name = "leaning rod", .duration = 0.05};
  scene.draw = [](SystemGraph& graph, const SweepPoint& p) {
    const BeamSection section = BeamSection::rectangle(0.02, p["thickness"], {p["E"], 0.3, 2700});
    auto& rod = graph.add<SlenderBody>("rod", {.beam = {.axis = BeamAxis::straight({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                                                        .sections = {{0, section}},
                                                        .elements = 6},
                                               .mode_count = 3});
    rod.set_fidelity({.modes = {0, 1}});
    const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
    graph.add<RevoluteJoint>("hub", {graph.ground().marker({}, along_y), rod.marker(0, along_y)});
    graph.add<Contact>(
        "floor", {{graph.ground().marker({0, 0, -0.048}), shape::half_space()}, {rod.marker(1), shape::sphere(0.05)}},
        {.law = Compliance{.stiffness = p["stiffness"], .dissipation = Dissipation::fixed, .damping = 1},
         .friction = {.coefficient = p["friction"], .creep_speed = 0.1}});
    return std::vector<Sensor>{position(rod.marker(1), "tip")};
  };
  scene.integrator = std::move(method);
  return scene;
}
const std::vector<DesignParameter> kLeaningNumbers{
    {"thickness", 0.01}, {"E", 7e10}, {"stiffness", 3e4}, {"friction", 0.4}};

TEST(ContactGradients, GeneralizedAlphaOfARodThatTouches) {
  expect_gradient(leaning_rod(exact_alpha(5e-4)), {value_at("tip_z", 0.05), value_at("tip_z", 0.03)}, kLeaningNumbers,
                  2e-8);
}
TEST(ContactGradients, LieBdfOfARodThatTouches) {
  const std::vector<Quantity> end{value_at("tip_z", 0.05), value_at("tip_z", 0.03)};
  const Gradient expected = gradient(leaning_rod(touch_runge_kutta(1e-4)), end, kLeaningNumbers);
  for (const Mode mode : {Mode::tangent, Mode::adjoint})
    expect_close(gradient(leaning_rod(touch_bdf(1e-4)), end, kLeaningNumbers, {.mode = mode}), expected,
                 kLeaningNumbers);
}
TEST(ContactGradients, RungeKutta5OfARodThatTouches) {
  expect_gradient(leaning_rod(touch_runge_kutta(2e-4)), {value_at("tip_z", 0.05)}, kLeaningNumbers, 2e-8);
}

TEST(ContactGradients, LeaveTheRunItsBits) {
  for (const MakeIntegrator& method : {touch_runge_kutta(1e-3), touch_radau(1e-3), exact_alpha(1e-3), touch_bdf(1e-3)})
    expect_bits_of_the_run(sliding_ball(method, hertz_and_creep), kBallNumbers, {"p_x", "v_z"});
}

TEST(ContactGradients, RefuseByName) {
  const auto refusal = [](const ParametricScene& scene) -> std::string {
    try {
      gradient(scene, {value_at("p_x", 0.1)}, kBallNumbers);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "none";
  };
  const auto restitution = [](const SweepPoint& p) -> Contact::Parameters {
    return {.law = Compliance{.stiffness = p["stiffness"], .restitution = 0.5}};
  };
  for (const MakeIntegrator& method : {exact_alpha(1e-3), touch_bdf(1e-3)})
    EXPECT_NE(refusal(sliding_ball(method, restitution)).find("remember"), std::string::npos);
}

}  // namespace
}  // namespace lithe::test
