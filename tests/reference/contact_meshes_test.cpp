// Meshes on meshes in motion: edges across edges carry a weight, Coulomb's deceleration, equilibrium, elastic impacts,
// and the same motion as by the primitive shapes.
#include <gtest/gtest.h>

#include "integrators/explicit_runge_kutta.h"
#include "tests/reference/contact_scene.h"
#include "tests/support/mesh_shapes.h"

namespace lithe::test::contact_meshes_test {
namespace {

constexpr double g = 9.81;

class MeshesBy : public testing::TestWithParam<Stepper> {};
INSTANTIATE_TEST_SUITE_P(Steppers, MeshesBy, testing::Values(Stepper::moreau_jean, Stepper::generalized_alpha),
                         [](const auto& tested) {
                           return tested.param == Stepper::moreau_jean ? "MoreauJean" : "NonsmoothGeneralizedAlpha";
                         });

TEST_P(MeshesBy, a_tetrahedron_rests_by_an_edge_on_the_edge_of_another) {
  ContactScene scene;
  const Matrix3 turned = Eigen::AngleAxisd(0.7, Vector3::UnitZ()).matrix();
  auto& upper = scene.box("upper", {1, 1, 1}, 2, {0.1, 0.05, 0.02}, turned);
  scene.graph.add<PrismaticJoint>("guide",
                                  {scene.graph.ground().marker({0.1, 0.05, 0}, turned), upper.marker()});  // along z
  auto& contact = scene.contact({{scene.graph.ground().marker({0, 0, 0.3}), tetrahedron_mesh(1, 0.6)},
                                 {upper.marker({0, 0, 0.3}), tetrahedron_mesh(1, 0.6, true)}},
                                0.3);
  scene.start(GetParam(), 1e-3);
  scene.run(0.5);
  EXPECT_NEAR(scene.state().q[2], 0, 1e-9);  // edge upon edge
  EXPECT_LT(scene.state().v.norm(), 1e-9);
  EXPECT_NEAR(scene.read(contact_force(contact, 1), 2), 2 * g, 1e-8);
}

TEST_P(MeshesBy, crossed_ridges_carry_a_body_by_statics) {
  // Four crossings at x, y = -1 and 1; the centre of mass is at (0.2, -0.3). By no friction nothing moves.
  ContactScene scene;
  const Matrix3 down = Eigen::AngleAxisd(M_PI, Vector3(1, 1, 0).normalized()).matrix();  // ridges along y, downwards
  auto& upper = scene.box("upper", {4, 4, 1}, 3, {0.2, -0.3, 0.5});
  auto& contact = scene.contact(
      {{scene.graph.ground().marker(), ridges_mesh(4)}, {upper.marker({-0.2, 0.3, -0.5}, down), ridges_mesh(4)}}, 0);
  scene.start(GetParam(), 1e-3);
  scene.run(1);
  EXPECT_LT((scene.state().q.head<3>() - Vector3(0.2, -0.3, 0.5)).norm(), 1e-9);
  EXPECT_LT(scene.state().v.norm(), 1e-9);
  Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
  Snapshot now(scene.system(), scene.state());
  const ContactMemory points = contacts(now, contact);
  EXPECT_EQ(points.size(), 4u);
  for (const ContactTrace& point : points) {
    EXPECT_GT(point.force.z(), 0);
    force += point.force, moment += point.point.position.cross(point.force);
  }
  EXPECT_LT((force - Vector3(0, 0, 3 * g)).norm(), 1e-7);
  EXPECT_LT((moment - Vector3(-0.3 * 3 * g, -0.2 * 3 * g, 0)).norm(), 1e-7);
}

/// A box thrown along a plate, both as meshes or as boxes: where it is after `time`.
State slide_box(Stepper stepper, bool meshes, double time) {
  ContactScene scene;
  const Vector3 edges(0.4, 0.3, 0.2), plate(6, 2, 0.1);
  auto& box = scene.box("box", edges, 1, {-1, 0, 0.1}, Eigen::AngleAxisd(0.4, Vector3::UnitZ()).matrix(), {2, 0, 0});
  scene.contact({{scene.graph.ground().marker({0, 0, -0.05}), meshes ? box_mesh(plate) : shape::box(plate)},
                 {box.marker(), meshes ? box_mesh(edges) : shape::box(edges)}},
                0.3);
  scene.start(stepper, 1e-3);
  scene.run(time);
  return scene.state();
}

TEST_P(MeshesBy, a_box_slides_on_a_plate_by_coulombs_deceleration) {
  for (const bool meshes : {true, false}) {
    const State sliding = slide_box(GetParam(), meshes, 0.4);
    EXPECT_NEAR(sliding.v[0], 2 - 0.3 * g * 0.4, 1e-9);
    EXPECT_NEAR(sliding.q[0], -1 + 2 * 0.4 - 0.3 * g * 0.08, 1e-9);
    const State stopped = slide_box(GetParam(), meshes, 1);
    EXPECT_NEAR(stopped.q[0], -1 + 2 / (0.3 * g), 2e-6);
    EXPECT_NEAR(stopped.q[2], 0.1, 1e-9);
    EXPECT_LT(stopped.v.norm(), 1e-9);
  }
}

/// Two boxes that meet in space, spinning: edge on edge or corner on face.
struct MeshImpact {
  ContactScene scene{{0, 0, 0}};
  MeshImpact(bool meshes, bool rigid, bool edges_meet) {
    const Vector3 one(0.5, 0.4, 0.3), two(0.4, 0.6, 0.2);
    const auto lean = [](const Vector3& axis, double angle) {
      return Eigen::AngleAxisd(angle, axis.normalized()).matrix();
    };
    const double up = edges_meet ? M_PI / 4 : 0.1;
    auto& a = scene.box("a", one, 1, {0, 0, 0}, lean({1, 0, 0}, up), {0.2, 0, 0.5});
    auto& b = scene.box("b", two, 2, {0.02, 0.03, 0.8}, edges_meet ? lean({0, 1, 0}, up) : lean({1, 2, 0.3}, 0.8),
                        {-0.1, 0.1, -1});
    const auto shape_of = [&](const Vector3& edges) { return meshes ? box_mesh(edges) : shape::box(edges); };
    Contact::Parameters law{.law = RigidSurfaces{.restitution = 1, .rest_speed = 0}};
    if (!rigid) law.law = Compliance{.stiffness = 1e6, .exponent = 1.5};
    scene.graph.add<Contact>("contact", std::vector<Collider>{{a.marker(), shape_of(one)}, {b.marker(), shape_of(two)}},
                             law);
  }
};

TEST_P(MeshesBy, elastic_impacts_of_meshes_keep_energy_and_are_those_of_boxes) {
  for (const bool edges_meet : {true, false}) {
    VectorX end[2];
    for (const bool meshes : {false, true}) {
      MeshImpact impact(meshes, true, edges_meet);
      impact.scene.start(GetParam(), 2e-4);
      const double energy = impact.scene.read(kinetic_energy());
      const VectorX before = impact.scene.state().v;
      impact.scene.run(0.6);
      EXPECT_GT((impact.scene.state().v - before).norm(), 0.1) << "met";
      EXPECT_NEAR(impact.scene.read(kinetic_energy()) / energy, 1, 1e-5) << edges_meet << meshes;
      end[meshes] = impact.scene.state().v;
    }
    EXPECT_LT((end[1] - end[0]).norm(), 1e-6) << edges_meet;
  }
}

TEST(ContactMeshesByRungeKutta, a_compliant_impact_keeps_energy_and_is_that_of_boxes) {
  for (const bool edges_meet : {true, false}) {
    VectorX end[2];
    for (const bool meshes : {false, true}) {
      MeshImpact impact(meshes, false, edges_meet);
      const System system = assemble(impact.scene.graph);
      State state = system.initial_state();
      ExplicitRungeKutta method({.tolerance = {.relative = 1e-9, .absolute = 1e-9}});
      Simulation simulation(system, method);
      Snapshot now(system, state);
      const double energy = kinetic_energy().value(now);
      const VectorX before = state.v;
      simulation.run(state, 0.6);
      now.evaluate(state);
      EXPECT_GT((state.v - before).norm(), 0.1) << "met";
      EXPECT_NEAR(kinetic_energy().value(now) / energy, 1, 1e-6) << edges_meet << meshes;
      end[meshes] = state.v;
    }
    EXPECT_LT((end[1] - end[0]).norm(), 1e-6) << edges_meet;
  }
}

}  // namespace
}  // namespace lithe::test::contact_meshes_test
