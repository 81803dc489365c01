#include <complex>

#include "bodies/rigid_body.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/lie_bdf.h"
#include "integrators/radau.h"
#include "tests/gradient/gradient_scenes.h"

namespace lithe::test {
namespace {

constexpr Tolerance kEventTolerance{.relative = 1e-11, .absolute = 1e-12};

std::unique_ptr<Integrator> fine_runge_kutta() {
  return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{
      .method = ExplicitRungeKutta::Method::dormand_prince8, .tolerance = kEventTolerance});
}
std::unique_ptr<Integrator> fine_radau() {
  return std::make_unique<Radau>(Radau::Parameters{.tolerance = kEventTolerance});
}
std::unique_ptr<Integrator> fine_bdf() {
  return std::make_unique<LieBdf>(LieBdf::Parameters{.tolerance = kEventTolerance});
}
/// Exact where accelerations are constant between events.
const MakeIntegrator kEventMethods[] = {fine_runge_kutta, fine_radau, fine_bdf, exact_alpha(2e-3)};

/// Two balls on a line that meet once and exchange their velocities, as elastic ones of equal masses do.
ParametricScene two_balls() {
  return {.name = "two balls",
          .duration = 1,
          .gravity = {0, 0, 0},
          .draw =
              [](SystemGraph& graph, const SweepPoint& p) {
                const auto ball = [&](const char* name, double x, double v) {
                  return graph
                      .add<RigidBody>(
                          name,
                          {.mass = 2, .inertia = {0.01, 0.01, 0.01}, .position = {x, 0, 0}, .velocity = {v, 0, 0}})
                      .marker();
                };
                const double radius = p["radius"];
                const Marker a = ball("a", p["x_a"], p["v_a"]), b = ball("b", p["x_b"], p["v_b"]);
                return std::vector<Sensor>{position(a, "a"), position(b, "b"), velocity(a, "a_v"), velocity(b, "b_v"),
                                           Sensor("gap", {"gap"}, [=](Snapshot& now, std::span<double> out) {
                                             out[0] = now.marker(b).p.x() - now.marker(a).p.x() - 2 * radius;
                                           })};
              },
          .forward_dynamics = false,
          .events = {{.name = "impact",
                      .column = "gap",
                      .direction = Event::Direction::falling,
                      .change = [](State& state, const SweepPoint&) { std::swap(state.v[0], state.v[6]); }}}};
}

/// x_a(T) = x_b + v_b T - 2 r and x_b(T) = x_a + v_a T + 2 r, wherever they meet.
TEST(EventGradients, OfTwoElasticBallsAreExact) {
  const std::vector<DesignParameter> start{{"x_a", 0}, {"x_b", 0.6}, {"v_a", 1.1}, {"v_b", 0.2}, {"radius", 0.1}};
  const std::vector<Quantity> end{value_at("a_x", 1), value_at("b_x", 1), value_at("a_v_x", 1), value_at("b_v_x", 1)};
  MatrixX expected(4, 5);
  expected << 0, 1, 0, 1, -2,  //
      1, 0, 1, 0, 2,           //
      0, 0, 0, 1, 0,           //
      0, 0, 1, 0, 0;
  ParametricScene scene = two_balls();
  for (const MakeIntegrator& method : kEventMethods)
    for (const auto mode : {GradientOptions::Mode::tangent, GradientOptions::Mode::adjoint}) {
      scene.integrator = method;
      const Gradient found = gradient(scene, end, start, {.mode = mode});
      const double off = (found.derivatives - expected).lpNorm<Eigen::Infinity>();
      EXPECT_LE(off, 1e-9) << method()->name() << "\n" << found.derivatives;
      if (std::getenv("LITHE_SHOW_ERRORS")) std::printf("%s: off %.1e\n", method()->name().c_str(), off);
    }
}

constexpr double kBounceGravity = 9.81, kBounceEnd = 1.2;

/// A ball that drops from a height and bounces twice until kBounceEnd; a bounce leaves a part of its speed.
ParametricScene bouncing_ball() {
  return {.name = "bouncing ball",
          .duration = kBounceEnd,
          .gravity = {0, 0, -kBounceGravity},
          .draw =
              [](SystemGraph& graph, const SweepPoint& p) {
                auto& ball = graph.add<RigidBody>(
                    "ball", {.mass = 2, .inertia = {0.01, 0.01, 0.01}, .position = {0, 0, p["height"]}});
                return std::vector<Sensor>{position(ball.marker(), "ball"), velocity(ball.marker(), "v")};
              },
          .forward_dynamics = false,
          .events = {{.name = "bounce",
                      .column = "ball_z",
                      .direction = Event::Direction::falling,
                      .change = [](State& state, const SweepPoint& p) { state.v[2] *= -p["restitution"]; }}}};
}

/// z(T) and ∫ z dt in closed form.
template <class S>
std::array<S, 2> bounced(S height, S restitution) {
  const S first = std::sqrt(2.0 * height / kBounceGravity), v1 = restitution * kBounceGravity * first,
          arc = 2.0 * v1 / kBounceGravity;
  const S v2 = restitution * v1, t = kBounceEnd - first - arc;
  const S area = height * first - kBounceGravity * first * first * first / 6.0;
  const auto under = [](S v, S time) { return v * time * time / 2.0 - kBounceGravity * time * time * time / 6.0; };
  return {v2 * t - kBounceGravity / 2 * t * t, area + under(v1, arc) + under(v2, t)};
}

/// Against the closed form by a complex step. The velocity jumps: the integral over it changes with the jump's time.
TEST(EventGradients, OfABouncingBall) {
  const double height = 0.5, restitution = 0.8;
  const std::vector<Quantity> quantities{value_at("ball_z", kBounceEnd), integral("ball_z"), integral("v_z")};
  MatrixX expected(3, 2);
  for (int k = 0; k < 2; ++k) {
    using Complex = std::complex<double>;
    const auto by = bounced(Complex(height, k == 0 ? 1e-30 : 0), Complex(restitution, k == 1 ? 1e-30 : 0));
    for (int i = 0; i < 2; ++i) expected(i, k) = by[static_cast<std::size_t>(i)].imag() / 1e-30;
    expected(2, k) = expected(0, k) - (k == 0 ? 1 : 0);
  }
  ParametricScene scene = bouncing_ball();
  for (const MakeIntegrator& method : kEventMethods)
    for (const auto mode : {GradientOptions::Mode::tangent, GradientOptions::Mode::adjoint}) {
      scene.integrator = method;
      const Gradient found =
          gradient(scene, quantities, {{"height", height}, {"restitution", restitution}}, {.mode = mode});
      const double off = (found.derivatives - expected).lpNorm<Eigen::Infinity>();
      EXPECT_LE(off, 1e-8) << method()->name() << "\n" << found.derivatives << "\nexpected\n" << expected;
      EXPECT_NEAR(found.values[0], bounced(height, restitution)[0], 1e-9);
      if (std::getenv("LITHE_SHOW_ERRORS")) std::printf("%s: off %.1e\n", method()->name().c_str(), off);
    }
}

/// The loop's crank hits a stop and rebounds; joints close in redundant rows.
ParametricScene rebounding_loop(MakeIntegrator method) {
  ParametricScene scene = redundant_loop();
  scene.integrator = std::move(method);
  scene.forward_dynamics = false;
  scene.events = {{.name = "stop",
                   .column = "angle",
                   .level = -0.02,
                   .direction = Event::Direction::falling,
                   .change = [](State& state, const SweepPoint& p) { state.v *= -0.5 - p["offset"]; }}};
  return scene;
}
const std::vector<DesignParameter> kReboundNumbers{{"mass", 0.4}, {"offset", 0.02}, {"stiffness", 250}, {"damping", 3}};

TEST(EventGradients, OfARedundantLoopThatRebounds) {
  const std::vector<Quantity> quantities{value_at("coupler_z", 0.3), value_at("angle", 0.3)};
  for (const MakeIntegrator method : {fine_runge_kutta, fine_radau})
    expect_gradient(rebounding_loop(method), quantities, kReboundNumbers);
  // Differences of runs would have what BDF's steps change by.
  const Gradient expected = gradient(rebounding_loop(fine_runge_kutta), quantities, kReboundNumbers);
  for (const auto mode : {GradientOptions::Mode::tangent, GradientOptions::Mode::adjoint})
    expect_close(gradient(rebounding_loop(fine_bdf), quantities, kReboundNumbers, {.mode = mode}), expected,
                 kReboundNumbers);
}

/// A rod on a driven hinge, whose joints move velocities onto the drive's own after the change.
TEST(EventGradients, OfADrivenRodThatLosesItsVibration) {
  ParametricScene scene = driven_rod("linear modes", {.modes = {0, 1}}, 6);
  scene.forward_dynamics = false;
  scene.events = {{.name = "damped", .column = "tip_z", .level = -0.3, .change = [](State& state, const SweepPoint&) {
                     state.v *= 0.3;
                   }}};
  for (const MakeIntegrator method : {fine_runge_kutta, fine_radau}) {
    scene.integrator = method;
    expect_gradient(scene, {value_at("tip_z", 0.2)},
                    {{"thickness", 0.01}, {"E", 7e10}, {"density", 2700}, {"turn", 0.6}});
  }
}

TEST(EventGradients, TheRunIsThatOfSimulation) {
  const ParametricScene scene = rebounding_loop(fine_runge_kutta);
  const Gradient found = gradient(scene, {value_at("angle", 0.3)}, kReboundNumbers);
  const Drawing drawing(scene, kReboundNumbers);
  const Drawing::Place angle = drawing.find("angle");
  const auto integrator = scene.integrator();
  Simulation simulation(drawing.system(), *integrator);
  simulation.on({.name = "stop",
                 .function = watch(drawing.sensor(angle.sensor), angle.column),
                 .level = -0.02,
                 .direction = Event::Direction::falling,
                 .action = Event::Action::restart,
                 .change = [&](State& state) { scene.events.front().change(state, drawing.point()); }});
  State state = drawing.system().initial_state();
  simulation.run(state, scene.duration);
  EXPECT_GE(simulation.events().size(), 1u);
  Snapshot now(drawing.system());
  now.evaluate(state, Accelerations::solved);
  EXPECT_NEAR(found.values[0], drawing.sensor(angle.sensor).value(now, angle.column), 1e-10);
}

TEST(EventGradients, RunStretchesAgainWhereMemoryIsShort) {
  for (const MakeIntegrator method : {fine_radau, fine_bdf}) {
    const ParametricScene scene = rebounding_loop(method);
    const Gradient all =
        gradient(scene, {value_at("angle", 0.3)}, kReboundNumbers, {.mode = GradientOptions::Mode::adjoint});
    const Gradient some = gradient(scene, {value_at("angle", 0.3)}, kReboundNumbers,
                                   {.mode = GradientOptions::Mode::adjoint, .memory = 100000});
    EXPECT_GE(some.stretches, 2);
    EXPECT_EQ(all.derivatives, some.derivatives);
  }
}

TEST(EventGradients, RefuseByName) {
  const auto refusal = [](const ParametricScene& scene, const Quantity& quantity) -> std::string {
    try {
      gradient(scene, {quantity}, {{"height", 0.5}, {"restitution", 0.8}});
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  };
  ParametricScene scene = bouncing_ball();
  scene.integrator = fine_radau;
  EXPECT_NE(refusal(scene, smallest("v_z")).find("reached at an event"), std::string::npos);
  scene.events.front().column = "ball_y";
  EXPECT_EQ(refusal(scene, value_at("ball_z", 0.1)), "none");  // never passes its level
  scene.events.front().column = "nowhere";
  EXPECT_NE(refusal(scene, value_at("ball_z", 0.1)).find("no sensor of the scene has a column 'nowhere'"),
            std::string::npos);
}

}  // namespace
}  // namespace lithe::test
