// Rows that repeat each other and do not agree, and joints beyond their limits: found by differential fuzzing, where
// the order of elements decided what a scene did.
#include <gtest/gtest.h>

#include "bodies/beam/beam.h"
#include "engine/assembly/batch_of.h"
#include "engine/base/log.h"
#include "engine/model/joint_by_residual.h"
#include "engine/run/simulation.h"
#include "joints/constant_velocity_joint.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/bushing.h"
#include "joints/screw_joint.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/message_of.h"

namespace lithe::test::contradictions_test {
namespace {

const MotionLaw kSteady = ramp(0.2, 3);

/// That of kSteady up to 0.1 s, and ahead of it by (t - 0.1)⁴ from there on: rates and accelerations agree at first.
Motion leaves(double t) {
  Motion motion = kSteady(t);
  const double s = std::max(0.0, t - 0.1);
  motion.value += s * s * s * s, motion.rate += 4 * s * s * s, motion.acceleration += 12 * s * s;
  return motion;
}

/// A hinge at 0.2 rad that `laws` drive, each for itself: of a rigid body, or of a beam of 0.4 m.
void draw_driven(SystemGraph& graph, const std::vector<MotionLaw>& laws, bool flexible) {
  const Matrix3 turned = rotation_about({0, 0, 1}, 0.2);
  Marker hub;
  if (flexible) {
    const BeamSection section = BeamSection::rectangle(0.02, 0.02, {.young = 1e6, .poisson = 0.3, .density = 1000});
    auto& arm = graph.add<Beam>("arm", {.axis = BeamAxis::straight({0, 0, 0}, turned * Vector3(0.4, 0, 0), {0, 0, 1}),
                                        .sections = {{0, section}},
                                        .elements = 2,
                                        .angular_velocity = {0, 0, 3}});
    hub = arm.marker(0, {}, arm.axes(0).transpose() * turned);
  } else {
    hub = graph.add<RigidBody>("arm", {.orientation = turned, .angular_velocity = {0, 0, 3}}).marker();
  }
  auto& hinge = graph.add<RevoluteJoint>("hinge", {graph.ground().marker(), hub});
  for (std::size_t i = 0; i < laws.size(); ++i)
    graph.add<CoordinateDrive>("drive " + std::to_string(i + 1), {hinge.angle()}, {.motion = laws[i]});
}

std::string refusal(const std::vector<MotionLaw>& laws, bool flexible = false) {
  SystemGraph graph;
  draw_driven(graph, laws, flexible);
  return message_of<SceneError>([&] { assemble(graph); });
}

TEST(Contradictions, DrivesOfOneAngleThatAskForDifferentMotionsAreRefusedInAnyOrder) {
  const MotionLaw other_place = constant(0.3), other_rate = ramp(0.2, 3.001);
  const MotionLaw other_acceleration = [](double t) { return Motion{0.2 + 3 * t + t * t, 3 + 2 * t, 2}; };
  for (const bool flexible : {false, true})
    for (const auto& [law, says] : {std::pair(other_place, "is off by"),
                                    {other_rate, "has a rate that is off by"},
                                    {other_acceleration, "has an acceleration that is off by"}}) {
      SCOPED_TRACE(says);
      for (const auto& laws : {std::vector{kSteady, law}, {law, kSteady}})
        expect_says(refusal(laws, flexible), {"'drive 1' and 'drive 2' repeat each other", says, "remove one of them"});
    }
}

/// Rows of forces follow those of joints in what is known of rows: the names depended on what memory held behind a
/// vector.
TEST(Contradictions, BushingsDoNotChangeTheNames) {
  for (const double filled : {1e200, -1e100, 0.0}) {
    SystemGraph graph;
    draw_driven(graph, {kSteady, constant(0.3)}, false);
    for (int i = 0; i < 4; ++i)
      graph.add<Bushing>("bushing " + std::to_string(i),
                         {graph.ground().marker(), graph.find<RigidBody>("arm")->marker()},
                         {.stiffness = Bushing::diagonal({1, 1, 1}, {1, 1, 1})});
    std::vector<VectorX> memory;  // what is freed here is what others are given
    for (int size = 1; size < 200; ++size)
      for (int k = 0; k < 4; ++k) memory.emplace_back(VectorX::Constant(size, filled));
    memory.clear();
    expect_says(message_of<SceneError>([&] { assemble(graph); }), {"'drive 1' and 'drive 2' repeat each other"});
  }
}

/// The angle and the travel of a screw are one motion: what the second drive repeats is the first and the screw.
TEST(Contradictions, DrivesOfBothMotionsOfAScrewAreNamed) {
  const auto draw = [](SystemGraph& graph, double rise) {
    auto& nut = graph.add<RigidBody>("nut", {});
    auto& screw = graph.add<ScrewJoint>("screw", {graph.ground().marker(), nut.marker()}, {.lead = 0.1});
    graph.add<CoordinateDrive>("turn", {screw.angle()}, {.motion = ramp(0, 2 * kPi)});
    graph.add<CoordinateDrive>("lift", {screw.displacement()}, {.motion = ramp(0, rise)});
  };
  SystemGraph good, bad;
  draw(good, 0.1), draw(bad, 0.11);
  EXPECT_EQ(assemble(good).redundant_rows().size(), 1u);
  expect_says(message_of<SceneError>([&] { assemble(bad); }), {"'turn'", "'lift'", "repeat each other", "rate"});
}

TEST(Contradictions, DrivesThatAgreeAreReportedAndMoveAsOne) {
  for (const bool flexible : {false, true})
    for (auto& [name, method] : every_method(2e-3, 1e-8)) {
      SCOPED_TRACE(name);
      Scene one({0, 0, 0}, [&](SystemGraph& graph) { draw_driven(graph, {kSteady}, flexible); });
      Scene two({0, 0, 0}, [&](SystemGraph& graph) { draw_driven(graph, {kSteady, kSteady}, flexible); });
      ASSERT_EQ(two.system.redundant_rows().size(), 1u);
      EXPECT_NE(two.system.redundant_rows()[0].name.find("drive"), std::string::npos);
      EXPECT_NE(two.system.redundant_rows()[0].repeats.find("drive"), std::string::npos);
      EXPECT_NE(log::last_warning().find("1 dependent constraint row"), std::string::npos) << log::last_warning();
      one.run(*method, 0.2);
      two.run(*method, 0.2);
      EXPECT_LT((one.state.q - two.state.q).norm(), 1e-7);
    }
}

/// s⁴ is 1e-6 after 32 ms. Where a method leaves 4e-9 in the other rows (IDA), it may be four times as much.
TEST(Contradictions, DrivesThatPartOnTheWayEndTheRun) {
  for (const bool flexible : {false, true})
    for (auto& [name, method] : every_method(2e-3, 1e-8)) {
      SCOPED_TRACE(name);
      SystemGraph graph{{.gravity = {0, 0, 0}}};
      draw_driven(graph, {kSteady, leaves}, flexible);
      const System system = assemble(graph);
      Simulation simulation(system, *method);
      State state = system.initial_state();
      simulation.run(state, 0.1);  // so far they agree
      EXPECT_EQ(state.time, 0.1);
      for (double end = 0.105; end < 0.125; end += 5e-3) simulation.run(state, end);
      const double last = state.time;
      const std::string says = message_of<SimulationError>([&] {
        for (double end = last + 5e-3; end < 0.3; end += 5e-3) simulation.run(state, end);
      });
      expect_says(says, {"'drive 1' and 'drive 2' repeat each other", "is off by", "t = 0.1", "remove one of them"});
      EXPECT_GE(state.time, last);
      EXPECT_LE(state.time, 0.1 + std::pow(5e-6, 0.25) + 1e-9);
      EXPECT_TRUE(state.q.allFinite());
    }
}

/// Holds height as the hinge does, but for 0.1 y⁸: a row that repeats another one as drawn and near it, and not beyond.
struct Ramp final : JointByResidual<Ramp, /*markers=*/2, /*rows=*/1> {
  template <class S>
  void residual(std::span<const PoseOf<S>> m, S* g) const {
    const S y_2 = m[1].p.y() * m[1].p.y(), y_4 = y_2 * y_2;
    g[0] = m[1].p.z() - m[0].p.z() + 0.1 * (y_4 * y_4);
  }
};

TEST(Contradictions, ARowThatNoLongerRepeatsOthersEndsTheRun) {
  for (auto& [name, method] : every_method(2e-3, 1e-8)) {
    SCOPED_TRACE(name);
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    auto& arm =
        graph.add<RigidBody>("arm", {.position = {0.5, 0, 0}, .velocity = {0, 1, 0}, .angular_velocity = {0, 0, 2}});
    graph.add<RevoluteJoint>("hinge", {graph.ground().marker(), arm.marker({-0.5, 0, 0})});
    graph.add<Ramp>("ramp", {graph.ground().marker(), arm.marker({0.5, 0, 0})});
    const System system = assemble(graph);
    ASSERT_EQ(system.redundant_rows().size(), 1u);
    Simulation simulation(system, *method);
    State state = system.initial_state();
    const std::string says = message_of<SimulationError>([&] {
      for (int i = 1; i <= 100; ++i) simulation.run(state, 5e-3 * i);
    });
    expect_says(says, {"'hinge'", "'ramp'", "do not agree"});
    const double expected = std::asin(std::pow(1e-5, 1.0 / 8)) / 2;  // y = sin(2 t)
    EXPECT_LE(state.time, expected + 1e-9);
    EXPECT_GT(state.time, expected - 1e-2);
  }
}

/// Without loads a shaft turns steadily about the axis of its bend, and is at a right angle after π/2 rad.
TEST(ConstantVelocityJoint, EndsTheRunAtARightAngle) {
  constexpr double kTurn = 2;  // rad/s
  for (auto& [name, method] : every_method(2e-3, 1e-8)) {
    SCOPED_TRACE(name);
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    auto& shaft = graph.add<RigidBody>("shaft", {.inertia = {0.1, 0.12, 0.05}, .angular_velocity = {kTurn, 0, 0}});
    graph.add<ConstantVelocityJoint>("boot", {graph.ground().marker(), shaft.marker()});
    const System system = assemble(graph);
    Simulation simulation(system, *method);
    State state = system.initial_state();
    const std::string says = message_of<SimulationError>([&] {
      for (int i = 1; i <= 200; ++i) simulation.run(state, 1e-2 * i);
    });
    expect_says(says, {"'boot' is bent by 9", "degrees", "right angle", "t = 0.7"});
    EXPECT_GT(state.time, kPi / 2 / kTurn - 2e-2);
    EXPECT_LE(state.time, kPi / 2 / kTurn + 1e-9);
  }
}

}  // namespace
}  // namespace lithe::test::contradictions_test
