#include "engine/cones/joint_friction_problem.h"

#include <gtest/gtest.h>

#include <random>

#include "engine/base/dense.h"

/// Friction impulses of joints against their own conditions.
namespace lithe::test::joint_friction_problem_test {
namespace {

/// Surfaces of one to three directions, coupled by masses and by their presses.
JointFrictionProblem random_problem(std::mt19937& random, double coupling) {
  std::normal_distribution<double> normal;
  const auto fill = [&](auto& x) {
    for (auto& each : x.reshaped()) each = normal(random);
  };
  JointFrictionProblem problem;
  int rows = 0;
  for (const int count : {1, 2, 3, 1}) {
    auto& surface = problem.surfaces.emplace_back();
    surface.first = rows, surface.count = count;
    surface.load = std::abs(normal(random));
    surface.friction = [](double before, double after) {
      return 0.3 + 0.2 * std::exp(-std::pow((before + after) / 40, 2));
    };
    rows += count;
  }
  for (auto& surface : problem.surfaces) {
    auto& press = surface.presses.emplace_back();
    fill(press.constant);
    press.by.resize(3, rows);
    fill(press.by);
    press.by *= coupling;
  }
  MatrixX A(rows, rows + 2);
  fill(A);
  problem.W = A * A.transpose();
  problem.free.resize(rows), problem.before.resize(rows);
  fill(problem.free), fill(problem.before);
  return problem;
}

TEST(JointFrictionProblem, FindsImpulsesThatMeetCoulombsLaw) {
  std::mt19937 random(7);
  int sticking = 0, sliding = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const JointFrictionProblem problem = random_problem(random, 0.2);
    VectorX p = VectorX::Zero(problem.free.size());
    std::vector<char> sticks;
    const auto result = problem.solve(p, sticks);
    EXPECT_TRUE(result.converged) << trial;
    const VectorX u = problem.W * p + problem.free;
    for (const auto& surface : problem.surfaces) {
      const VectorX own = p.segment(surface.first, surface.count), slides = u.segment(surface.first, surface.count);
      const VectorX before = problem.before.segment(surface.first, surface.count);
      const double N = surface.load + (surface.presses[0].constant + surface.presses[0].by * p).norm();
      if (slides.norm() < 1e-10) {
        ++sticking;
        EXPECT_LE(own.norm(), 0.5 * N * (1 + 1e-9));
        continue;
      }
      ++sliding;
      EXPECT_NEAR(own.dot(slides), -own.norm() * slides.norm(), 1e-9 * own.norm() * slides.norm());
      // Between μ of its end alone, as where it turned back, and of the mean speed.
      const auto mu = surface.friction;
      const double mean = mu(before.norm(), slides.norm()), turned = mu(0, slides.norm());
      EXPECT_LT(std::min(std::abs(own.norm() - mean * N), std::abs(own.norm() - turned * N)), 1e-9 * N);
    }
  }
  EXPECT_GT(sticking, 100);
  EXPECT_GT(sliding, 100);
}

/// N = |c + b p| with μ b > 1: sliding has no solution or two; it sticks.
TEST(JointFrictionProblem, SticksWhereFrictionLoadsItself) {
  for (const double constant : {-1.0, 1.0}) {
    JointFrictionProblem problem;
    auto& surface = problem.surfaces.emplace_back();
    surface.first = 0, surface.count = 1, surface.load = 0;
    surface.friction = [](double, double) { return 0.5; };
    surface.presses.push_back({{constant, 0, 0}, Matrix3X{{3.0}, {0.0}, {0.0}}});
    problem.W = MatrixX{{2.0}};
    problem.free = problem.before = VectorX{{-100.0}};
    VectorX p = VectorX::Zero(1);
    std::vector<char> sticks;
    EXPECT_TRUE(problem.solve(p, sticks).converged);
    EXPECT_NEAR(p[0], 50, 1e-9);
  }
}

/// A driven coordinate has no mobility: its friction is μ N against the way it moves.
TEST(JointFrictionProblem, RubsOnWhatIsDriven) {
  JointFrictionProblem problem;
  auto& surface = problem.surfaces.emplace_back();
  surface.first = 0, surface.count = 1, surface.load = 3;
  surface.friction = [](double, double) { return 0.5; };
  problem.W = MatrixX::Zero(1, 1);
  problem.free = problem.before = VectorX{{2.0}};
  VectorX p = VectorX::Zero(1);
  std::vector<char> sticks;
  EXPECT_TRUE(problem.solve(p, sticks).converged);
  EXPECT_NEAR(p[0], -1.5, 1e-12);
}

}  // namespace
}  // namespace lithe::test::joint_friction_problem_test
