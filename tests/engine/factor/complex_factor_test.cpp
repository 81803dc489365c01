// The block factor at complex weights against a dense solution of the same equations.
#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/spring_damper.h"
#include "joints/revolute_joint.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"
#include "tests/support/pairs.h"
#include "tests/support/scenes.h"

namespace lithe::test::complex_factor_test {
namespace {

using ComplexMatrix = Eigen::MatrixXcd;

/// The engine's real blocks at these weights: velocities, constraint rows, compliant rows.
MatrixX dense(Evaluator& equations, const TangentWeights& weights, const VectorX& v_dot, const VectorX& lambda) {
  equations.factorize(weights, v_dot, lambda, nullptr);
  int size = 0;
  equations.visit_blocks([&](int row, int, ConstMatrixRef b) { size = std::max<int>(size, row + b.rows()); });
  MatrixX out = MatrixX::Zero(size, size);
  equations.visit_blocks(
      [&](int row, int column, ConstMatrixRef b) { out.block(row, column, b.rows(), b.cols()) = b; });
  return out;
}

/// [S Gᵀ; G 0] with the compliant rows eliminated, from K, D and M apart.
ComplexMatrix expected(Evaluator& equations, const ComplexTangentWeights& w, const VectorX& v_dot,
                       const VectorX& lambda) {
  const int nv = equations.layout().v_count(), n = nv + equations.layout().row_count();
  const MatrixX K_M = dense(equations, {1, 0, 1}, v_dot, lambda), D_M = dense(equations, {0, 1, 1}, v_dot, lambda),
                M = dense(equations, {0, 0, 1}, v_dot, lambda);
  ComplexMatrix A = M.topLeftCorner(n, n).cast<std::complex<double>>();
  A.topLeftCorner(nv, nv) *= w.acceleration;
  A.topLeftCorner(nv, nv) +=
      w.position * (K_M - M).topLeftCorner(nv, nv) + w.velocity * (D_M - M).topLeftCorner(nv, nv);
  for (int i = n; i < M.rows(); ++i) {
    const double k = K_M(i, i) < -1e29 ? 0 : -1 / K_M(i, i), d = D_M(i, i) < -1e29 ? 0 : -1 / D_M(i, i);
    const VectorX G = M.col(i).head(nv);
    A.topLeftCorner(nv, nv) += (w.position * k + w.velocity * d) * G * G.transpose();
    // A tension that knows λ: its share stands over the row's compliance.
    A.topRightCorner(nv, n - nv) -= G * (D_M.row(i).segment(nv, n - nv) / D_M(i, i));
  }
  return A;
}

double solution_error(Evaluator& equations, const State& state) {
  RandomNumbers random(7);
  const int nv = equations.layout().v_count(), rows = equations.layout().row_count();
  const VectorX v_dot = random.vector(nv), lambda = random.vector(rows);
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  VectorX r(nv);
  equations.residual(v_dot, lambda, r);
  const std::complex<double> s(300, 220);
  const ComplexTangentWeights weights{1, s, s * s};
  const ComplexMatrix A = expected(equations, weights, v_dot, lambda);
  ComplexVectorX x(nv + rows);
  for (auto& value : x) value = {random.number(), random.number()};
  const ComplexVectorX b = A * x;
  ComplexVectorX rv = b.head(nv), rl = b.tail(rows);
  equations.parts().complex_factor->factorize_complex(weights, v_dot, lambda, nullptr);
  equations.parts().complex_factor->solve_complex(rv, rl);
  return std::max((rv - x.head(nv)).cwiseAbs().maxCoeff(), rows > 0 ? (rl - x.tail(rows)).cwiseAbs().maxCoeff() : 0.0) /
         x.cwiseAbs().maxCoeff();
}

TEST(ComplexFactor, SolvesRigidChainsAsDenseAlgebraDoes) {
  for (bool revolute : {false, true}) {
    Scene chain = box_chain(5, revolute);
    expect_below("complex factor, chain of five, relative error", solution_error(chain.equations, chain.state), 1e-9);
  }
}

TEST(ComplexFactor, SolvesRigidReducedAndNodalBodies) {
  for (const Pair& pair : pairs()) {
    Scene scene({0, 0, -9.81}, [&](SystemGraph& graph) {
      graph.add<RevoluteJoint>("pin", pair.draw(graph, {0, 0, 0}));
    });
    expect_below("complex factor, " + pair.name + ", relative error", solution_error(scene.equations, scene.state),
                 1e-8);
  }
}

TEST(ComplexFactor, LeavesTheRealFactorAlone) {
  Scene chain = box_chain(3, true);
  const VectorX zero = VectorX::Zero(18), none = VectorX::Zero(15);
  chain.equations.evaluate(0, chain.state.q, chain.state.v, Level::velocity);
  chain.equations.factorize({1, 10, 100}, zero, none, nullptr);
  VectorX a = VectorX::Ones(18), la = VectorX::Ones(15), b = a, lb = la;
  chain.equations.solve(a, la);
  chain.equations.parts().complex_factor->factorize_complex({1, {10, 5}, {75, 100}}, zero, none, nullptr);
  chain.equations.solve(b, lb);
  EXPECT_EQ(a, b);
  EXPECT_EQ(la, lb);
}

TEST(ComplexFactor, KnowsSpringsAndFriction) {
  Scene scene({0, 0, -9.81}, [](SystemGraph& graph) {
    auto& arm = graph.add<RigidBody>("arm", {.mass = 2, .inertia = {0.1, 0.2, 0.2}, .position = {0.5, 0, 0}});
    auto& bob = graph.add<RigidBody>("bob", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = {1.5, 0, 0.1}});
    const Matrix3 axis = rotation_about({1, 0, 0}, M_PI / 2);
    auto& pin =
        graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, axis), arm.marker({-0.5, 0, 0}, axis)});
    graph.add<JointFriction>("rub", {pin.angle()}, {.joint = &pin, .coefficient = 0.2, .viscous = 0.1, .radius = 0.05});
    graph.add<SpringDamper>("spring", {arm.marker({0.5, 0, 0}), bob.marker()},
                            {.stiffness = 5e4, .damping = 30, .natural_length = 0.9});
  });
  scene.state.v[4] = 0.01, scene.state.v[10] = 0.7;
  expect_below("complex factor, spring and friction, relative error", solution_error(scene.equations, scene.state),
               1e-9);
}

}  // namespace
}  // namespace lithe::test::complex_factor_test
