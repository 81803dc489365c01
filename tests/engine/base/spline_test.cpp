#include "engine/base/spline.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/base/error.h"
#include "engine/model/tension_law.h"
#include "tests/support/motion.h"

namespace lithe::test::spline_test {
namespace {

const std::vector<double> kX = {-1, -0.4, 0.1, 0.5, 1.7}, kY = {2, -1, 0.5, 0.7, -3};

TEST(CubicSpline, MeetsItsPointsAndIsStraightBeyondThem) {
  const CubicSpline spline(kX, kY, "test");
  for (std::size_t i = 0; i < kX.size(); ++i) EXPECT_NEAR(spline(kX[i]).value, kY[i], 1e-14);
  for (double end : {-1.0, 1.7}) {
    const auto at = spline(end), beyond = spline(end + std::copysign(2, end));
    EXPECT_NEAR(at.curvature, 0, 1e-13);
    EXPECT_NEAR(beyond.slope, at.slope, 1e-13);
    EXPECT_EQ(beyond.curvature, 0);
    EXPECT_NEAR(beyond.value, at.value + std::copysign(2, end) * at.slope, 1e-13);
  }
}

TEST(CubicSpline, HasTheDerivativesOfItsValueAndTheValueAsDerivativeOfItsIntegral) {
  const CubicSpline spline(kX, kY, "test");
  for (double x : {-2.0, -0.9, -0.4001, -0.2, 0.3, 0.7, 1.5, 2.5}) {
    EXPECT_NEAR(spline(x).slope, derivative([&](double h) { return spline(x + h).value; }, 1e-5), 1e-8) << x;
    EXPECT_NEAR(spline(x).curvature, derivative([&](double h) { return spline(x + h).slope; }, 1e-5), 1e-8) << x;
    EXPECT_NEAR(spline(x).value, derivative([&](double h) { return spline(x + h).integral; }, 1e-5), 1e-8) << x;
  }
  EXPECT_NEAR(spline(-1).integral, 0, 1e-15);  // where it begins; round-off of terms of size 0.1
}

TEST(CubicSpline, IsSmoothAtItsPoints) {
  const CubicSpline spline(kX, kY, "test");
  for (double x : kX) {
    const auto before = spline(x - 1e-12), after = spline(x + 1e-12);
    EXPECT_NEAR(before.value, after.value, 1e-10);
    EXPECT_NEAR(before.slope, after.slope, 1e-9);
    EXPECT_NEAR(before.curvature, after.curvature, 1e-9);
    EXPECT_NEAR(before.integral, after.integral, 1e-10);
  }
}

/// The natural spline is the exact interpolant of a straight line, and of a cubic whose ends do not bend.
TEST(CubicSpline, KeepsStraightLinesAndConvergesToSmoothCurves) {
  const CubicSpline line({0, 3}, {1, 7}, "test");
  EXPECT_NEAR(line(1).value, 3, 1e-14);
  EXPECT_NEAR(line(1).integral, 2, 1e-14);
  std::vector<double> x, y;
  for (int i = 0; i <= 100; ++i) x.push_back(M_PI * i / 100), y.push_back(std::sin(M_PI * i / 100));
  const CubicSpline sine(x, y, "test");  // sin'' = 0 at both ends
  EXPECT_NEAR(sine(1.2345).value, std::sin(1.2345), 1e-7);
  EXPECT_NEAR(sine(1.2345).slope, std::cos(1.2345), 1e-5);
  EXPECT_NEAR(sine(M_PI).integral, 2, 1e-7);
}

TEST(CubicSpline, RefusesTablesThatAreNone) {
  const auto message = [](std::vector<double> x, std::vector<double> y) -> std::string {
    try {
      CubicSpline(std::move(x), std::move(y), "my table");
    } catch (const SceneError& error) {
      EXPECT_EQ(error.where(), "my table");
      EXPECT_FALSE(error.fix().empty());
      return error.problem();
    }
    ADD_FAILURE() << "no error";
    return "";
  };
  EXPECT_NE(message({1}, {1}).find("1 abscissae"), std::string::npos);
  EXPECT_NE(message({1, 2}, {1, 2, 3}).find("3 values"), std::string::npos);
  EXPECT_NE(message({1, 3, 2}, {1, 2, 3}).find("point 3"), std::string::npos);
  EXPECT_NE(message({1, 1}, {1, 2}).find("point 2"), std::string::npos);
  EXPECT_NE(message({1, std::nan("")}, {1, 2}).find("point 2"), std::string::npos);
  EXPECT_NE(message({1, 2}, {std::nan(""), 2}).find("value 1"), std::string::npos);
}

TEST(TabulatedSpring, HasTheStiffnessAndEnergyOfItsForce) {
  const TensionLaw law = tabulated_spring(kX, kY, 0.3);
  for (double x : {-1.5, -0.2, 0.9, 2.0}) {
    const Tension at = law(x, 2);
    EXPECT_NEAR(at.force, law(x, 0).force + 0.6, 1e-14);
    EXPECT_EQ(at.damping, 0.3);
    EXPECT_NEAR(at.stiffness, derivative([&](double h) { return law(x + h, 2).force; }, 1e-5), 1e-8);
    EXPECT_NEAR(law(x, 0).force, derivative([&](double h) { return law(x + h, 0).energy; }, 1e-5), 1e-8);
  }
}

}  // namespace
}  // namespace lithe::test::spline_test
