// What differential fuzzing has found, each finding by itself.
#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "integrators/moreau_jean.h"
#include "joints/forces/bushing.h"
#include "joints/forces/joint_friction.h"
#include "joints/revolute_joint.h"
#include "tests/support/methods.h"
#include "tests/support/scenes.h"

namespace lithe::test::differential_findings_test {
namespace {

/// Let go level: on its way down the reaction turns by a right angle and grows threefold.
Scene rubbing_pendulum() {
  return Scene({0, 0, -9.81}, [](SystemGraph& graph) {
    const Matrix3 axis_y = rotation_about(Vector3::UnitX(), -M_PI / 2);
    auto& rod = graph.add<RigidBody>("rod", {.mass = 1, .inertia = {0.02, 0.02, 0.02}, .position = {0.5, 0, 0}});
    auto& pin =
        graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, axis_y), rod.marker({-0.5, 0, 0}, axis_y)});
    graph.add<JointFriction>("rub", {pin.angle()},
                             {.joint = &pin, .coefficient = 0.3, .creep_speed = 0.05, .radius = 0.05});
  });
}

/// Moreau-Jean took the reaction of the last time that somebody asked for multipliers.
TEST(DifferentialFindings, MoreauJeanRubsByTheReactionOfEachStep) {
  constexpr double kEnd = 0.6;
  Scene exact = rubbing_pendulum();
  exact.run(*runge_kutta8(1e-11), kEnd);
  double last = 0;
  for (const double h : {4e-3, 2e-3, 1e-3}) {
    Scene scene = rubbing_pendulum();
    MoreauJean method({.step = h});
    scene.run(method, kEnd);
    const double error = (scene.position(0) - exact.position(0)).norm();
    expect_below("error over h², m/s²", error / (h * h), 3);
    if (last > 0) {
      EXPECT_NEAR(last / error, 4, 0.8) << h;  // order 2
    }
    last = error;
  }
}

/// A direction without stiffness is a row that moves no body; it was taken for a dependent row of a joint, which there
/// is none, and assemble() crashed.
TEST(DifferentialFindings, ABushingThatHoldsRotationsAloneIsNoDependentRowInALoop) {
  SystemGraph graph;
  auto& door = graph.add<RigidBody>("door", {});
  for (const double z : {0.0, 1.0})
    graph.add<RevoluteJoint>("hinge at " + std::to_string(z),
                             {graph.ground().marker({0.5, 0, z}), door.marker({0.5, 0, z})});
  Bushing::Parameters closer;
  closer.stiffness.diagonal().tail<3>().setConstant(3);
  graph.add<Bushing>("closer", {graph.ground().marker(), door.marker()}, closer);
  const System system = assemble(graph);
  EXPECT_EQ(system.degrees_of_freedom(), 1);
  ASSERT_EQ(system.redundant_rows().size(), 5);
  for (const RedundantRow& row : system.redundant_rows()) EXPECT_LT(row.row, system.layout().row_count());
}

}  // namespace
}  // namespace lithe::test::differential_findings_test
