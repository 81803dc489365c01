// Events that change the state under generalized-alpha: a step cut short, a start behind it with consistent
// accelerations, the shift of velocities and the acceleration-like state, and steps of another length from there on.
#include "bodies/rigid_body.h"
#include "integrators/explicit_runge_kutta.h"
#include "tests/gradient/gradient_scenes.h"

namespace lithe::test {
namespace {

const std::vector<DesignParameter> kAlphaNumbers{{"mass", 0.4}, {"offset", 0.02}, {"stiffness", 250}, {"damping", 3}};
const std::vector<Quantity> kAlphaEnd{value_at("coupler_z", 0.3), value_at("angle", 0.3), value_at("A_force_x", 0.3)};

ParametricScene alpha_loop(MakeIntegrator method, std::vector<ParametricEvent> events) {
  ParametricScene scene = redundant_loop();
  scene.integrator = std::move(method);
  scene.forward_dynamics = false;
  scene.events = std::move(events);
  return scene;
}

ParametricEvent rebound(const char* column, double level, Event::Direction direction) {
  return {.name = "rebound",
          .column = column,
          .level = level,
          .direction = direction,
          .change = [](State& state, const SweepPoint& p) { state.v *= -0.5 - p["offset"]; }};
}

/// A body passes a light barrier at a time that no parameter moves: differences of runs have steps of the same lengths.
TEST(AlphaEventGradients, OfALoopThatRebounds) {
  ParametricScene scene = alpha_loop(exact_alpha(3e-3), {rebound("clock_x", 0.1004, Event::Direction::rising)});
  scene.draw = [draw = scene.draw](SystemGraph& graph, const SweepPoint& p) {
    auto& clock = graph.add<RigidBody>("clock", {.velocity = {1, 0, 0}});
    std::vector<Sensor> sensors = draw(graph, p);
    sensors.push_back(position(clock.marker(), "clock"));
    return sensors;
  };
  expect_gradient(scene, kAlphaEnd, kAlphaNumbers);
}

/// The time of the event moves with all parameters. The derivative keeps the lengths of steps, those of the runs do
/// not: it is that of the motion, to the method's order.
TEST(AlphaEventGradients, AreOfSecondOrderWhereTheEventMoves) {
  const auto loop = [](MakeIntegrator method) {
    return alpha_loop(std::move(method), {rebound("angle", -0.02, Event::Direction::falling)});
  };
  const std::vector<Quantity> end{value_at("coupler_z", 0.3), value_at("angle", 0.3)};
  const auto exact = [] {
    return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{
        .method = ExplicitRungeKutta::Method::dormand_prince8, .tolerance = {.relative = 1e-11, .absolute = 1e-12}});
  };
  const MatrixX expected = gradient(loop(exact), end, kAlphaNumbers).derivatives;
  for (const auto mode : {GradientOptions::Mode::tangent, GradientOptions::Mode::adjoint}) {
    double before = 0;
    for (const double step : {1e-3, 5e-4, 2.5e-4}) {
      const MatrixX found = gradient(loop(exact_alpha(step)), end, kAlphaNumbers, {.mode = mode}).derivatives;
      const double off = ((found - expected).array() / expected.array()).abs().maxCoeff();
      if (std::getenv("LITHE_SHOW_ERRORS")) std::printf("steps of %g s: off %.1e\n", step, off);
      if (before > 0) {
        EXPECT_LT(off, before / 3);
      }
      before = off;
    }
    EXPECT_LT(before, 2e-5);
  }
}

TEST(AlphaEventGradients, AgreeForwardsAndBackwards) {
  const ParametricScene scene = alpha_loop(exact_alpha(2e-3), {rebound("angle", -0.02, Event::Direction::falling)});
  using Mode = GradientOptions::Mode;
  const Gradient forwards = gradient(scene, kAlphaEnd, kAlphaNumbers, {.mode = Mode::tangent});
  expect_close(gradient(scene, kAlphaEnd, kAlphaNumbers, {.mode = Mode::adjoint}), forwards, kAlphaNumbers);
  const Gradient some = gradient(scene, kAlphaEnd, kAlphaNumbers, {.mode = Mode::adjoint, .memory = 100000});
  EXPECT_GE(some.stretches, 2);
  expect_close(some, forwards, kAlphaNumbers);
}

/// Steps that do not divide the duration: the last is as long as the others, which are shorter than the first was to
/// be.
TEST(AlphaEventGradients, OfStepsThatDoNotDivideTheDuration) {
  ParametricScene scene = redundant_loop();
  scene.integrator = exact_alpha(7e-3);
  expect_gradient(scene, kAlphaEnd, kAlphaNumbers);
}

}  // namespace
}  // namespace lithe::test
