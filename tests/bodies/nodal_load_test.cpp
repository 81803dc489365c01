// Forces on nodes of a flexible body, gathered into six: virtual work, weight, deflection.
#include <gtest/gtest.h>

#include "bodies/flexible/flexible_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/assembly/evaluated.h"
#include "engine/assembly/evaluator.h"
#include "engine/observe/sensors.h"
#include "engine/observe/snapshot.h"
#include "joints/fixed_joint.h"
#include "joints/forces/distributed_load.h"
#include "tests/bodies/bar_model.h"
#include "tests/bodies/fe_models.h"
#include "tests/support/joint_checks.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/motion.h"

namespace lithe::test::nodal_load_test {
namespace {

using Axes = DistributedLoad::Axes;

/// A bar in a scene with one body; the body's frame is tilted against the mesh.
struct LoadedBar {
  explicit LoadedBar(int modes, const Vector3& gravity = {0, 0, 0}) : graph({.gravity = gravity}) {
    const auto& end = model.node_set("end");
    const auto basis = make_basis(model, ThreeNodeFrame{1, end[8], 3}, modes);
    body = &graph.add<FlexibleBody>(
        "bar", {.basis = basis, .position = {0.2, 0.1, -0.3}, .orientation = rotation_about({1, 2, -1}, 0.8)});
  }
  FiniteElementModel model = bar_model({.size = {0.3, 0.03, 0.02}, .bricks = {5, 2, 2}});
  SystemGraph graph;
  FlexibleBody* body;
};

/// Random state of one body, deformed by some millimetres.
State random_state(const System& system, RandomNumbers& random, int modes) {
  State state = system.initial_state();
  VectorX step = random.vector(system.layout().v_count(), 0.5);
  step.tail(modes) *= 1e-3;
  VectorX q(state.q.size());
  system.layout().retract(state.q, step, q);
  state.q = q;
  state.v = random.vector(system.layout().v_count());
  return state;
}

/// What the load adds to the right-hand side.
VectorX generalized_force(const System& system, const State& state) {
  Evaluator equations(system);
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  VectorX residual = VectorX::Zero(state.v.size());
  equations.residual(VectorX::Zero(state.v.size()), VectorX::Zero(system.layout().row_count()), residual);
  return -residual;
}

/// Σ f_i · (motion of node i by a unit of each velocity), node by node.
VectorX by_nodes(const System& system, const FlexibleBody& body, const State& state, const std::vector<int>& ids,
                 const Matrix3X& forces, Axes axes) {
  Evaluator equations(system);
  VectorX sum(state.v.size());
  for (int j = 0; j < state.v.size(); ++j) {
    const VectorX unit = VectorX::Unit(state.v.size(), j), still = VectorX::Zero(state.v.size());
    equations.evaluate(0, state.q, unit, Level::velocity);
    const BodyState s = body_state(equations, body);
    const Matrix3X velocity = body.nodal_motion(s, still.data()).velocity;
    const Matrix3 R =
        axes == Axes::body ? Matrix3(s.cache->A * body.basis().rotation.transpose()) : Matrix3::Identity();
    sum[j] = 0;
    for (size_t k = 0; k < ids.size(); ++k)
      sum[j] += velocity.col(body.basis().node_index(ids[k])).dot(R * forces.col(static_cast<Eigen::Index>(k)));
  }
  return sum;
}

TEST(NodalLoad, DoesTheWorkOfItsForcesNodeByNode) {
  for (int modes : {6, kAllNodal, 0})
    for (Axes axes : {Axes::body, Axes::world}) {
      SCOPED_TRACE(std::to_string(modes) + (axes == Axes::body ? " body" : " world"));
      LoadedBar bar(modes), bare(modes);
      RandomNumbers random(5);
      const std::vector<int> ids = bar.model.node_ids;
      const Matrix3X forces = random.matrix3x(static_cast<int>(ids.size()), 10);
      const NodalLoad load = bar.body->nodal_load(ids, forces);
      EXPECT_EQ(load.markers.size(), 6u);
      auto& element =
          bar.graph.add<DistributedLoad>("load", load.markers, {.forces = load.forces, .axes = axes, .amplitude = {}});
      const System system = assemble(bar.graph), unloaded = assemble(bare.graph);
      for (int k = 0; k < 3; ++k) {
        const State state = random_state(system, random, bar.body->mode_count());
        const VectorX force = generalized_force(system, state) - generalized_force(unloaded, state);
        const VectorX expected = by_nodes(system, *bar.body, state, ids, forces, axes);
        EXPECT_LT((force - expected).norm() / expected.norm(), 1e-10);
      }
      // The damping is left out: the tangent holds the body's own inertia forces too.
      if (modes == 6) check_force(bar.graph, element, {.conservative = axes == Axes::world, .exact_damping = false});
    }
}

TEST(NodalLoad, OfTheNodesWeightsIsGravity) {
  const Vector3 g(1, -2, -9.81);
  LoadedBar loaded(6), falling(6, g);
  const VectorX mass = loaded.body->basis().nodal_mass * VectorX::Ones(loaded.model.node_count());
  const NodalLoad weight = loaded.body->nodal_load(loaded.model.node_ids, g * mass.transpose());
  EXPECT_EQ(weight.markers.size(), 3u);
  loaded.graph.add<DistributedLoad>("weight", weight.markers,
                                    {.forces = weight.forces, .axes = Axes::world, .amplitude = {}});
  const System a = assemble(loaded.graph), b = assemble(falling.graph);
  RandomNumbers random(3);
  const State state = random_state(a, random, 6);
  const VectorX by_load = generalized_force(a, state), by_gravity = generalized_force(b, state);
  EXPECT_LT((by_load - by_gravity).norm() / by_gravity.norm(), 1e-12);
  // Dead loads have the potential of gravity, up to nothing: both count from the world's origin.
  Evaluator loads(a), gravity(b);
  loads.evaluate(0, state.q, state.v, Level::velocity);
  gravity.evaluate(0, state.q, state.v, Level::velocity);
  EXPECT_NEAR(loads.energy().total(), gravity.energy().total(), 1e-10);
}

TEST(NodalLoad, InEquilibriumWithItselfMovesNoFrame) {
  LoadedBar bar(8), bare(8);
  const auto& start = bar.model.node_set("start");
  const auto& end = bar.model.node_set("end");
  // The faces are pulled apart, along the bar.
  std::vector<int> ids = start;
  ids.insert(ids.end(), end.begin(), end.end());
  Matrix3X pull = Matrix3X::Zero(3, 18);
  pull.row(0).head(9).setConstant(-100);
  pull.row(0).tail(9).setConstant(100);
  const NodalLoad load = bar.body->nodal_load(ids, pull);
  ASSERT_EQ(load.markers.size(), 2u);
  EXPECT_EQ((load.forces[0] + load.forces[1]).norm(), 0);
  bar.graph.add<DistributedLoad>("pull", load.markers, {.forces = load.forces});
  const System system = assemble(bar.graph), unloaded = assemble(bare.graph);
  const State state = system.initial_state();
  const VectorX force = generalized_force(system, state) - generalized_force(unloaded, state);
  EXPECT_LT(force.head<6>().norm(), 1e-10);
  EXPECT_GT(force.tail(8).norm(), 1);
}

TEST(NodalLoad, BendsACantileverAsTheMeshDoes) {
  // Pressure on the top: the tip's sag is that of K⁻¹ f, when all nodes count and when the basis has the shape.
  const Bar shape{.size = {0.3, 0.03, 0.02}, .bricks = {6, 2, 2}};
  const FiniteElementModel model = bar_model(shape);
  std::vector<int> top;
  for (int i = 0; i < model.node_count(); ++i)
    if (model.nodes(2, i) > 0.009) top.push_back(model.node_ids[i]);
  Matrix3X pressure = Matrix3X::Zero(3, static_cast<Eigen::Index>(top.size()));
  pressure.row(2).setConstant(-2.0);
  const int held = 27, free = 3 * model.node_count() - held;
  VectorX f = VectorX::Zero(3 * model.node_count());
  for (int id : top) f[3 * (id - 1) + 2] = -2;
  const VectorX u = solve_positive(MatrixX(model.stiffness).bottomRightCorner(free, free), f.tail(free));
  const int tip = model.node_set("end")[4];
  const double exact = u[3 * (tip - 1) + 2 - held];

  const auto sag = [&](int modes) {
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    auto& body =
        graph.add<FlexibleBody>("bar", {.basis = make_basis(model, TangentFrame{model.node_set("start")}, modes)});
    const Marker end = body.node(tip);
    graph.add<FixedJoint>("clamp", {graph.ground().marker(), body.frame()});
    const NodalLoad load = body.nodal_load(top, pressure);
    graph.add<DistributedLoad>("pressure", load.markers, {.forces = load.forces});
    const System system = assemble(graph);
    const Equilibrium rest = find_equilibrium(system, system.initial_state());
    Snapshot now(system, rest.state);
    return height(end, "sag").value(now);
  };
  EXPECT_NEAR(sag(kAllNodal) / exact, 1, 1e-7);
  EXPECT_NEAR(sag(12) / exact, 1, 1e-3);
  EXPECT_LT(exact, 0);
}

TEST(NodalLoad, IsRefusedForOddSizesAndNothing) {
  LoadedBar bar(2);
  expect_error<SceneError>([&] { bar.body->nodal_load({1, 2}, Matrix3X::Ones(3, 3)); }, {"3 forces on 2 nodes"});
  expect_error<SceneError>([&] { bar.body->nodal_load({1, 2}, Matrix3X::Zero(3, 2)); }, {"zero at every node"});
  Matrix3X wrong = Matrix3X::Ones(3, 1);
  wrong(1, 0) = std::nan("");
  expect_error<SceneError>([&] { bar.body->nodal_load({1}, wrong); }, {"not finite"});
}

}  // namespace
}  // namespace lithe::test::nodal_load_test
