#include <gtest/gtest.h>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/point_mass.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/evaluator.h"
#include "engine/model/system_graph.h"
#include "engine/model/world_placement.h"
#include "engine/observe/snapshot.h"
#include "integrators/explicit_runge_kutta.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/support/motion.h"

/// Markers and joints placed in the world, and elements found by their names.
namespace lithe::test::world_placement_test {
namespace {

RigidBody::Parameters turned_link(RandomNumbers& random) {
  return {.mass = 2, .position = random.vector3(), .orientation = random.rotation()};
}

template <class Body>
void expect_at(Body& body, SystemGraph& graph, const Vector3& point, const Matrix3& axes) {
  const Marker marker = body.marker_at_world(point, axes);
  const System system = assemble(graph);
  Snapshot now{system, system.initial_state()};
  const MarkerKinematics k = now.marker(marker);
  EXPECT_LT((k.p - point).norm(), 1e-14);
  EXPECT_LT((k.R - axes).norm(), 1e-14);
}

TEST(MarkerAtWorld, OfARigidBodyIsWhereItWasPutInTheDrawing) {
  RandomNumbers random(11);
  SystemGraph graph;
  auto& link = graph.add<RigidBody>("link", turned_link(random));
  for (int i = 0; i < 5; ++i) expect_at(link, graph, random.vector3(), random.rotation());
  expect_at(graph.ground(), graph, {1, 2, 3}, random.rotation());
  EXPECT_THROW(link.marker_at_world({0, 0, 0}, 2 * Matrix3::Identity()), SceneError);
}

TEST(MarkerAtWorld, OfAPointMassIsItsOwnPlace) {
  SystemGraph graph;
  auto& bob = graph.add<PointMass>("bob", {.mass = 1, .position = {1, 2, -3}});
  expect_at(bob, graph, {1, 2, -3}, rotation_about({1, 0, 0}, 0.4));
  EXPECT_THROW(bob.marker_at_world({1, 2, -2.999}), SceneError);
}

/// A bent body, turned and shifted: the marker is the node that lies there.
TEST(MarkerAtWorld, OfAFlexibleBodyIsTheNodeThatLiesThere) {
  const auto basis = make_basis(
      brick_mesh(
          {.size = {0.5, 0.02, 0.03}, .divisions = {5, 1, 1}, .type = "C3D8I", .material = {2.07e11, 0.3, 7800}}),
      MeanAxisFrame{}, 3);
  RandomNumbers random(13);
  SystemGraph graph;
  auto& rod = graph.add<FlexibleBody>("rod", {.basis = basis,
                                              .position = random.vector3(),
                                              .orientation = random.rotation(),
                                              .modal_coordinates = random.vector(3, 0.01)});
  const Marker tip = rod.node(7);
  const System system = assemble(graph);
  Snapshot now{system, system.initial_state()};
  const Vector3 point = now.marker(tip).p;
  const Vector3 undeformed = rod.parameters().position + rod.parameters().orientation * basis->nodes.col(6);
  EXPECT_GT((point - undeformed).norm(), 1e-4) << "the drawing bends it";
  const Matrix3 axes = random.rotation();
  expect_at(rod, graph, point, axes);
  EXPECT_EQ(rod.marker_nodes(rod.marker_count() - 1).nodes, rod.marker_nodes(tip.index).nodes);
  try {
    rod.marker_at_world(point + Vector3(0, 0, 1e-3));
    ADD_FAILURE() << "a place without node was taken";
  } catch (const SceneError& error) {
    EXPECT_NE(error.problem().find("nearest, 7, is 0.001"), std::string::npos) << error.problem();
  }
}

/// Two links drawn where they are meant to be: a double pendulum that moves as the one with markers in body axes.
TEST(AtWorld, AJointIsPlacedOnceByItsPointAndAxis) {
  const Matrix3 tilt = rotation_about({0, 1, 0}, 0.6), hinge = rotation_about({1, 0, 0}, -M_PI / 2);
  const Vector3 elbow = tilt * Vector3(0.5, 0, 0);
  const auto draw = [&](SystemGraph& graph, bool in_world) {
    auto& upper = graph.add<RigidBody>("upper", {.position = 0.5 * elbow, .orientation = tilt});
    auto& lower = graph.add<RigidBody>("lower", {.mass = 0.5, .position = elbow + Vector3(0.2, 0, 0)});
    if (in_world) {
      graph.add<RevoluteJoint>("shoulder", at_world(graph.ground(), upper, {.axis = {0, 3, 0}}));
      graph.add<RevoluteJoint>("elbow", at_world(upper, lower, {.point = elbow, .axis = {0, 3, 0}}));
    } else {
      graph.add<RevoluteJoint>("shoulder", {graph.ground().marker({}, hinge), upper.marker({-0.25, 0, 0}, hinge)});
      graph.add<RevoluteJoint>("elbow", {upper.marker({0.25, 0, 0}, hinge), lower.marker({-0.2, 0, 0}, hinge)});
    }
  };
  VectorX ends[2];
  for (bool in_world : {false, true}) {
    SystemGraph graph;
    draw(graph, in_world);
    const System system = assemble(graph);
    EXPECT_EQ(system.degrees_of_freedom(), 2);
    State state = system.initial_state();
    Evaluator equations(system);
    ExplicitRungeKutta integrator({.tolerance = {.relative = 1e-11, .absolute = 1e-11}});
    integrator.start(equations, state);
    while (state.time < 1) ASSERT_TRUE(integrator.step(equations, state, 1).ok());
    ends[in_world] = state.q;
  }
  EXPECT_GT((ends[0].head<3>() - 0.5 * elbow).norm(), 0.05);
  EXPECT_LT((ends[0] - ends[1]).norm(), 1e-9);
}

TEST(AtWorld, TheXAxisMayBeGivenForJointsThatHaveOne) {
  SystemGraph graph;
  auto& body = graph.add<RigidBody>("body");
  const std::vector<Marker> m =
      at_world(graph.ground(), body, {.point = {1, 0, 0}, .axis = {0, 1, 0}, .x_axis = {0, 5, -2}});
  const System system = assemble(graph);
  Snapshot now{system, system.initial_state()};
  for (const Marker& marker : m) EXPECT_LT((now.marker(marker).R.col(0) - Vector3(0, 0, -1)).norm(), 1e-15);
}

// ---- by name ----

TEST(SystemGraph, FindsAnElementAsWhatItIs) {
  SystemGraph graph;
  auto& body = graph.add<RigidBody>("link");
  auto& pin = graph.add<RevoluteJoint>("pin", at_world(graph.ground(), body, {}));
  EXPECT_EQ(graph.find<RigidBody>("link"), &body);
  EXPECT_EQ(graph.find<Body>("link"), &body);
  EXPECT_EQ(graph.find<RevoluteJoint>("pin"), &pin);
  EXPECT_EQ(graph.find<Constraint>("pin"), &pin);
  EXPECT_EQ(graph.find<RevoluteJoint>("pim"), nullptr);
  EXPECT_EQ(graph.find<Body>("ground"), &graph.ground());
  const SystemGraph& same = graph;
  static_assert(std::is_same_v<decltype(same.find<RevoluteJoint>("pin")), const RevoluteJoint*>);
  EXPECT_EQ(same.find<RevoluteJoint>("pin"), &pin);
  try {
    graph.find<SphericalJoint>("pin");
    ADD_FAILURE() << "a hinge was taken for a ball";
  } catch (const SceneError& error) {
    EXPECT_EQ(error.problem(), "'pin' is a RevoluteJoint, not a SphericalJoint");
    EXPECT_NE(error.where().find("world_placement_test.cpp"), std::string::npos);
  }
}

}  // namespace
}  // namespace lithe::test::world_placement_test
