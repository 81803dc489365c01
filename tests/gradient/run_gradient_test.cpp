#include <thread>

#include "bodies/rigid_body.h"
#include "tests/gradient/gradient_scenes.h"

namespace lithe::test {
namespace {

TEST(RunGradient, OfAPendulumByItsMassInertiaLengthAndSpeed) {
  expect_gradient(pendulum(),
                  {value_at("tip_x", 0.6), value_at("tip_z", 0.3137), value_at("v_x", 0.4), integral("tip_z"),
                   integral("tip_x", 0.1, 0.4), smallest("tip_z"), largest("v_x"), value_at("energy", 0.5)},
                  {{"mass", 1.3}, {"inertia", 0.08}, {"length", 0.4}, {"speed", 0.7}});
}

TEST(RunGradient, OfALoopWithRedundantRowsAndItsReactions) {
  expect_gradient(redundant_loop(),
                  {value_at("coupler_z", 0.3), value_at("angle", 0.2), value_at("A_force_x", 0.15),
                   integral("coupler_x"), smallest("coupler_z")},
                  {{"mass", 0.4}, {"offset", 0.02}, {"stiffness", 250}, {"damping", 3}});
}

const std::vector<DesignParameter> kRod{{"thickness", 0.01}, {"E", 7e10}, {"density", 2700}, {"turn", 0.6}};

TEST(RunGradient, OfADrivenRodWithModesByItsSectionAndMaterial) {
  expect_gradient(driven_rod("linear modes", {.modes = {0, 1, 2}}, 6), {value_at("tip_z", 0.2), integral("tip_x")},
                  kRod);
}
TEST(RunGradient, OfAStiffenedRod) {
  expect_gradient(driven_rod("stiffened", {.modes = {0, 1, 2}, .deflection = Deflection::stiffened}, 6),
                  {value_at("tip_z", 0.2), value_at("hub_force_x", 0.1)}, kRod);
}
TEST(RunGradient, OfABeam) {
  expect_gradient(driven_rod("beam", {.deflection = Deflection::exact}, 4), {value_at("tip_z", 0.2), smallest("tip_z")},
                  kRod);
}

TEST(RunGradient, LeavesTheRunItsBits) {
  expect_bits_of_the_run(pendulum(), {{"mass", 1.3}, {"inertia", 0.08}, {"length", 0.4}, {"speed", 0.7}},
                         {"tip_x", "v_z"});
}

TEST(RunGradient, IsTheSameInAnyNumberOfThreads) {
  const std::vector<Quantity> quantities{value_at("tip_x", 0.6)};
  const std::vector<DesignParameter> parameters{{"mass", 1.3}, {"inertia", 0.08}, {"length", 0.4}, {"speed", 0.7}};
  const auto find = [&] { return gradient(pendulum(), quantities, parameters).derivatives; };
  const MatrixX alone = find();
  for (const std::size_t count : {2u, 4u}) {
    std::vector<MatrixX> found(count);
    std::vector<std::thread> threads;
    for (MatrixX& each : found) threads.emplace_back([&] { each = find(); });
    for (std::thread& thread : threads) thread.join();
    for (const MatrixX& each : found) EXPECT_EQ(each, alone);
  }
}

TEST(RunGradient, RunsStretchesAgainWhereMemoryIsShort) {
  const std::vector<Quantity> quantities{value_at("coupler_z", 0.3), largest("angle")};
  const std::vector<DesignParameter> parameters{{"mass", 0.4}, {"offset", 0.02}, {"stiffness", 250}, {"damping", 3}};
  const Gradient all = gradient(redundant_loop(), quantities, parameters, {.mode = GradientOptions::Mode::adjoint});
  const Gradient some =
      gradient(redundant_loop(), quantities, parameters, {.mode = GradientOptions::Mode::adjoint, .memory = 60000});
  EXPECT_EQ(all.stretches, 1);
  EXPECT_GE(some.stretches, 3);
  EXPECT_LE(some.tape_bytes, 90000u);
  EXPECT_EQ(all.derivatives, some.derivatives);
}

TEST(RunGradient, RefusesByNameWhatItCannotDifferentiate) {
  const std::vector<DesignParameter> parameters{{"mass", 1.3}, {"inertia", 0.08}, {"length", 0.4}, {"speed", 0.7}};
  const auto refusal = [&](const ParametricScene& scene, const Quantity& quantity) -> std::string {
    try {
      gradient(scene, {quantity}, parameters);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "none";
  };
  ParametricScene scene = pendulum();
  EXPECT_NE(refusal(scene, value_at("tip_q", 0.1)).find("known are tip_x"), std::string::npos);
  EXPECT_NE(refusal(scene, value_at("tip_x", 0.7)).find("outside the run"), std::string::npos);
  scene.integrator = [] { return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{}); };
  EXPECT_NE(refusal(scene, value_at("tip_x", 0.1)).find("cannot be differentiated"), std::string::npos);
}

}  // namespace
}  // namespace lithe::test
