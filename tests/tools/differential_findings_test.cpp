// What differential fuzzing has found, each finding by itself.
#include <gtest/gtest.h>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/reduction.h"
#include "bodies/rigid_body.h"
#include "engine/study/doctor.h"
#include "integrators/moreau_jean.h"
#include "joints/forces/bushing.h"
#include "joints/forces/joint_friction.h"
#include "joints/revolute_joint.h"
#include "joints/three_node_fixation.h"
#include "tests/support/message_of.h"
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

/// A bar in a tangent frame of its near end, held at three nodes of an end: what the doctor says of it, and how many of
/// its modes are left.
struct HeldBar {
  HeldBar(bool near_end, int modes) {
    FiniteElementModel model = brick_mesh(
        {.size = {1, 0.1, 0.1}, .divisions = {3, 1, 1}, .type = "C3D8I", .material = {1e9, 0.3, 1000}, .name = "bar"});
    std::vector<int> near, far;
    for (Eigen::Index i = 0; i < model.nodes.cols(); ++i) {
      const int label = model.node_ids[static_cast<std::size_t>(i)];
      if (model.nodes(0, i) < 1e-6) near.push_back(label);
      if (model.nodes(0, i) > 1 - 1e-6) far.push_back(label);
    }
    SystemGraph graph;
    auto& bar = graph.add<FlexibleBody>("bar", {.basis = make_basis(model, TangentFrame{near}, modes, {})});
    const std::vector<int>& held = near_end ? near : far;
    graph.add<ThreeNodeFixation>("clamp",
                                 {graph.ground().marker(), bar.node(held[0]), bar.node(held[1]), bar.node(held[2])});
    const System system = assemble(graph);
    modes_left = system.degrees_of_freedom();
    for (const Finding& finding : look_over(system, system.initial_state()))
      if (finding.what.find("modes of") != std::string::npos) says = finding.what, alarm = finding.alarm;
  }
  int modes_left = 0;
  std::string says;
  bool alarm = false;
};

/// Each mode that strains the triangle, however little, is one that the nine rows remove.
TEST(DifferentialFindings, TheDoctorNamesModesThatThreeNodesLock) {
  for (const int modes : {2, 3, 5, 12}) {
    const HeldBar bar(false, modes);
    EXPECT_LT(bar.modes_left, modes);
    const std::string count = std::to_string(modes - bar.modes_left) + " of the " + std::to_string(modes) + " modes";
    expect_says(bar.says, {"'clamp' locks " + count + " of 'bar'", "by no more than 0.0"});
    EXPECT_EQ(bar.alarm, modes < 5);
  }
  const HeldBar of_its_frame(true, 3);
  EXPECT_EQ(of_its_frame.modes_left, 3);
  EXPECT_EQ(of_its_frame.says, "");
}

}  // namespace
}  // namespace lithe::test::differential_findings_test
