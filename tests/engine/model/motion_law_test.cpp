#include "engine/model/motion_law.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/base/error.h"
#include "tests/support/motion.h"

namespace lithe::test::motion_law_test {
namespace {

TEST(MotionLaws, HaveTheDerivativesOfTheirValues) {
  const std::vector<std::pair<std::string, MotionLaw>> laws = {
      {"constant", constant(3)},
      {"ramp", ramp(2, -4)},
      {"harmonic", harmonic(2, 3, 0.4, 1)},
      {"smooth step", smooth_step(1, -2, 0.5, 2)},
      {"run-up", run_up(3, 0.3, 1.7)},
      {"tabulated", tabulated({0, 0.6, 1.1, 2.2}, {1, -1, 0.5, 2})},
      {"sum", ramp(1, 2) + harmonic(0.5, 7)},
  };
  for (const auto& [name, law] : laws)
    for (double t : {-0.3, 0.2, 0.77, 1.4, 1.9, 3.0}) {
      SCOPED_TRACE(name + " at " + std::to_string(t));
      const auto motion = [&, &f = law](double h) { return f(t + h); };
      EXPECT_NEAR(motion(0).rate, derivative([&](double h) { return motion(h).value; }, 1e-4), 1e-9);
      EXPECT_NEAR(motion(0).acceleration, derivative([&](double h) { return motion(h).rate; }, 1e-4), 1e-9);
    }
}

TEST(MotionLaws, AreWhatTheirNamesSay) {
  EXPECT_EQ(constant(3)(7).value, 3);
  EXPECT_EQ(ramp(2, -4)(1.5).value, -4);
  EXPECT_NEAR(harmonic(2, M_PI, M_PI / 2, 1)(1).value, -1, 1e-14);
  EXPECT_NEAR((ramp(1, 2) + constant(5))(3).value, 12, 1e-14);
  EXPECT_NEAR(tabulated({0, 1, 2}, {3, 4, 1})(1).value, 4, 1e-14);
}

/// At rest before and after, without a jump of the acceleration; half way at half time.
TEST(SmoothStep, LeavesAndArrivesWithoutAJerk) {
  const MotionLaw step = smooth_step(1, 5, 2, 4);
  for (double t : {-1.0, 2.0, 4.0, 9.0}) {
    EXPECT_EQ(step(t).value, t < 3 ? 1 : 5) << t;
    EXPECT_EQ(step(t).rate, 0) << t;
    EXPECT_EQ(step(t).acceleration, 0) << t;
  }
  EXPECT_NEAR(step(3).value, 3, 1e-14);
  EXPECT_NEAR(step(3).rate, 1.875 * 4 / 2, 1e-14);
  EXPECT_NEAR(step(2 + 1e-9).acceleration, 0, 1e-6);
}

/// The area below the rate, a smooth step; full turns from then on.
TEST(RunUp, TurnsByTheMeanOfItsRatesAndThenByItsRate) {
  const MotionLaw run = run_up(6, 1, 3);
  for (double t : {-1.0, 1.0}) EXPECT_EQ(run(t).value, 0) << t;
  EXPECT_NEAR(run(2).rate, 3, 1e-14);
  EXPECT_NEAR(run(3).value, 6, 1e-14);
  EXPECT_NEAR(run(4.5).value, 6 + 1.5 * 6, 1e-14);
  EXPECT_EQ(run(4.5).rate, 6);
  EXPECT_EQ(run(4.5).acceleration, 0);
}

TEST(MotionLaws, RefuseTimesThatDoNotRun) {
  EXPECT_THROW(run_up(1, 2, 2), SceneError);
  EXPECT_THROW(smooth_step(0, 1, 2, 2), SceneError);
  EXPECT_THROW(smooth_step(0, 1, 2, std::nan("")), SceneError);
  EXPECT_THROW(tabulated({0, 0}, {1, 2}), SceneError);
  EXPECT_THROW(tabulated({0}, {1}), SceneError);
}

}  // namespace
}  // namespace lithe::test::motion_law_test
