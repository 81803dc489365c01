// The look at rows left out after each step: where there is nothing to see it costs nothing.
#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/assembly/evaluator.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "joints/revolute_joint.h"

namespace lithe::test::reached_state_test {
namespace {

const Matrix3 kAxisY = rotation_about({1, 0, 0}, -M_PI / 2);

/// A four-bar of hinges with three rows too many, in space.
void draw_four_bar(SystemGraph& graph) {
  const Vector3 corners[] = {{0, 0, 0}, {0, 0, 0.3}, {0.8, 0, 0.6}, {0.8, 0, 0}};
  Marker last = graph.ground().marker({0, 0, 0}, kAxisY);
  for (int i = 0; i < 3; ++i) {
    const std::string number = std::to_string(i);
    const Vector3 middle = 0.5 * (corners[i] + corners[i + 1]);
    auto& bar = graph.add<RigidBody>("bar " + number, {.mass = 1, .inertia = {0.01, 0.01, 0.01}, .position = middle});
    graph.add<RevoluteJoint>("hinge " + number, {last, bar.marker(corners[i] - middle, kAxisY)});
    last = bar.marker(corners[i + 1] - middle, kAxisY);
  }
  graph.add<RevoluteJoint>("hinge 3", {graph.ground().marker(corners[3], kAxisY), last});
}

TEST(ReachedState, AStepByForwardDynamicsIsNotEvaluatedForRowsLeftOut) {
  SystemGraph graph;
  draw_four_bar(graph);
  const System system = assemble(graph);
  EXPECT_EQ(system.redundant_rows().size(), 3u);
  Evaluator equations(system);
  ASSERT_NE(equations.parts().forward_dynamics, nullptr);
  State state = system.initial_state();
  ExplicitRungeKutta method({.step = 1e-3});
  method.start(equations, state);
  method.step(equations, state, 1e-3, Multipliers::later);
  const long before = equations.evaluations();
  for (int i = 2; i <= 50; ++i) ASSERT_TRUE(method.step(equations, state, 1e-3 * i, Multipliers::later).ok());
  EXPECT_EQ(equations.evaluations(), before);
  // The rows that were not looked at do hold.
  VectorX rows(system.layout().row_count());
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  equations.constraint(Level::position, rows);
  EXPECT_LT(rows.lpNorm<Eigen::Infinity>(), 1e-12);
  equations.constraint(Level::velocity, rows);
  EXPECT_LT(rows.lpNorm<Eigen::Infinity>(), 1e-12);
}

}  // namespace
}  // namespace lithe::test::reached_state_test
