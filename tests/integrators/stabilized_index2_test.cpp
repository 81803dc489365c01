// The implicit form that IDA integrates: residual at a consistent state, Jacobian against differences, redundant rows.
#include "integrators/stabilized_index2.h"

#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/motion/projection.h"
#include "joints/forces/spring_damper.h"
#include "joints/revolute_joint.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"
#include "tests/support/scenes.h"

namespace lithe::test::stabilized_index2_test {
namespace {

/// Planar four-bar of spatial revolute joints (three rows repeat others) with a spring along its diagonal.
Scene four_bar(double damping = 3) {
  return Scene({0, 0, -9.81}, [&](SystemGraph& graph) {
    const Matrix3 y = rotation_about(Vector3::UnitX(), -M_PI / 2);  // marker's z along -y
    const auto link = [&](const char* name, const Vector3& from, const Vector3& to) -> RigidBody& {
      return graph.add<RigidBody>(name, {.mass = 1, .inertia = {0.1, 0.2, 0.15}, .position = (from + to) / 2});
    };
    const Vector3 A(0, 0, 0), B(0.3, 0, 1), C(1.5, 0, 1.2), D(1.2, 0, 0);
    auto &left = link("left", A, B), &top = link("top", B, C), &right = link("right", C, D);
    graph.add<RevoluteJoint>("A", {graph.ground().marker(A, y), left.marker(A - (A + B) / 2, y)});
    graph.add<RevoluteJoint>("B", {left.marker(B - (A + B) / 2, y), top.marker(B - (B + C) / 2, y)});
    graph.add<RevoluteJoint>("C", {top.marker(C - (B + C) / 2, y), right.marker(C - (C + D) / 2, y)});
    graph.add<RevoluteJoint>("D", {graph.ground().marker(D, y), right.marker(D - (C + D) / 2, y)});
    graph.add<SpringDamper>("spring", {graph.ground().marker(A), top.marker(C - (B + C) / 2)},
                            {.stiffness = 40, .damping = damping});
  });
}

TEST(StabilizedIndex2, VanishesAtAConsistentState) {
  Scene scene = four_bar();
  ASSERT_EQ(scene.equations.redundant_rows().size(), 3u);
  scene.state.v_dot.setZero(18);
  scene.state.lambda.setZero(20);
  Projector(scene.equations).accelerations(0, scene.state.q, scene.state.v, scene.state.v_dot, scene.state.lambda);
  StabilizedIndex2 form(scene.equations);
  VectorX y(form.size()), y_dot(form.size()), F(form.size());
  form.pack(scene.state, y, y_dot);
  form.residual(0, y, y_dot, F);
  EXPECT_LT(F.cwiseAbs().maxCoeff(), 1e-11);
  State back = scene.state;
  form.unpack(y, y_dot, back);
  EXPECT_LT((back.q - scene.state.q).norm() + (back.v_dot - scene.state.v_dot).norm(), 1e-14);
}

void check_jacobian(double damping, double speed) {
  Scene scene = four_bar(damping);
  StabilizedIndex2 form(scene.equations);
  const int n = form.size(), nv = scene.system.layout().v_count(), rows = scene.system.layout().row_count();
  RandomNumbers random(3);
  // u = v and μ = 0, where the terms that are left out vanish; quaternions off their norm, all else anywhere.
  VectorX y(n), y_dot(n);
  scene.state.v = random.vector(nv, speed);
  scene.state.v_dot = random.vector(nv, 5);
  scene.state.lambda = random.vector(rows, 10);
  for (int row : scene.equations.redundant_rows()) scene.state.lambda[row] = 0;
  form.pack(scene.state, y, y_dot);
  for (const auto& b : scene.system.layout().bodies()) {
    y.segment<4>(b.q + 3) *= 1.02;
    y_dot.segment<4>(b.q + 3) *= 1.02;
  }
  const double c = 37;
  form.jacobian(0, y, y_dot, c, nullptr);
  std::vector<double> values(form.row_indices().size());
  form.jacobian(0, y, y_dot, c, values.data());
  MatrixX J = MatrixX::Zero(n, n), differences(n, n);
  for (int k = 0; k < n; ++k)
    for (int i = form.column_starts()[k]; i < form.column_starts()[k + 1]; ++i) J(form.row_indices()[i], k) = values[i];
  for (int k = 0; k < n; ++k)
    differences.col(k) = derivative(
        [&](double t) -> VectorX {
          VectorX F(n);
          form.residual(0, y + t * VectorX::Unit(n, k), y_dot + c * t * VectorX::Unit(n, k), F);
          return F;
        },
        1e-4);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < n; ++k)
      EXPECT_NEAR(J(i, k), differences(i, k), 1e-5 * (1 + std::abs(differences(i, k))))
          << "row " << i << ", " << form.name(k);
}

TEST(StabilizedIndex2, HasTheJacobianOfItsResidual) {
  // What a damper's direction changes with q is left out by the engine: checked at rest, or moving without a damper.
  check_jacobian(3, 0);
  check_jacobian(0, 1);
}

TEST(StabilizedIndex2, BearsRedundantRows) {
  Scene scene = four_bar(), exact = four_bar();
  scene.run(*ida(1e-9), 1);
  exact.run(*runge_kutta(1e-11), 1);
  EXPECT_LT((scene.state.q - exact.state.q).norm(), 1e-6);
  EXPECT_LT(scene.violation(Level::position), 1e-8);
}

TEST(StabilizedIndex2, NamesItsUnknowns) {
  Scene scene = mass_chain({0.5, 0.5});
  StabilizedIndex2 form(scene.equations);
  EXPECT_EQ(form.name(0), "mass 1: p_x");
  EXPECT_EQ(form.name(5), "mass 1: omega_y");  // e = (w, x, y, z) from 3 on
  EXPECT_EQ(form.name(7), "mass 2: p_x");
  EXPECT_EQ(form.name(14 + 6 + 2), "mass 2: p_z");
  EXPECT_EQ(form.name(14 + 12 + 1), "the multiplier of 'rod 2' row 1");
}

}  // namespace
}  // namespace lithe::test::stabilized_index2_test
