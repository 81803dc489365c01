#include "engine/base/lane_rotations.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "tests/support/methods.h"
#include "tests/support/motion.h"

/// Registers of four beside Eigen's small vectors and matrices.
namespace lithe::test::lanes_test {
namespace {

Matrix3 matrix(const lanes::Columns& A) {
  Matrix3 out;
  lanes::store3x3(A, out.data());
  return out;
}

TEST(Lanes, HaveTheProductsOfVectorsAndMatrices) {
  RandomNumbers random(3);
  for (int k = 0; k < 20; ++k) {
    const Vector3 a = random.vector3(), b = random.vector3();
    const Matrix3 A = random.matrix3x(3), B = random.matrix3x(3);
    const Lanes x = lanes::of(a), y = lanes::load3(b.data());
    const lanes::Columns X = lanes::columns(A), Y = lanes::load3x3(B.data());
    const auto expect = [](const char* what, const MatrixX& left, const MatrixX& right) {
      expect_below(what, (left - right).norm() / right.norm(), 4e-15);
    };
    expect("a × b", lanes::vector(lanes::cross(x, y)), a.cross(b));
    expect("A b", lanes::vector(X * y), A * b);
    expect("Aᵀ b", lanes::vector(X.transposed_times(y)), A.transpose() * b);
    expect("A B", matrix(X * Y), A * B);
    expect("Aᵀ", matrix(lanes::transposed(X)), A.transpose());
    expect("a~", matrix(lanes::skewed(x)), skew(a));
    expect("a bᵀ", matrix(lanes::dyad(x, y)), a * b.transpose());
    expect("A - 2 E", matrix(X - lanes::scalar(2)), A - 2 * Matrix3::Identity());
    const double condition = A.norm() * A.inverse().norm();
    expect_below("A⁻¹", (matrix(lanes::inverse(X)) * A - Matrix3::Identity()).norm() / condition, 2e-15);
  }
}

TEST(Lanes, TurnAsQuaternionsDo) {
  RandomNumbers random(5);
  for (const double size : {1e-9, 1e-3, 0.3, 1.0, 3.0})  // both sides of where the series end
    for (int k = 0; k < 10; ++k) {
      const Vector4 e = quaternion_of(random.rotation());
      const Vector3 psi = random.vector3(size), omega = random.vector3();
      const Matrix3 K = random.matrix3x(3);
      Vector4 turned;
      lanes::store4(lanes::rotated(lanes::load4(e.data()), lanes::of(psi)), turned.data());
      expect_below("e ∘ exp ψ", (turned - rotated(e, psi)).norm(), 2e-15);
      expect_below("A", (matrix(lanes::rotation_columns(e.data())) - rotation_matrix(e)).norm(), 2e-15);
      expect_below("Jr⁻¹ ω",
                   (lanes::vector(lanes::chart_rate(lanes::of(psi), lanes::of(omega))) - chart_rate(psi, omega)).norm(),
                   1e-14);
      expect_below(
          "K Jr⁻¹",
          (matrix(lanes::times_chart(lanes::columns(K), lanes::of(psi))) - K * right_jacobian_inverse(psi)).norm(),
          2e-14);
    }
}

}  // namespace
}  // namespace lithe::test::lanes_test
