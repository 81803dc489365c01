#include <gtest/gtest.h>

#include <cmath>

#include "bodies/rigid_body.h"
#include "engine/assembly/evaluated.h"
#include "engine/assembly/evaluator.h"
#include "engine/assembly/least_norm.h"
#include "engine/base/log.h"
#include "integrators/generalized_alpha.h"
#include "joints/fixed_joint.h"
#include "joints/revolute_joint.h"
#include "tests/support/dense.h"
#include "tests/support/linear_algebra.h"

namespace lithe::test::redundancy_test {
namespace {

/// A door on the x axis: one hinge, or several along one line, which repeat each other.
struct Door {
  explicit Door(const std::vector<double>& places) {
    const Matrix3 along_x = rotation_about({0, 1, 0}, M_PI / 2);  // the hinges' z axis
    auto& panel = graph.add<RigidBody>("panel", {.mass = 3,
                                                 .inertia = {0.2, 0.1, 0.25},
                                                 .position = {0.1, 0.5, 0.2},
                                                 .velocity = {0, -0.14, 0.35},
                                                 .angular_velocity = {0.7, 0, 0}});
    for (double x : places)
      graph.add<RevoluteJoint>("hinge " + std::to_string(graph.constraints().size() + 1),
                               {graph.ground().marker({x, 0, 0}, along_x),
                                panel.marker(Vector3(x, 0, 0) - Vector3(0.1, 0.5, 0.2), along_x)});
  }
  SystemGraph graph;
};

State run(const System& system, double until, double step, double* residual = nullptr) {
  Evaluator evaluator(system);
  GeneralizedAlpha integrator{{.step = step, .newton_tolerance = 1e-12}};
  State state = system.initial_state();
  integrator.start(evaluator, state);
  VectorX g(system.layout().row_count());
  while (state.time < until) {
    const StepResult result = integrator.step(evaluator, state, until);
    if (!result.ok()) {
      ADD_FAILURE() << result.why << " at t = " << state.time;
      break;
    }
    evaluator.evaluate(state.time, state.q, state.v, Level::position);
    evaluator.constraint(Level::position, g);
    if (residual) *residual = std::max(*residual, g.cwiseAbs().maxCoeff());
  }
  return state;
}

TEST(RedundantRows, OfTwoHingesOnOneLineAreNamed) {
  Door door({-0.3, 0.4});
  const System system = assemble(door.graph);
  EXPECT_EQ(system.rank(), 5);
  EXPECT_EQ(system.degrees_of_freedom(), 1);
  ASSERT_EQ(system.redundant_rows().size(), 5u);
  const std::string warning = log::last_warning();
  EXPECT_NE(warning.find("5 dependent constraint rows"), std::string::npos) << warning;
  EXPECT_EQ(warning.find('\n'), std::string::npos) << "one line a mechanism: " << warning;
  for (const RedundantRow& row : system.redundant_rows()) EXPECT_FALSE(row.repeats.empty()) << row.name;
}

TEST(RedundantRows, DoNotChangeTheMotion) {
  Door one({-0.3}), two({-0.3, 0.4}), three({-0.3, 0.1, 0.4});
  const System alone = assemble(one.graph), twice = assemble(two.graph), thrice = assemble(three.graph);
  EXPECT_LT((alone.initial_state().v_dot - twice.initial_state().v_dot).norm(), 1e-12);
  double residual = 0;
  const State a = run(alone, 1, 1e-3), b = run(twice, 1, 1e-3, &residual), c = run(thrice, 1, 1e-3, &residual);
  EXPECT_LT((a.q - b.q).norm(), 1e-11);
  EXPECT_LT((a.q - c.q).norm(), 1e-11);
  EXPECT_LT((a.v - b.v).norm(), 1e-10);
  EXPECT_LT(residual, 1e-12);
}

/// The reactions of least norm, as a singular value decomposition gives them: Gᵀ lambda = f - M v_dot.
void expect_least_norm(const System& system, double tolerance) {
  Evaluator evaluator(system);
  const State& s = system.initial_state();
  evaluator.evaluate(0, s.q, s.v, Level::acceleration);
  VectorX r(s.v.size());
  evaluator.residual(s.v_dot, VectorX::Zero(s.lambda.size()), r);
  evaluator.factorize({0, 0, 1}, s.v_dot, s.lambda, nullptr);
  const MatrixX G = dense(evaluator).G();
  EXPECT_EQ(rank(G), system.rank());
  const VectorX expected = least_norm(G.transpose(), -r);
  EXPECT_LT((s.lambda - expected).norm(), tolerance * (1 + expected.norm()));

  // From any multipliers with the same reactions to the same ones of least norm.
  VectorX lambda = VectorX::LinSpaced(s.lambda.size(), 1, 2);
  const VectorX moved = least_norm(G.transpose(), G.transpose() * lambda);
  minimize_norm(evaluator, lambda);
  EXPECT_LT((lambda - moved).norm(), tolerance * (1 + moved.norm()));
}

TEST(RedundantRows, HaveReactionsOfLeastNorm) {
  Door two({-0.3, 0.4}), three({-0.3, 0.1, 0.4});
  expect_least_norm(assemble(two.graph), 1e-11);
  expect_least_norm(assemble(three.graph), 1e-11);
}

TEST(RedundantRows, OfAWeldOnAWeldAreAllSix) {
  SystemGraph graph;
  auto& a = graph.add<RigidBody>("a", {.position = {0, 0, 1}});
  auto& b = graph.add<RigidBody>("b", {.position = {0, 0, 2}});
  graph.add<FixedJoint>("foot", {graph.ground().marker(), a.marker({0, 0, -1})});
  graph.add<FixedJoint>("weld", {a.marker({0, 0, 0.5}), b.marker({0, 0, -0.5})});
  graph.add<FixedJoint>("weld again", {a.marker({0.2, 0, 0.5}), b.marker({0.2, 0, -0.5})});
  const System system = assemble(graph);
  EXPECT_EQ(system.rank(), 12);
  EXPECT_EQ(system.degrees_of_freedom(), 0);
  EXPECT_LT(system.initial_state().v_dot.norm(), 1e-11);
  expect_least_norm(system, 1e-10);
}

/// Crank, coupler and rocker of slender rods between 3-D hinges whose axes are parallel: three of twenty rows repeat
/// others. Reference benchmark R12: 1 s of the motion to 1e-6 m.
TEST(RedundantRows, OfAFourBarAreThreeOfTwenty) {
  SystemGraph graph{{.gravity = {0, -9.81, 0}}};
  const Vector3 O(0, 0, 0), D(1.4, 0, 0), A(0, 0.5, 0), B(1.109610152249955961, 0.9569084262998764912, 0);
  struct Rod {
    RigidBody* body;
    double length;
    Marker start() const { return body->marker({-length / 2, 0, 0}); }
    Marker end() const { return body->marker({length / 2, 0, 0}); }
  };
  const auto rod = [&](const char* name, const Vector3& from, const Vector3& to, const Vector3& v_from, double omega) {
    const Vector3 d = to - from;
    const double m = d.norm();  // 1 kg a metre
    auto& body = graph.add<RigidBody>(name, {.mass = m,
                                             .inertia = {m * m * m / 1200, m * m * m / 12, m * m * m / 12},
                                             .position = (from + to) / 2,
                                             .orientation = rotation_about({0, 0, 1}, std::atan2(d.y(), d.x())),
                                             .velocity = v_from + omega * Vector3(-d.y(), d.x(), 0) / 2,
                                             .angular_velocity = {0, 0, omega}});
    return Rod{&body, m};
  };
  // Velocities of A and B from the reference; a rod's turn from the velocities of its ends.
  const Vector3 v_A(-3, 0, 0), v_B(-2.666762317410566574, -0.8092735752498505519, 0);
  const auto turn = [](const Vector3& d, const Vector3& v) { return d.cross(v).z() / d.squaredNorm(); };
  const Rod crank = rod("crank", O, A, {0, 0, 0}, 6), coupler = rod("coupler", A, B, v_A, turn(B - A, v_B - v_A)),
            rocker = rod("rocker", D, B, {0, 0, 0}, turn(B - D, v_B));
  graph.add<RevoluteJoint>("O", {graph.ground().marker(O), crank.start()});
  graph.add<RevoluteJoint>("A", {crank.end(), coupler.start()});
  graph.add<RevoluteJoint>("B", {coupler.end(), rocker.end()});
  graph.add<RevoluteJoint>("D", {graph.ground().marker(D), rocker.start()});

  const System system = assemble(graph);
  EXPECT_EQ(system.layout().row_count(), 20);
  EXPECT_EQ(system.rank(), 17);
  EXPECT_EQ(system.degrees_of_freedom(), 1);
  EXPECT_NE(log::last_warning().find("3 dependent constraint rows"), std::string::npos) << log::last_warning();
  expect_least_norm(system, 1e-10);

  Evaluator evaluator(system);
  evaluator.evaluate(0, system.initial_state().q, system.initial_state().v, Level::velocity);
  EXPECT_NEAR(evaluator.energy().total(), 21.4930393769398, 1e-10);
  double residual = 0;
  const State end = run(system, 1, 1e-4, &residual);
  EXPECT_LT(residual, 1e-10);
  evaluator.evaluate(end.time, end.q, end.v, Level::velocity);
  const Vector3 p_B = marker_kinematics(evaluator, rocker.end(), Level::position).p;
  EXPECT_LT((p_B - Vector3(5.472001848525287482e-1, 5.222379489125994478e-1, 0)).norm(), 1e-6);
  EXPECT_NEAR(p_B.z(), 0, 1e-12);
}

/// Pivots of a long chain of hinges become small without any row being redundant: out of the plane it is a bar of many
/// pieces that hardly bends.
TEST(Redundancy, IsNotSeenInALongChainOfHinges) {
  constexpr int kLinks = 1000;
  SystemGraph graph;
  Marker end = graph.ground().marker();
  for (int i = 0; i < kLinks; ++i) {
    auto& link = graph.add<RigidBody>("link " + std::to_string(i),
                                      {.mass = 1, .inertia = {1e-3, 1.0 / 12, 1.0 / 12}, .position = {i + 0.5, 0, 0}});
    graph.add<RevoluteJoint>("hinge " + std::to_string(i), {end, link.marker({-0.5, 0, 0})});
    end = link.marker({0.5, 0, 0});
  }
  const System system = assemble(graph);
  EXPECT_EQ(system.rank(), 5 * kLinks);
}

}  // namespace
}  // namespace lithe::test::redundancy_test
