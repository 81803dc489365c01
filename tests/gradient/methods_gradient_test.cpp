#include "integrators/explicit_runge_kutta.h"
#include "integrators/lie_bdf.h"
#include "integrators/radau.h"
#include "integrators/rattle.h"
#include "tests/gradient/gradient_scenes.h"

namespace lithe::test {
namespace {

using Method = ExplicitRungeKutta::Method;
using Mode = GradientOptions::Mode;

MakeIntegrator runge_kutta(Method method, double step) {
  return [=] {
    return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{.method = method, .step = step});
  };
}
MakeIntegrator exact_radau(double step) {
  return [=] { return std::make_unique<Radau>(Radau::Parameters{.step = step, .newton_tolerance = 1e-13}); };
}
/// Fixed steps begin with those of the automatic method, whose lengths change with the parameters within its tolerance.
MakeIntegrator exact_bdf(double step) {
  return [=] {
    return std::make_unique<LieBdf>(LieBdf::Parameters{
        .step = step, .tolerance = {.relative = 1e-12, .absolute = 1e-13}, .newton_tolerance = 1e-2});
  };
}
ParametricScene with(ParametricScene scene, MakeIntegrator integrator, bool forward_dynamics = true) {
  scene.integrator = std::move(integrator);
  scene.forward_dynamics = forward_dynamics;
  return scene;
}

const std::vector<DesignParameter> kPendulumNumbers{{"mass", 1.3}, {"inertia", 0.08}, {"length", 0.4}, {"speed", 0.7}};
const std::vector<Quantity> kSwing{value_at("tip_x", 0.6), value_at("v_x", 0.4), integral("tip_z")};
const std::vector<DesignParameter> kLoopNumbers{{"mass", 0.4}, {"offset", 0.02}, {"stiffness", 250}, {"damping", 3}};
const std::vector<Quantity> kAround{value_at("coupler_z", 0.3), value_at("angle", 0.2), value_at("A_force_x", 0.15)};
const std::vector<DesignParameter> kRodNumbers{{"thickness", 0.01}, {"E", 7e10}, {"density", 2700}, {"turn", 0.6}};

// ---- forwards through forward dynamics of a tree, backwards without it ----
TEST(MethodGradients, RungeKutta5OfATree) {
  expect_gradient(with(pendulum(), runge_kutta(Method::dormand_prince5, 1e-2)), kSwing, kPendulumNumbers, 1e-8, false);
}
TEST(MethodGradients, RungeKutta5) {
  expect_gradient(with(pendulum(), runge_kutta(Method::dormand_prince5, 1e-2), false), kSwing, kPendulumNumbers);
}
TEST(MethodGradients, RungeKutta8) {
  expect_gradient(with(pendulum(), runge_kutta(Method::dormand_prince8, 2e-2), false), kSwing, kPendulumNumbers);
}
TEST(MethodGradients, Radau) { expect_gradient(with(pendulum(), exact_radau(1e-2)), kSwing, kPendulumNumbers); }

// ---- turns about all axes, where charts of steps matter ----
const std::vector<DesignParameter> kTopNumbers{{"mass", 1.2}, {"inertia", 0.04}, {"length", 0.3}, {"spin", 6}};
const std::vector<Quantity> kTumbled{value_at("tip_x", 0.4), value_at("v_y", 0.3)};

TEST(MethodGradients, RungeKutta8OfATop) {
  expect_gradient(with(tumbling_top(), runge_kutta(Method::dormand_prince8, 1e-2), false), kTumbled, kTopNumbers);
}
TEST(MethodGradients, RadauOfATop) { expect_gradient(with(tumbling_top(), exact_radau(4e-3)), kTumbled, kTopNumbers); }
/// Differences of runs would have what the start's steps change by.
TEST(MethodGradients, LieBdfOfATop) {
  const Gradient expected =
      gradient(with(tumbling_top(), runge_kutta(Method::dormand_prince8, 5e-3)), kTumbled, kTopNumbers);
  for (const auto mode : {GradientOptions::Mode::tangent, GradientOptions::Mode::adjoint})
    expect_close(gradient(with(tumbling_top(), exact_bdf(5e-4)), kTumbled, kTopNumbers, {.mode = mode}), expected,
                 kTopNumbers);
}

TEST(MethodGradients, RungeKutta5OfARedundantLoop) {
  expect_gradient(with(redundant_loop(), runge_kutta(Method::dormand_prince5, 5e-3), false), kAround, kLoopNumbers);
}
TEST(MethodGradients, RungeKutta8OfARedundantLoop) {
  expect_gradient(with(redundant_loop(), runge_kutta(Method::dormand_prince8, 1e-2), false), kAround, kLoopNumbers);
}
TEST(MethodGradients, RungeKutta5OfAPlanarLoopByFreeMotions) {
  expect_gradient(with(redundant_loop(), runge_kutta(Method::dormand_prince5, 5e-3)), kAround, kLoopNumbers, 1e-8,
                  false);
}
TEST(MethodGradients, RadauOfARedundantLoop) {
  // 4e-9: differences of steps have what Newton leaves in each.
  expect_gradient(with(redundant_loop(), exact_radau(3e-3)), kAround, kLoopNumbers, 1.5e-8);
}

TEST(MethodGradients, RungeKutta5OfADrivenRodWithModes) {
  expect_gradient(with(driven_rod("linear modes", {.modes = {0, 1}}, 6), runge_kutta(Method::dormand_prince5, 5e-4)),
                  {value_at("tip_z", 0.2)}, kRodNumbers);
}
TEST(MethodGradients, RadauOfADrivenRodWithModes) {
  expect_gradient(with(driven_rod("linear modes", {.modes = {0, 1}}, 6), exact_radau(5e-4)), {value_at("tip_z", 0.2)},
                  kRodNumbers);
}
TEST(MethodGradients, RadauOfAStiffenedRod) {
  expect_gradient(
      with(driven_rod("stiffened", {.modes = {0, 1, 2}, .deflection = Deflection::stiffened}, 6), exact_radau(2e-3)),
      {value_at("tip_z", 0.2)}, kRodNumbers);
}

// ---- Andrews' squeezer: ten hinges in loops, 50 rows of rank 41 ----
const std::vector<DesignParameter> kSqueezerNumbers{
    {"mass", 0.0705}, {"stiffness", 4530}, {"torque", 0.033}, {"natural_length", 0.07785}};
const std::vector<Quantity> kSqueezed{value_at("F_x", 0.01), value_at("G_y", 0.02), integral("E_x")};

TEST(MethodGradients, GeneralizedAlphaOfAndrewsSqueezer) { expect_gradient(squeezer(), kSqueezed, kSqueezerNumbers); }
TEST(MethodGradients, RungeKutta8OfAndrewsSqueezer) {
  expect_gradient(with(squeezer(), runge_kutta(Method::dormand_prince8, 2e-4), false), kSqueezed, kSqueezerNumbers);
}
/// Against another method: runs with parameters moved leave out other redundant rows from 9 ms on, and so correct
/// positions by as much as the step's error differently. Their differences are off by 3e-5.
TEST(MethodGradients, RadauOfAndrewsSqueezer) {
  ParametricScene scene = squeezer();
  scene.duration = 0.01;
  const std::vector<Quantity> end{value_at("F_x", 0.01), value_at("G_y", 0.01)};
  const Gradient expected =
      gradient(with(scene, runge_kutta(Method::dormand_prince8, 1e-4), false), end, kSqueezerNumbers);
  for (const auto mode : {GradientOptions::Mode::tangent, GradientOptions::Mode::adjoint})
    expect_close(gradient(with(scene, exact_radau(1e-4)), end, kSqueezerNumbers, {.mode = mode}), expected,
                 kSqueezerNumbers);
}

// ---- BDF ----
TEST(MethodGradients, LieBdf) { expect_gradient(with(pendulum(), exact_bdf(2e-3)), kSwing, kPendulumNumbers); }
TEST(MethodGradients, LieBdfOfARedundantLoop) {
  expect_gradient(with(redundant_loop(), exact_bdf(3e-3)), kAround, kLoopNumbers);
}
TEST(MethodGradients, LieBdfOfAStiffenedRod) {
  expect_gradient(
      with(driven_rod("stiffened", {.modes = {0, 1, 2}, .deflection = Deflection::stiffened}, 6), exact_bdf(1e-3)),
      {value_at("tip_z", 0.2)}, kRodNumbers);
}

/// Steps that the error control took: their derivative is that of the motion, to the tolerance, which long fixed steps
/// of order 8 tell.
TEST(MethodGradients, OfStepsThatErrorControlTook) {
  const auto automatic = [] {
    return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{
        .method = Method::dormand_prince8, .tolerance = {.relative = 1e-11, .absolute = 1e-12}});
  };
  const auto radau = [] {
    return std::make_unique<Radau>(Radau::Parameters{.tolerance = {.relative = 1e-11, .absolute = 1e-12}});
  };
  const auto bdf = [] {
    return std::make_unique<LieBdf>(LieBdf::Parameters{.tolerance = {.relative = 1e-11, .absolute = 1e-12}});
  };
  const Gradient fixed = gradient(with(redundant_loop(), runge_kutta(Method::dormand_prince8, 3e-3)),
                                  {value_at("coupler_z", 0.3)}, kLoopNumbers);
  for (const Gradient& found :
       {gradient(with(redundant_loop(), automatic), {value_at("coupler_z", 0.3)}, kLoopNumbers,
                 {.mode = Mode::tangent}),
        gradient(with(redundant_loop(), automatic, false), {value_at("coupler_z", 0.3)}, kLoopNumbers,
                 {.mode = Mode::adjoint}),
        gradient(with(redundant_loop(), radau), {value_at("coupler_z", 0.3)}, kLoopNumbers, {.mode = Mode::tangent}),
        gradient(with(redundant_loop(), radau), {value_at("coupler_z", 0.3)}, kLoopNumbers, {.mode = Mode::adjoint}),
        gradient(with(redundant_loop(), bdf), {value_at("coupler_z", 0.3)}, kLoopNumbers, {.mode = Mode::tangent}),
        gradient(with(redundant_loop(), bdf), {value_at("coupler_z", 0.3)}, kLoopNumbers, {.mode = Mode::adjoint})}) {
    EXPECT_NE(found.steps, fixed.steps);
    expect_close(found, fixed, kLoopNumbers);
  }
}

/// Long steps correct positions by much, along rows of the middle stage that turn with it.
TEST(MethodGradients, RadauBackwardsTurnsItsCorrections) {
  struct Swung {
    ParametricScene scene;
    std::vector<Quantity> quantities;
    std::vector<DesignParameter> parameters;
  };
  for (const Swung& s : {Swung{tumbling_top(), kTumbled, kTopNumbers}, Swung{pendulum(), kSwing, kPendulumNumbers},
                         Swung{redundant_loop(), {value_at("coupler_z", 0.3)}, kLoopNumbers}})
    for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-6}) {
      const ParametricScene scene = with(s.scene, [=] {
        return std::make_unique<Radau>(Radau::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
      });
      expect_close(gradient(scene, s.quantities, s.parameters, {.mode = Mode::adjoint}),
                   gradient(scene, s.quantities, s.parameters, {.mode = Mode::tangent}), s.parameters,
                   std::max(1e-8, 2e-4 * tolerance));
    }
}

TEST(MethodGradients, LeaveTheRunItsBits) {
  for (const MakeIntegrator& integrator :
       {runge_kutta(Method::dormand_prince5, 5e-3), exact_radau(5e-3), exact_bdf(5e-3)})
    expect_bits_of_the_run(with(redundant_loop(), integrator), kLoopNumbers, {"coupler_z", "angle"});
}

/// Records of steps are made again with the stretches.
TEST(MethodGradients, RunStretchesAgainWhereMemoryIsShort) {
  const std::vector<Quantity> quantities{value_at("coupler_z", 0.3)};
  for (const MakeIntegrator& integrator : {exact_radau(3e-3), exact_bdf(3e-3)}) {
    const ParametricScene scene = with(redundant_loop(), integrator);
    for (const auto mode : {GradientOptions::Mode::tangent, GradientOptions::Mode::adjoint}) {
      const Gradient all = gradient(scene, quantities, kLoopNumbers, {.mode = mode});
      const Gradient some = gradient(scene, quantities, kLoopNumbers, {.mode = mode, .memory = 200000});
      EXPECT_EQ(all.stretches, 1);
      EXPECT_GE(some.stretches, 3);
      EXPECT_EQ(all.derivatives, some.derivatives);
    }
  }
}

TEST(MethodGradients, RefuseByName) {
  const auto refusal = [](const ParametricScene& scene, GradientOptions::Mode mode) -> std::string {
    try {
      gradient(scene, {value_at("tip_x", 0.1)}, kPendulumNumbers, {.mode = mode});
    } catch (const SceneError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_NE(refusal(with(pendulum(), [] { return std::make_unique<Rattle>(Rattle::Parameters{.step = 1e-2}); }),
                    Mode::tangent)
                .find("cannot be differentiated"),
            std::string::npos);
  EXPECT_NE(
      refusal(with(pendulum(), runge_kutta(Method::dormand_prince5, 1e-2)), Mode::adjoint).find("forward dynamics"),
      std::string::npos);
}

}  // namespace
}  // namespace lithe::test
