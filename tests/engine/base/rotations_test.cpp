#include <gtest/gtest.h>

#include <Eigen/SVD>

#include "bodies/rigid_body.h"
#include "engine/base/error.h"
#include "engine/base/rotations.h"
#include "engine/model/system_graph.h"
#include "tests/support/motion.h"

namespace lithe::test::rotations_test {
namespace {

/// Elementary rotations, written out.
Matrix3 about_x(double a) {
  return (Matrix3() << 1, 0, 0, 0, std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a)).finished();
}
Matrix3 about_y(double a) {
  return (Matrix3() << std::cos(a), 0, std::sin(a), 0, 1, 0, -std::sin(a), 0, std::cos(a)).finished();
}
Matrix3 about_z(double a) {
  return (Matrix3() << std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a), 0, 0, 0, 1).finished();
}

TEST(Rotations, EulerAnglesTurnAboutTheAxesThatTurnAlong) {
  RandomNumbers random(5);
  for (int i = 0; i < 20; ++i) {
    const double a = random.number(3), b = random.number(3), c = random.number(3);
    EXPECT_LT((rotation_from_euler_313(a, b, c) - about_z(a) * about_x(b) * about_z(c)).norm(), 1e-15 * 4);
    EXPECT_LT((rotation_from_euler_321(a, b, c) - about_z(a) * about_y(b) * about_x(c)).norm(), 1e-15 * 4);
    // Turned one after the other about axes as they stand then.
    Matrix3 R = rotation_about({0, 0, 1}, a);
    R = rotation_about(R.col(0), b) * R;
    R = rotation_about(R.col(2), c) * R;
    EXPECT_LT((rotation_from_euler_313(a, b, c) - R).norm(), 1e-14);
    R = rotation_about({0, 0, 1}, a);
    R = rotation_about(R.col(1), b) * R;
    R = rotation_about(R.col(0), c) * R;
    EXPECT_LT((rotation_from_euler_321(a, b, c) - R).norm(), 1e-14);
  }
}

/// Nutation takes the spin axis from z: with precession ψ and nutation θ it is (sin ψ sin θ, -cos ψ sin θ, cos θ). Yaw
/// and pitch aim x at (cos ψ cos θ, sin ψ cos θ, -sin θ).
TEST(Rotations, EulerAnglesAimTheAxesOfTheBooks) {
  const double psi = 0.4, theta = 1.1, phi = -0.8;
  EXPECT_LT((rotation_from_euler_313(psi, theta, phi).col(2) -
             Vector3(std::sin(psi) * std::sin(theta), -std::cos(psi) * std::sin(theta), std::cos(theta)))
                .norm(),
            1e-15);
  EXPECT_LT((rotation_from_euler_321(psi, theta, phi).col(0) -
             Vector3(std::cos(psi) * std::cos(theta), std::sin(psi) * std::cos(theta), -std::sin(theta)))
                .norm(),
            1e-15);
}

Matrix3 printed(const Matrix3& R, double unit) { return unit * (R / unit).array().round(); }

TEST(Rotations, OfSixPrintedDigitsAreTheNearestOnes) {
  RandomNumbers random(7);
  for (int i = 0; i < 50; ++i) {
    const Matrix3 R = random.rotation();
    for (double unit : {1e-6, 2e-5}) {
      const Matrix3 P = printed(R, unit), Q = nearest_rotation(P);
      EXPECT_LT((Q.transpose() * Q - Matrix3::Identity()).norm(), 2e-15);
      EXPECT_GT(Q.determinant(), 0);
      EXPECT_LT((Q - R).norm(), 2 * unit);
      // Singular values are another way to the same matrix.
      const Eigen::JacobiSVD<Matrix3> svd(P, Eigen::ComputeFullU | Eigen::ComputeFullV);
      EXPECT_LT((Q - svd.matrixU() * svd.matrixV().transpose()).norm(), 5e-15);
    }
  }
  // A body takes it as it is, and refuses what was printed.
  SystemGraph graph;
  const Matrix3 P = printed(rotation_about({1, 2, 3}, 0.7), 1e-6);
  EXPECT_NO_THROW(graph.add<RigidBody>("body", {.orientation = nearest_rotation(P)}));
  EXPECT_THROW(graph.add<RigidBody>("other", {.orientation = P}), SceneError);
}

std::string problem_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const SceneError& error) {
    return error.problem();
  }
  return "nothing was refused";
}

TEST(Rotations, WhatIsNoRotationIsRefused) {
  const Matrix3 R = rotation_about({1, 2, 3}, 0.7);
  EXPECT_NE(problem_of([&] { nearest_rotation(printed(R, 1e-2)); }).find("not a rotation"), std::string::npos);
  EXPECT_NE(problem_of([&] { nearest_rotation(1.001 * R); }).find("0.002"), std::string::npos);
  EXPECT_NE(problem_of([&] { nearest_rotation(-R); }).find("left-handed"), std::string::npos);
  Matrix3 hole = R;
  hole(1, 2) = NAN;
  EXPECT_NE(problem_of([&] { nearest_rotation(hole); }).find("nan"), std::string::npos);
  EXPECT_NE(problem_of([] { axes_along({0, 0, 0}); }).find("zero"), std::string::npos);
  EXPECT_NE(problem_of([] { axes_along({1, 2, 3}, {-2, -4, -6}); }).find("along z"), std::string::npos);
}

TEST(Rotations, AxesAlongALineHaveItAsZ) {
  EXPECT_EQ(axes_along({0, 0, 5}), Matrix3(Matrix3::Identity()));
  RandomNumbers random(3);
  for (int i = 0; i < 20; ++i) {
    const Vector3 z = random.vector3(1e3), x = random.vector3(1e-3);
    for (const Matrix3& R : {axes_along(z), axes_along(z, x)}) {
      EXPECT_LT((R.col(2) - z.normalized()).norm(), 1e-15);
      EXPECT_LT((R.transpose() * R - Matrix3::Identity()).norm(), 1e-15 * 3);
      EXPECT_NEAR(R.determinant(), 1, 1e-14);
    }
    EXPECT_GT(axes_along(z, x).col(0).dot(x), 0);
    EXPECT_NEAR(axes_along(z, x).col(1).dot(x), 0, 1e-17);
  }
}

}  // namespace
}  // namespace lithe::test::rotations_test
