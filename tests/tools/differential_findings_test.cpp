// What differential fuzzing has found, each finding by itself.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/reduction.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/evaluated.h"
#include "engine/base/log.h"
#include "engine/motion/projection.h"
#include "engine/observe/recorder.h"
#include "engine/observe/sensors.h"
#include "engine/run/simulation.h"
#include "engine/study/doctor.h"
#include "integrators/moreau_jean.h"
#include "integrators/radau.h"
#include "joints/fixed_joint.h"
#include "joints/forces/bushing.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/point_force.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/three_node_fixation.h"
#include "tests/support/message_of.h"
#include "tests/support/methods.h"
#include "tests/support/scenes.h"
#include "tools/differential/runs.h"

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

/// What a step far too long had left as reactions, 1e42 N, was where the next one began its search: the round-off of
/// that stayed in its accelerations, and no step was short enough.
TEST(DifferentialFindings, ReactionsThatRubAreFoundFromAGuessThatIsFarOff) {
  Scene scene = rubbing_pendulum();
  scene.run(*runge_kutta8(1e-9), 0.4);
  const State& now = scene.state;
  Projector projector(scene.equations);
  VectorX exact(now.v.size()), found(now.v.size()), lambda = now.lambda;
  projector.accelerations(now.time, now.q, now.v, exact, lambda);
  const VectorX reactions = lambda;
  for (const double scale : {1.0, 1e3, 1e12, 1e42}) {
    lambda = scale * reactions;
    projector.accelerations(now.time, now.q, now.v, found, lambda);
    expect_below("acceleration off", (found - exact).norm() / exact.norm(), 1e-10);
    expect_below("reaction off", (lambda - reactions).norm() / reactions.norm(), 1e-10);
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

/// A bar in nodal coordinates in a frame of three nodes of its end, which spins: its modes can move against the frame
/// with next to no inertia. Newton's matrix had half of Coriolis' forces, which by that inertia were 1e4 times the
/// spin: each step of Radau that failed by it was halved, and a run took forty times as long.
TEST(DifferentialFindings, NewtonsMatrixOfASpinningNodalBarIsGood) {
  FiniteElementModel model = brick_mesh(
      {.size = {1, 0.1, 0.1}, .divisions = {3, 1, 1}, .type = "C3D8I", .material = {1e6, 0.3, 1000}, .name = "bar"});
  std::vector<int> near;
  for (Eigen::Index i = 0; i < model.nodes.cols(); ++i)
    if (model.nodes(0, i) < 1e-6) near.push_back(model.node_ids[static_cast<std::size_t>(i)]);
  const Vector3 spin(3, 2, 5);
  Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
    graph.add<FlexibleBody>("bar", {.basis = make_basis(model, ThreeNodeFrame{near[0], near[1], near[2]}, kAllNodal),
                                    .angular_velocity = spin});
  });
  // 1. What the tangent leaves out of the residual's derivative by velocities, by central differences, as M⁻¹ sees it.
  const State& now = scene.state;
  const int n = scene.system.layout().v_count();
  const VectorX none = VectorX::Zero(scene.system.layout().row_count());
  const auto residual = [&](const VectorX& v) {
    VectorX r(n);
    scene.equations.evaluate(now.time, now.q, v, Level::velocity);
    scene.equations.residual(now.v_dot, none, r);
    return r;
  };
  const auto tangent = [&](double velocity) {
    residual(now.v);
    scene.equations.factorize({0, velocity, 1}, now.v_dot, none, nullptr);
    MatrixX S = MatrixX::Zero(n, n);
    scene.equations.visit_blocks(
        [&](int row, int column, ConstMatrixRef block) { S.block(row, column, block.rows(), block.cols()) += block; });
    return S;
  };
  const MatrixX M = tangent(0), D = tangent(1) - M;
  MatrixX exact(n, n);
  for (int j = 0; j < n; ++j) {
    constexpr double kStep = 1e-3;  // the residual is quadratic in velocities: exact but for round-off
    VectorX ahead = now.v, back = now.v;
    ahead[j] += kStep, back[j] -= kStep;
    exact.col(j) = (residual(ahead) - residual(back)) / (2 * kStep);
  }
  const MatrixX left_out = M.partialPivLu().solve(D - exact);
  expect_below("what the tangent leaves out, over the spin", left_out.eigenvalues().cwiseAbs().maxCoeff() / spin.norm(),
               30);
  // 2. So that Newton's iteration does not hold steps back.
  Radau method({.tolerance = {1e-9, 1e-9}});
  scene.run(method, 0.05);
  EXPECT_LT(method.statistics().newton_failures, method.statistics().steps / 10);
}

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

/// A thin bar in a tangent frame, free, turned ever faster by a thruster at its end: Moreau-Jean's corrections grew
/// from step to step without a word until numbers were not finite.
TEST(DifferentialFindings, MoreauJeanFollowsATangentBodyThatTurnsFast) {
  const FiniteElementModel model = brick_mesh({.size = {0.1, 0.01, 0.01},
                                               .divisions = {6, 1, 1},
                                               .type = "C3D8I",
                                               .material = {2e9, 0.3, 1000},
                                               .name = "bar"});
  const auto basis = make_basis(model, TangentFrame{model.node_set("x_min")}, 4, {.deflection = Deflection::stiffened});
  const auto bar = [&] {
    return Scene(Vector3::Zero(), [&](SystemGraph& graph) {
      auto& body = graph.add<FlexibleBody>("bar", {.basis = basis, .damping = {.modal_ratios = {0.05}}});
      graph.add<PointForce>("thruster", {body.average(model.node_set("x_max"))},
                            {.force = {0, 16, 2.4}, .axes = PointForce::Axes::marker});
    });
  };
  constexpr double kEnd = 0.03;
  Scene exact = bar();
  exact.run(*runge_kutta8(1e-10), kEnd);
  // 2,883 rad/s in the end: three radians in the longest step.
  for (const auto& [h, bound] : {std::pair(1e-3, 0.1), std::pair(2e-4, 8e-4), std::pair(1e-4, 2e-4)}) {
    Scene scene = bar();
    MoreauJean method({.step = h});
    scene.run(method, kEnd);
    expect_below("error, m", (scene.position(0) - exact.position(0)).norm(), bound);
  }
}

/// A soft bar in a tangent frame spins freely. Corrections that were left, of 1e-3 of the velocities at most, added up
/// to 1e-4 m at a step of 2.5e-5 s. With half of Coriolis' forces in Newton's matrix they shrank so slowly that the
/// first step was halved four times on its way; now it is taken as it is, and errors are those of order 2.
TEST(DifferentialFindings, MoreauJeanTakesNoStepWhoseCorrectionsAreStillLarge) {
  const FiniteElementModel model = brick_mesh({.size = {0.1, 0.01, 0.01},
                                               .divisions = {6, 1, 1},
                                               .type = "C3D8I",
                                               .material = {2e8, 0.3, 1000},
                                               .name = "bar"});
  const auto basis = make_basis(model, TangentFrame{model.node_set("x_min")}, 4, {.deflection = Deflection::linear});
  const auto bar = [&] {
    return Scene(Vector3::Zero(), [&](SystemGraph& graph) {
      const Vector3 spin(240, 400, 600), middle(0.05, 0.005, 0.005);
      graph.add<FlexibleBody>("bar", {.basis = basis, .velocity = middle.cross(spin), .angular_velocity = spin});
    });
  };
  constexpr double kEnd = 0.02;
  Scene exact = bar();
  exact.run(*runge_kutta8(1e-11), kEnd);
  for (const double h : {1e-4, 2.5e-5, 6.25e-6}) {
    Scene scene = bar();
    MoreauJean method({.step = h});
    scene.run(method, kEnd);
    expect_below("error over h², m/s²", (scene.position(0) - exact.position(0)).norm() / (h * h), 4e4);
    EXPECT_EQ(method.statistics().steps, std::lround(kEnd / h));
  }
}

/// A soft bar in a tangent frame, held by a ball joint at its other end, spins. The factor of a step does not know how
/// a turn couples modes, and joints were closed along it alone: errors were ten times as large, and fell with the step.
TEST(DifferentialFindings, MoreauJeanTurnsATangentBodyInAJointByOrderTwo) {
  const FiniteElementModel model = brick_mesh({.size = {0.1, 0.01, 0.01},
                                               .divisions = {6, 1, 1},
                                               .type = "C3D8I",
                                               .material = {2e8, 0.3, 1000},
                                               .name = "bar"});
  const auto basis = make_basis(model, TangentFrame{model.node_set("x_min")}, 2, {.deflection = Deflection::linear});
  const auto bar = [&] {
    return Scene({0, 0, -9.81}, [&](SystemGraph& graph) {
      const Vector3 spin(60, 100, 150), pivot(0.1, 0.005, 0.005);
      auto& body =
          graph.add<FlexibleBody>("bar", {.basis = basis, .velocity = pivot.cross(spin), .angular_velocity = spin});
      graph.add<SphericalJoint>("ball", {graph.ground().marker(pivot), body.average(model.node_set("x_max"))});
    });
  };
  constexpr double kEnd = 0.02;
  Scene exact = bar();
  exact.run(*radau(1e-11), kEnd);
  double last = 0;
  for (const double h : {1e-4, 5e-5, 2.5e-5}) {
    Scene scene = bar();
    MoreauJean method({.step = h});
    scene.run(method, kEnd);
    const double error = (scene.position(0) - exact.position(0)).norm();
    expect_below("error over h², m/s²", error / (h * h), 2.5e3);
    if (last > 0) {
      EXPECT_NEAR(last / error, 4, 0.4) << h;
    }
    last = error;
  }
}

/// Of nine rows that clamp a bar at nodes of its frame six hold it. Rows were in the axes of the world: as the two
/// tumbled, the six that were kept as drawn lost rank, and methods failed. A fixed joint at the mean of the nodes does
/// the same.
TEST(DifferentialFindings, AClampOfThreeNodesKeepsItsRankAsItTumbles) {
  const FiniteElementModel model = brick_mesh(
      {.size = {1, 0.1, 0.1}, .divisions = {3, 1, 1}, .type = "C3D8I", .material = {1e9, 0.3, 1000}, .name = "bar"});
  std::vector<int> end;
  for (Eigen::Index i = 0; i < model.nodes.cols(); ++i)
    if (model.nodes(0, i) < 1e-6) end.push_back(model.node_ids[static_cast<std::size_t>(i)]);
  const auto basis = make_basis(model, TangentFrame{end}, 2, {});
  const auto tumbling = [&](bool by_nodes) {
    return Scene(Vector3::Zero(), [&](SystemGraph& graph) {
      const Vector3 spin(2, 3, -1), center(-0.5, 0, 0);
      auto& hub = graph.add<RigidBody>("hub", {.mass = 5,
                                               .inertia = {0.3, 0.2, 0.4},
                                               .position = center,
                                               .velocity = spin.cross(center),
                                               .angular_velocity = spin});
      auto& bar = graph.add<FlexibleBody>("bar", {.basis = basis, .angular_velocity = spin});
      const Marker holder = hub.marker(-center, rotation_about(Vector3(1, 2, 3).normalized(), 0.7));
      if (by_nodes)
        graph.add<ThreeNodeFixation>("clamp", {holder, bar.node(end[0]), bar.node(end[1]), bar.node(end[2])});
      else
        graph.add<FixedJoint>("clamp", {hub.marker(Vector3(0, 0.05, 0.05) - center), bar.average(end)});
    });
  };
  Scene nodes = tumbling(true), fixed = tumbling(false);
  EXPECT_EQ(nodes.system.degrees_of_freedom(), fixed.system.degrees_of_freedom());
  const Method of_nodes = radau(1e-9), of_fixed = radau(1e-9);
  for (const double t : {0.5, 1.0, 2.0, 4.0}) {
    nodes.run(*of_nodes, t);
    fixed.run(*of_fixed, t);
    expect_below("apart, m", (nodes.position(0) - fixed.position(0)).norm(), 1e-6);
  }
}

/// Two rods on one pin and joined at another point swing as one: a row says nothing, another one as they turn. In their
/// plane, to which the scene is simplified, no row ever took the place of the one left out, and runs failed.
TEST(DifferentialFindings, ALoopInItsPlaneExchangesTheRowThatIsLeftOut) {
  const auto draw = [](SystemGraph& graph) {
    const Matrix3 axis_y = rotation_about(Vector3::UnitX(), -M_PI / 2);
    const RigidBody::Parameters rod{.mass = 1, .inertia = {0.02, 0.02, 0.02}, .position = {0.5, 0, 0}};
    auto &one = graph.add<RigidBody>("one", rod), &two = graph.add<RigidBody>("two", rod);
    graph.add<RevoluteJoint>("pin of one",
                             {graph.ground().marker({0, 0, 0}, axis_y), one.marker({-0.5, 0, 0}, axis_y)});
    graph.add<RevoluteJoint>("pin of two",
                             {graph.ground().marker({0, 0, 0}, axis_y), two.marker({-0.5, 0, 0}, axis_y)});
    graph.add<RevoluteJoint>("tie", {one.marker({0.1, 0, 0.3}, axis_y), two.marker({0.1, 0, 0.3}, axis_y)});
  };
  constexpr double kEnd = 3;  // it has swung by more than half a turn, and back
  SystemGraph graph({.gravity = {0, 0, -9.81}});
  draw(graph);
  Simulation simulation(graph, [] { return runge_kutta8(1e-10); }, {.simplify = true, .sleep = false});
  State state = simulation.start();
  Recorder recorder({position(graph.find<RigidBody>("one")->marker(), "one")});
  simulation.observe(recorder, every(kEnd / 6));
  simulation.run(state, kEnd);
  // One rod alone: the same compound pendulum.
  Scene alone({0, 0, -9.81}, [](SystemGraph& free) {
    const Matrix3 axis_y = rotation_about(Vector3::UnitX(), -M_PI / 2);
    auto& rod = free.add<RigidBody>("rod", {.mass = 1, .inertia = {0.02, 0.02, 0.02}, .position = Vector3(0.5, 0, 0)});
    free.add<RevoluteJoint>("pin", {free.ground().marker({0, 0, 0}, axis_y), rod.marker({-0.5, 0, 0}, axis_y)});
  });
  alone.run(*runge_kutta8(1e-11), kEnd);
  const std::vector<double> x = recorder.table().column("one_x"), z = recorder.table().column("one_z");
  expect_below("apart, m", (Vector3(x.back(), 0, z.back()) - alone.position(0)).norm(), 1e-7);
}

/// At the first steps, a microsecond long, corrections were those of round-off after one iteration. Their rate, 1,
/// counted as that of Newton's method, and each step was shorter than the one before until time stood still.
TEST(DifferentialFindings, RadauTakesNoRateOfRoundOffForAReasonToShortenSteps) {
  using namespace differential;
  const log::Quiet quiet;
  const DrawnScene scene = draw_scene(7739);
  const Track found = run(scene, {.method = differential::Method::radau, .tolerance = 1e-9});
  ASSERT_EQ(found.refused, "");
  const Difference apart =
      difference(scene.units, run(scene, {.method = differential::Method::runge_kutta8, .tolerance = 1e-9}), found);
  for (const double kind : apart.of) EXPECT_LT(kind, 1e-6);
}

/// A free bar under a force at a point, spun up through resonance: two bars that turn by 1e-6 of their speed otherwise
/// are far apart in the end. A disturbance that shifts all bodies alike does not tell.
TEST(DifferentialFindings, ADisturbanceTellsTheSensitivityOfAFreeBody) {
  using namespace differential;
  const log::Quiet quiet;
  DrawnScene scene = draw_scene(7796);
  scene.duration /= 2;
  const Way way{.method = differential::Method::runge_kutta8, .tolerance = 1e-9};
  Way disturbed = way;
  disturbed.nudge = 1e-6;
  const Difference apart = difference(scene.units, run(scene, way), run(scene, disturbed));
  EXPECT_GT(apart.of[static_cast<int>(Kind::energy)], 1e-4);
}

/// What a force does to a bar in a tangent frame is what the bar's energy grows by, at any spin and deflection: the
/// rate of its energy along the accelerations, by differences.
TEST(DifferentialFindings, AForceGivesATangentBodyItsPower) {
  constexpr double kLength = 0.5, kStep = 1e-6;
  FiniteElementModel model = brick_mesh({.size = {kLength, 0.05, 0.05},
                                         .divisions = {3, 1, 1},
                                         .type = "C3D8I",
                                         .material = {1e8, 0.3, 1000},
                                         .name = "bar"});
  std::vector<int> near, far;
  for (Eigen::Index i = 0; i < model.nodes.cols(); ++i) {
    const int label = model.node_ids[static_cast<std::size_t>(i)];
    if (model.nodes(0, i) < 1e-6) near.push_back(label);
    if (model.nodes(0, i) > kLength - 1e-6) far.push_back(label);
  }
  const Vector3 force(30, -20, 10), torque(3, 1, -2);
  for (const Deflection deflection : {Deflection::linear, Deflection::quadratic, Deflection::stiffened})
    for (const auto axes : {PointForce::Axes::world, PointForce::Axes::marker}) {
      Marker tip;
      Scene scene(Vector3::Zero(), [&](SystemGraph& graph) {
        auto& bar = graph.add<FlexibleBody>(
            "bar", {.basis = make_basis(model, TangentFrame{near}, 3, {.deflection = deflection})});
        tip = bar.average(far);
        graph.add<PointForce>("thruster", {tip}, {.force = force, .torque = torque, .axes = axes});
      });
      Evaluator& equations = scene.equations;
      Projector projector(equations);
      for (int k = 0; k < 20; ++k) {
        State state = scene.state;
        const VectorX d = VectorX::Random(state.v.size());
        VectorX turn = d;
        turn.tail(3) *= 0.01;  // modes, whose shapes are some units long
        equations.layout().retract(state.q, turn, state.q);
        state.v = 10 * VectorX::Random(state.v.size());
        state.v.segment<3>(3) *= 20;
        VectorX v_dot(state.v.size()), lambda(0), moved(state.v.size()), q(state.q.size());
        projector.accelerations(0, state.q, state.v, v_dot, lambda);
        const auto energy_at = [&](double t) {
          moved = t * state.v + 0.5 * t * t * v_dot;
          equations.layout().retract(state.q, moved, q);
          equations.evaluate(0, q, state.v + t * v_dot, Level::velocity);
          const BodyEnergy energy = equations.energy();
          return energy.kinetic + energy.elastic;
        };
        const auto rate_by = [&](double t) { return (energy_at(t) - energy_at(-t)) / (2 * t); };
        const double rate = (4 * rate_by(kStep / 2) - rate_by(kStep)) / 3, size = energy_at(0);
        const MarkerKinematics at = marker_kinematics(equations, tip, Level::velocity);
        // A force along axes of the world counts as potential energy, its torque does not.
        const double power =
            axes == PointForce::Axes::marker ? (at.R * force).dot(at.v) + (at.R * torque).dot(at.w) : torque.dot(at.w);
        const double scale = force.norm() * at.v.norm() + torque.norm() * at.w.norm();
        EXPECT_NEAR(rate, power, 1e-6 * scale + 1e-15 * std::abs(size) / kStep) << k;
      }
    }
}

}  // namespace
}  // namespace lithe::test::differential_findings_test
