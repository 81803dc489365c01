#include "joints/contact/capsules.h"

#include <gtest/gtest.h>

#include "bodies/beam/beam.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/observe/contact_sensors.h"
#include "engine/observe/snapshot.h"
#include "joints/fixed_joint.h"
#include "joints/point_on_line_joint.h"
#include "joints/point_on_plane_joint.h"
#include "joints/spherical_joint.h"
#include "tests/support/methods.h"

/// Beams that touch, at rest: closed forms.
namespace lithe::test::capsules_test {
namespace {

constexpr double kLength = 1, kEdge = 0.02;
const Material kPlastic{2e9, 0.3, 1200};
const Contact::Parameters kHard{
    .law = Compliance{.stiffness = 1e7, .exponent = 1, .dissipation = Dissipation::fixed, .damping = 100}};

Beam& add_beam(SystemGraph& graph, double height, int elements = 10) {
  return graph.add<Beam>("beam", {.axis = BeamAxis::straight({0, 0, height}, {kLength, 0, height}, {0, 1, 0}),
                                  .sections = {{0, BeamSection::rectangle(kEdge, kEdge, kPlastic).damped(1e-3)}},
                                  .elements = elements});
}

/// Laid on a table it comes to rest, its weight on the table.
TEST(Capsules, RestOnATable) {
  SystemGraph graph;
  Beam& beam = add_beam(graph, kEdge / 2 - 1e-6);
  std::vector<Collider> colliders = capsules(beam, kEdge / 2);
  colliders.push_back({graph.ground().marker(), shape::half_space()});
  auto& table = graph.add<Contact>("table", colliders, kHard);
  const System system = assemble(graph);
  Snapshot now(system, find_equilibrium(system, system.initial_state()).state);
  double force[6];
  contact_force(table, beam.node_count()).evaluate(now, force);
  EXPECT_NEAR(force[2] / (-beam.mass() * 9.81), 1, 1e-9);
  for (const double arc : {0.0, 0.5, 1.0}) EXPECT_NEAR(now.marker(beam.marker(arc)).p[2], kEdge / 2, 1e-5);
}

/// A ball in the middle of a beam without weight on two supports: m g L³/48EI + m g L/4GA deep.
TEST(Capsules, ABallBendsABeam) {
  const double mass = 0.5, radius = 0.03;
  BeamSection section = BeamSection::rectangle(kEdge, kEdge, kPlastic);
  const double load = mass * 9.81, deep = load * std::pow(kLength, 3) / (48 * section.stiffness(4, 4)) +
                                          load * kLength / (4 * section.stiffness(2, 2));
  section.mass *= 1e-6;
  SystemGraph graph;
  Beam& beam = graph.add<Beam>(
      "beam",
      {.axis = BeamAxis::straight({0, 0, 0}, {kLength, 0, 0}, {0, 1, 0}), .sections = {{0, section}}, .elements = 20});
  graph.add<SphericalJoint>("left", {graph.ground().marker(), beam.marker(0)});
  const Matrix3 along = rotation_about({0, 1, 0}, M_PI / 2);
  graph.add<PointOnLineJoint>("right", {graph.ground().marker({kLength, 0, 0}, along), beam.marker(kLength)});
  graph.add<PointOnPlaneJoint>("no roll", {graph.ground().marker({0, 0.1, 0}), beam.marker(0, {0, 0.1, 0})});
  auto& ball = graph.add<RigidBody>(
      "ball", {.mass = mass, .inertia = {2e-4, 2e-4, 2e-4}, .position = {kLength / 2, 0, kEdge / 2 + radius - 1e-6}});
  graph.add<PointOnLineJoint>("guide", {graph.ground().marker({kLength / 2, 0, 0}), ball.marker()});
  std::vector<Collider> colliders = capsules(beam, kEdge / 2);
  colliders.push_back({ball.marker(), shape::sphere(radius)});
  graph.add<Contact>("touch", colliders, kHard);
  const System system = assemble(graph);
  Snapshot now(system, find_equilibrium(system, system.initial_state()).state);
  const double found = -now.marker(beam.marker(kLength / 2)).p[2];
  expect_below("deflection under a ball", std::abs(found / deep - 1), 0.01);
  EXPECT_NEAR(now.marker(ball.marker()).p[2] + found, kEdge / 2 + radius, 2e-6);
}

TEST(Capsules, RefusesWhatDoesNotFit) {
  SystemGraph graph;
  Beam& beam = add_beam(graph, 0);
  EXPECT_THROW(capsules(beam, 0), SceneError);
  EXPECT_THROW(capsules(beam, 0.06), SceneError);
}

}  // namespace
}  // namespace lithe::test::capsules_test
