// Control diagrams with more coordinates and states than one element has room for.
#include <gtest/gtest.h>

#include <cmath>
#include <deque>

#include "engine/analysis/state_space.h"
#include "engine/archive/archive.h"
#include "engine/run/simulation.h"
#include "joints/control/control_force.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/joint_checks.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/message_of.h"
#include "tests/support/pairs.h"

namespace lithe::test::wide_control_test {
namespace {

// ---- state feedback ----

/// Masses on slides, each pushed by the states of all and by a filter of its own, which sees all again:
///   m_i ẍ_i = -(K x + D ẋ + C z)_i,   ż = A z + B x
struct StateFeedback {
  static constexpr int kCount = 20;
  static MatrixX numbers(double scale, double seed) {
    MatrixX M(kCount, kCount);
    for (int i = 0; i < kCount; ++i)
      for (int j = 0; j < kCount; ++j) M(i, j) = scale * std::sin(seed + 1.7 * i + 2.3 * j + 0.4 * i * j);
    return M;
  }

  StateFeedback() {
    masses = VectorX::LinSpaced(kCount, 1, 3);
    K = numbers(1.5, 0.3), K.diagonal().array() += 60;
    D = numbers(0.2, 1.1), D.diagonal().array() += 3;
    C = numbers(2, 2.2), B = numbers(1, 0.7);
    A = numbers(0.3, 1.9), A.diagonal().array() -= 4;
    std::vector<ControlSignal> u;
    std::vector<JointCoordinate> x;
    for (int i = 0; i < kCount; ++i) {
      const Vector3 at(0, i, 0);
      auto& mass = graph.add<RigidBody>("mass " + std::to_string(i),
                                        {.mass = masses[i], .position = at, .velocity = {0, 0, std::cos(1.3 * i)}});
      auto& slide = graph.add<PrismaticJoint>("slide " + std::to_string(i), {graph.ground().marker(at), mass.marker()});
      x.push_back(slide.displacement());
    }
    for (const auto& c : x) u.push_back(diagram.value(c));
    for (const auto& c : x) u.push_back(diagram.rate(c));
    MatrixX by_x(kCount, 2 * kCount), direct(kCount, 2 * kCount);
    by_x << B, MatrixX::Zero(kCount, kCount);
    direct << -K, -D;
    const auto effort = diagram.state_space(u, A, by_x, -C, direct);
    for (int i = 0; i < kCount; ++i) diagram.push(x[i], effort[i]);
    auto& states = graph.add<FirstOrderStates>("states", {.start = diagram.start()});
    control = &add_control(graph, "feedback", diagram, states);
  }
  /// ẏ = L y, y = (x, ẋ, z)
  MatrixX linear() const {
    constexpr int n = kCount;
    MatrixX L = MatrixX::Zero(3 * n, 3 * n);
    const MatrixX M = masses.cwiseInverse().asDiagonal();
    L.block(0, n, n, n).setIdentity();
    L.block(n, 0, n, n) = -M * K, L.block(n, n, n, n) = -M * D, L.block(n, 2 * n, n, n) = -M * C;
    L.block(2 * n, 0, n, n) = B, L.block(2 * n, 2 * n, n, n) = A;
    return L;
  }

  SystemGraph graph{{.gravity = {0, 0, 0}}};
  ControlDiagram diagram;
  ControlForce* control = nullptr;
  VectorX masses;
  MatrixX K, D, C, A, B;
};

TEST(WideControl, OfTwentyCoordinatesHasTheEigenvaluesOfItsMatrix) {
  StateFeedback scene;
  EXPECT_EQ(scene.control->part_count(), 5 + 2);
  EXPECT_EQ(scene.graph.forces().size(), 7u);
  EXPECT_EQ(scene.graph.forces()[6].force->name(), "feedback part 7");
  const System system = assemble(scene.graph);
  std::vector<Complex> found;
  for (const Mode& mode : linearize(system, system.initial_state()).modes) {
    found.push_back(mode.eigenvalue);
    found.push_back(std::conj(mode.eigenvalue));
  }
  for (const Complex wanted : eigenvalues(scene.linear())) {
    double nearest = 1e9;
    for (const Complex one : found) nearest = std::min(nearest, std::abs(one - wanted));
    EXPECT_LT(nearest, 1e-7 * std::abs(wanted)) << wanted;
  }
}

/// y(t) = e^(L t) y₀ by its series over short parts.
TEST(WideControl, OfTwentyCoordinatesMovesAsItsExponential) {
  constexpr int n = StateFeedback::kCount;
  const double t = 0.2;
  StateFeedback scene;
  const MatrixX L = scene.linear() * (t / 256);
  MatrixX part = MatrixX::Identity(3 * n, 3 * n), power = part;
  for (int k = 1; k < 20; ++k) power = power * L / k, part += power;
  for (int k = 0; k < 8; ++k) part = (part * part).eval();
  const System system = assemble(scene.graph);
  const NamedMethod methods[] = {{"Runge-Kutta", runge_kutta(1e-9)},
                                 {"Radau", radau(1e-9)},
                                 {"BDF", bdf(1e-9)},
                                 {"IDA", ida(1e-9)},
                                 {"index 2", index2(2.5e-4)}};
  for (const NamedMethod& method : methods) {
    State state = system.initial_state();
    VectorX start = VectorX::Zero(3 * n);
    for (int i = 0; i < n; ++i) start[n + i] = std::cos(1.3 * i);
    const VectorX expected = part * start;
    Simulation(system, *method.integrator).run(state, t);
    double worst = 0;
    for (int i = 0; i < n; ++i) {
      const auto& slice = system.layout().bodies()[static_cast<std::size_t>(i)];
      worst = std::max(
          {worst, std::abs(state.q[slice.q + 2] - expected[i]), std::abs(state.v[slice.v + 2] - expected[n + i])});
    }
    expect_below("by " + method.name, worst, 1e-6);
  }
}

// ---- the same as small ones ----

/// A chain of hinges about changing axes under PIDs with filters and limits, as one diagram or as one of each joint.
struct Robot {
  static constexpr int kJoints = 10;
  explicit Robot(bool wide) {
    for (int i = 0; i < kJoints; ++i) {
      const std::string number = std::to_string(i);
      auto& link = graph.add<RigidBody>(
          "link " + number, {.mass = 2 - 0.1 * i, .inertia = {0.02, 0.015, 0.01}, .position = {0, 0, 0.3 * i + 0.15}});
      const Matrix3 axes = rotation_about({i % 2 == 0 ? 1.0 : 0.0, i % 2 == 0 ? 0.0 : 1.0, 0}, -kPi / 2);
      auto& hinge = graph.add<RevoluteJoint>(
          "hinge " + number, {i == 0 ? graph.ground().marker({0, 0, 0}, axes) : on_last->marker({0, 0, 0.15}, axes),
                              link.marker({0, 0, -0.15}, axes)});
      on_last = &link;
      hinges.push_back(&hinge);
    }
    for (int i = 0; i < kJoints; ++i) {
      if (diagrams.empty() || !wide) diagrams.emplace_back();
      ControlDiagram& d = diagrams.back();
      const JointCoordinate x = hinges[static_cast<std::size_t>(i)]->angle();
      d.push(x, d.pid(d.law(smooth_step(0, 0.3 - 0.05 * i, 0, 0.3)) - d.value(x),
                      {.proportional = 300, .integral = 200, .derivative = 20, .filter = 200, .limit = 60}));
    }
    for (std::size_t i = 0; i < diagrams.size(); ++i) {
      auto& states = graph.add<FirstOrderStates>("states " + std::to_string(i), {.start = diagrams[i].start()});
      controls.push_back(&add_control(graph, "servo " + std::to_string(i), diagrams[i], states));
    }
  }
  VectorX angles(const System& system, const State& state) const {
    VectorX all(kJoints);
    Snapshot now(system, state);
    for (int i = 0; i < kJoints; ++i) all[i] = coordinate(hinges[static_cast<std::size_t>(i)]->angle(), "").value(now);
    return all;
  }

  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  std::deque<ControlDiagram> diagrams;
  std::vector<RevoluteJoint*> hinges;
  std::vector<ControlForce*> controls;
  RigidBody* on_last = nullptr;
};

TEST(WideControl, MovesARobotOfTenJointsAsTenDiagrams) {
  Robot ten(false), one(true);
  EXPECT_EQ(ten.graph.forces().size(), 10u);
  EXPECT_EQ(one.controls[0]->part_count(), 3 + 2);
  const System of_ten = assemble(ten.graph), of_one = assemble(one.graph);
  const auto run = [](const Robot& robot, const System& system, Method method) {
    State state = system.initial_state();
    Simulation(system, *method).run(state, 0.15);
    return robot.angles(system, state);
  };
  const VectorX expected = run(ten, of_ten, runge_kutta(1e-10));
  EXPECT_GT(expected.cwiseAbs().maxCoeff(), 0.05);
  for (NamedMethod& method : every_method(5e-4, 1e-9)) {
    const VectorX angles = run(one, of_one, std::move(method.integrator));
    expect_below("by " + method.name, (angles - expected).lpNorm<Eigen::Infinity>(),
                 method.name.starts_with("index") ? 1e-4 : 1e-7);
  }
}

TEST(WideControl, ResumesWithTheSameBits) {
  for (auto* make : {+[] { return radau(1e-6); }, +[] { return automatic(1e-6); }}) {
    Robot robot(true);
    const System system = assemble(robot.graph);
    Method whole_method = make(), first_method = make(), second_method = make();
    Simulation whole(system, *whole_method), first(system, *first_method), second(system, *second_method);
    State state = system.initial_state(), stopped = state;
    whole.run(state, 0.1), whole.run(state, 0.2);
    first.run(stopped, 0.1);
    Archive archive;
    first.save(stopped, archive);
    archive.rewind();
    State goes_on = second.resume(archive);
    second.run(goes_on, 0.2);
    EXPECT_EQ(goes_on.q, state.q);
    EXPECT_EQ(goes_on.v, state.v);
  }
}

/// Relays of a large diagram switch in all of its parts.
TEST(WideControl, HasRelaysThatAllOfItsPartsSee) {
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  ControlDiagram d;
  const ControlSignal on = d.greater(d.law(ramp(0, 1)), d.number(0.5), "late");
  std::vector<RigidBody*> masses;
  for (int i = 0; i < 6; ++i) {
    const Vector3 at(0, i, 0);
    masses.push_back(&graph.add<RigidBody>("mass " + std::to_string(i), {.mass = 2, .position = at}));
    auto& slide =
        graph.add<PrismaticJoint>("slide " + std::to_string(i), {graph.ground().marker(at), masses.back()->marker()});
    d.push(slide.displacement(), 4 * on);
  }
  auto& states = graph.add<FirstOrderStates>("states", {.start = d.start()});
  ControlForce& control = add_control(graph, "switch", d, states);
  EXPECT_EQ(control.part_count(), 3);
  const System system = assemble(graph);
  const Method method = runge_kutta(1e-9);
  Simulation simulation(system, *method);
  State state = system.initial_state();
  control.join(simulation, state);
  simulation.run(state, 1.5);
  for (RigidBody* mass : masses) EXPECT_NEAR(Snapshot(system, state).marker(mass->marker()).v.z(), 2, 1e-9);
}

/// Against differences of the force: how wrenches and what is measured turn with the bodies, between coordinates that
/// share their bodies.
TEST(WideControl, IsExactInNewtonsMatrixBetweenAllBodies) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    const std::vector<Marker> ends = pair.draw(graph, {0.3, 0.5, -0.4});
    std::vector<JointCoordinate> x = {{JointCoordinate::Kind::distance, ends[0], ends[1]}};
    for (int axis = 0; axis < 3; ++axis) x.push_back(displacement_between(ends[0], ends[1], axis));
    x.push_back(-displacement_between(ends[1], ends[0], 1));
    ControlDiagram d;
    const ControlSignal slow = d.lag(d.value(x[0]) * d.rate(x[2]), 0.3);
    for (std::size_t i = 0; i < x.size(); ++i) {
      const ControlSignal next = d.value(x[(i + 1) % x.size()]), turned = d.rate(x[(i + 2) % x.size()]);
      d.push(x[i], d.function(slow + next, [](double u) { return std::sin(u); }) * d.value(x[i]) - 3 * d.rate(x[i]) -
                       2 * turned + d.transfer_function(next, {2, 30}, {1, 5, 40}));
    }
    auto& states = graph.add<FirstOrderStates>("states", {.start = d.start()});
    ControlForce& control = add_control(graph, "control", d, states);
    ASSERT_EQ(control.part_count(), 3);
    check_force(graph, control, {.conservative = false, .tolerance = 1e-7, .parts = 3});
  }
}

}  // namespace
}  // namespace lithe::test::wide_control_test
