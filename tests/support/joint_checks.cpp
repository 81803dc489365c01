#include "tests/support/joint_checks.h"

#include "engine/assembly/evaluator.h"
#include "tests/support/dense.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/motion.h"

namespace lithe::test {
namespace {

constexpr int kStates = 3;

testing::AssertionResult close(const MatrixX& actual, const MatrixX& expected, double tolerance) {
  if (actual.rows() != expected.rows() || actual.cols() != expected.cols())
    return testing::AssertionFailure() << actual.rows() << "x" << actual.cols() << " instead of " << expected.rows()
                                       << "x" << expected.cols();
  if (expected.size() == 0) return testing::AssertionSuccess();
  const double scale = 1 + expected.cwiseAbs().maxCoeff();
  Eigen::Index row, column;
  const double error = (actual - expected).cwiseAbs().maxCoeff(&row, &column) / scale;
  if (error <= tolerance) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "relative error " << error << " at (" << row << ", " << column
                                     << "): " << actual(row, column) << " instead of " << expected(row, column);
}

/// 1 at the velocities of frames, 0 at linear coordinates.
VectorX frame_mask(const Layout& layout) {
  VectorX mask = VectorX::Zero(layout.v_count());
  for (const auto& b : layout.bodies())
    if (b.frame) mask.segment<6>(b.v).setOnes();
  return mask;
}
MatrixX on_frames(const Layout& layout, const MatrixX& S) {
  const VectorX mask = frame_mask(layout);
  return mask.asDiagonal() * S * mask.asDiagonal();
}

/// An evaluator at random states.
struct Probe {
  Probe(SystemGraph& graph, unsigned seed) : system(assemble(graph)), evaluator(system), random(seed) {}

  void draw_state() {
    const State& start = system.initial_state();
    q = start.q;
    layout().retract(start.q, random.vector(layout().v_count(), 0.4), q);
    v = random.vector(layout().v_count(), 2);
    a = random.vector(layout().v_count(), 3);
    time = random.number();
  }
  const Layout& layout() const { return system.layout(); }
  VectorX no_motion() const { return VectorX::Zero(layout().v_count()); }
  VectorX no_load() const { return VectorX::Zero(layout().row_count()); }

  VectorX constraint(double t, const VectorX& at, const VectorX& moving, Level which) {
    evaluator.evaluate(t, at, moving, which);
    VectorX out(layout().row_count());
    evaluator.constraint(which, out);
    return out;
  }
  VectorX residual(double t, const VectorX& at, const VectorX& moving, const VectorX& lambda) {
    evaluator.evaluate(t, at, moving, Level::velocity);
    VectorX out = no_motion();
    evaluator.residual(no_motion(), lambda, out);
    return out;
  }
  /// The iteration matrix at this state, its blocks dense.
  DenseMatrix matrix(const TangentWeights& weights, const VectorX& at, const VectorX& moving, const VectorX& lambda) {
    evaluator.evaluate(time, at, moving, Level::acceleration);
    evaluator.factorize(weights, no_motion(), lambda, nullptr);
    return dense(evaluator);
  }

  const System system;
  Evaluator evaluator;
  RandomNumbers random;
  VectorX q, v, a;
  double time = 0;
};

}  // namespace

void check_joint(SystemGraph& graph, const Constraint& joint, const JointExpectation& expected) {
  SCOPED_TRACE("joint '" + joint.name() + "'");
  Probe p(graph, 7);
  const double h = expected.difference;
  const auto [name, first, count] = p.system.rows(joint);
  EXPECT_EQ(count, joint.row_count());
  const auto rows = [first, count](const MatrixX& all) -> MatrixX { return all.middleRows(first, count); };

  std::vector<int> rolling;  // rows on velocities alone
  for (int row : p.system.velocity_rows())
    if (row >= first && row < first + count) rolling.push_back(row - first);

  const VectorX start = p.system.initial_state().q;
  EXPECT_EQ(rank(rows(p.matrix({0, 0, 1}, start, p.no_motion(), p.no_load()).G())), expected.rank) << "as drawn";
  if (graph.constraints().size() == 1) {
    EXPECT_EQ(p.system.rank(), expected.rank) << "found by assemble()";
  }
  for (int k = 0; k < kStates; ++k) {
    p.draw_state();
    const MatrixX G = rows(p.matrix({0, 0, 1}, p.q, p.v, p.no_load()).G());
    const VectorX gamma = rows(p.constraint(p.time, p.q, p.v, Level::acceleration));
    const VectorX g_dot = rows(p.constraint(p.time, p.q, p.v, Level::velocity));

    MatrixX differenced = jacobian(
        p.layout(), p.q,
        [&](const VectorX& q) -> VectorX { return rows(p.constraint(p.time, q, p.v, Level::position)); }, h);
    for (int row : rolling) {  // no g: g_dot is linear in v, and what it grows by is G
      EXPECT_EQ(differenced.row(row).norm(), 0) << "a row on velocities has no residual";
      for (int j = 0; j < differenced.cols(); ++j)
        differenced(row, j) = derivative([&](double x) {
          return rows(p.constraint(p.time, p.q, p.v + x * VectorX::Unit(p.v.size(), j), Level::velocity))(row, 0);
        });
    }
    EXPECT_TRUE(close(G, differenced, expected.tolerance)) << "G against differences of g";

    const SmoothMotion motion{p.layout(), p.q, p.v, p.a};
    const auto along = [&](double t, Level which) -> VectorX {
      return rows(p.constraint(p.time + t, motion.position(t), motion.velocity(t), which));
    };
    VectorX along_motion = derivative([&](double t) { return along(t, Level::position); }, h);
    for (int row : rolling) along_motion[row] = G.row(row).dot(p.v);
    EXPECT_TRUE(close(g_dot, along_motion, expected.tolerance)) << "g_dot against differences of g along a motion";
    EXPECT_TRUE(
        close(G * p.a - gamma, derivative([&](double t) { return along(t, Level::velocity); }, h), expected.tolerance))
        << "G v_dot - gamma against differences of g_dot along a motion";

    // A velocity that the joint allows, by the engine's own g_dot, and the power of the engine's own Gᵀ lambda.
    const VectorX rate = rows(p.constraint(p.time, p.q, p.no_motion(), Level::velocity));
    const VectorX allowed = p.v - least_norm(G, g_dot - rate);
    EXPECT_TRUE(close(rows(p.constraint(p.time, p.q, allowed, Level::velocity)), rate, 1e-11));
    VectorX lambda = p.no_load();
    lambda.segment(first, count) = p.random.vector(count, 5);
    const auto load = [&](const VectorX& q) -> VectorX {
      return p.residual(p.time, q, p.no_motion(), lambda) - p.residual(p.time, q, p.no_motion(), p.no_load());
    };
    const VectorX Gt_lambda = load(p.q);
    EXPECT_NEAR(Gt_lambda.dot(allowed), 0, 1e-11 * (1 + Gt_lambda.norm() * allowed.norm())) << "work on allowed motion";

    const MatrixX stiffness =
        p.matrix({1, 0, 1}, p.q, p.no_motion(), lambda).S() - p.matrix({1, 0, 1}, p.q, p.no_motion(), p.no_load()).S();
    EXPECT_TRUE(close(on_frames(p.layout(), stiffness), on_frames(p.layout(), jacobian(p.layout(), p.q, load, h)),
                      expected.tolerance))
        << "stiffness of the loaded joint";
  }
}

void check_force(SystemGraph& graph, const ForceElement& force, const ForceExpectation& expected) {
  SCOPED_TRACE("force '" + force.name() + "'");
  Probe p(graph, 11);
  ASSERT_EQ(graph.forces().size(), expected.parts) << "one force element a scene, so that its own share can be told";
  ASSERT_EQ(graph.forces()[0].force, &force);

  // Generalized force and potential of the element alone.
  const auto generalized = [&](const VectorX& q, const VectorX& v) -> VectorX {
    const DenseMatrix m = p.matrix({0, 0, 1}, q, v, p.no_load());
    return p.evaluator.workspace().load - m.compliant_G().transpose() * p.evaluator.workspace().tension;
  };
  const auto potential = [&](const VectorX& q) -> VectorX {
    p.evaluator.evaluate(p.time, q, p.no_motion(), Level::velocity);
    return p.evaluator.workspace().force_energy;
  };
  // Bodies of several frames have a stiffness of their own there.
  const auto bodies = SystemGraph::part_of(graph);
  for (std::size_t i = 1; i < graph.bodies().size(); ++i) bodies->share(graph.bodies()[i]);
  Probe without(*bodies, 11);
  for (int k = 0; k < kStates; ++k) {
    p.draw_state();
    const VectorX still = p.no_motion(), at_rest = generalized(p.q, still);
    const VectorX in_residual = p.residual(p.time, p.q, still, p.no_load());
    EXPECT_TRUE(in_residual.allFinite());
    if (expected.conservative) {
      EXPECT_TRUE(
          close(-at_rest.transpose(), jacobian(p.layout(), p.q, potential, expected.difference), expected.tolerance))
          << "force against the loss of potential";
      EXPECT_LE((generalized(p.q, p.v) - at_rest).dot(p.v), 1e-12 * at_rest.norm()) << "damping gives power";
    }
    const auto by_position = [&](Probe& scene) -> MatrixX {
      return scene.matrix({1, 0, 1}, p.q, still, scene.no_load()).condensed_S() -
             scene.matrix({0, 0, 1}, p.q, still, scene.no_load()).condensed_S();
    };
    const MatrixX stiffness = by_position(p) - by_position(without);
    const MatrixX differenced = jacobian(
        p.layout(), p.q, [&](const VectorX& q) -> VectorX { return -generalized(q, still); }, expected.difference);
    EXPECT_TRUE(close(on_frames(p.layout(), stiffness), on_frames(p.layout(), differenced), 10 * expected.tolerance))
        << "stiffness of the force";
    if (!expected.exact_damping) continue;
    // With what the bodies themselves owe to velocities.
    const DenseMatrix moving = p.matrix({0, 1, 1}, p.q, p.v, p.no_load());
    const MatrixX damping = moving.condensed_S() - p.matrix({0, 0, 1}, p.q, p.v, p.no_load()).condensed_S();
    MatrixX by_velocity(still.size(), still.size());
    for (int j = 0; j < still.size(); ++j)
      by_velocity.col(j) = derivative(
          [&](double h) { return p.residual(p.time, p.q, p.v + h * VectorX::Unit(still.size(), j), p.no_load()); });
    EXPECT_TRUE(close(on_frames(p.layout(), damping), on_frames(p.layout(), by_velocity), 10 * expected.tolerance))
        << "damping";
  }
}

void check_friction(SystemGraph& graph, const ForceElement& force, double tolerance) {
  SCOPED_TRACE("friction '" + force.name() + "'");
  Probe p(graph, 13);
  const int rows = p.layout().row_count();
  const auto [name, first, count] = p.system.rows(*force.reaction_of());
  for (int k = 0; k < kStates; ++k) {
    p.draw_state();
    VectorX lambda = p.no_load();
    lambda.segment(first, count) = p.random.vector(count, 5);
    const auto tensions = [&](const VectorX& v, const VectorX& l) -> VectorX {
      p.residual(p.time, p.q, v, l);
      return p.evaluator.workspace().tension;
    };
    // What it feeds into the bodies is never positive.
    p.residual(p.time, p.q, p.v, lambda);
    p.evaluator.factorize({0, 1, 1}, p.no_motion(), lambda, nullptr);
    const DenseMatrix m = dense(p.evaluator);
    const VectorX sigma = tensions(p.v, lambda);
    EXPECT_LE(-sigma.dot(m.compliant_G() * p.v), 0) << "friction gives power";

    // Its row of the iteration matrix, over its compliance: ∂σ/∂λ, and the compliance itself: ∂σ/∂v = -G / C.
    const MatrixX C = m.all.bottomRightCorner(m.compliant(), m.compliant());
    const MatrixX B = m.all.block(m.velocities + rows, m.velocities, m.compliant(), rows);
    MatrixX by_lambda(m.compliant(), rows), by_velocity(m.compliant(), m.velocities);
    for (int j = 0; j < rows; ++j)
      by_lambda.col(j) = derivative([&](double h) { return tensions(p.v, lambda + h * VectorX::Unit(rows, j)); });
    for (int j = 0; j < m.velocities; ++j)
      by_velocity.col(j) =
          derivative([&](double h) { return tensions(p.v + h * VectorX::Unit(m.velocities, j), lambda); });
    EXPECT_TRUE(close(-solve(C, B), by_lambda, tolerance)) << "tension by the joint's multipliers";
    EXPECT_TRUE(close(-solve(C, m.compliant_G()), by_velocity, tolerance)) << "tension by velocity";
  }
}

}  // namespace lithe::test
