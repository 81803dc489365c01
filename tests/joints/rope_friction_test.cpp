#include <gtest/gtest.h>

#include "bodies/point_mass.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/point_force.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/rope/rope.h"
#include "tests/support/methods.h"

/// Friction between ropes and pulleys: the capstan, a load that is held, belts and their creep. Gravity along -y.
namespace lithe::test::rope_friction_test {
namespace {

constexpr double kGravity = 9.81;
const SystemGraph::Parameters kDown{.gravity = {0, -kGravity, 0}}, kWeightless{.gravity = {0, 0, 0}};
const Matrix3 kUp = rotation_about({1, 0, 0}, -M_PI / 2);  // z of a slider along y

double read(const System& system, const State& state, const Sensor& sensor) {
  Snapshot now{system, state};
  return sensor.value(now);
}

// ---- a rope over a bollard ----

constexpr double kLoad = 10, kFriction = 0.3;

/// A load is pulled down on one side; the other end is moved by a drive from `start` on, up at `speed`.
struct Capstan {
  SystemGraph graph{kWeightless};
  PointMass* load;
  Rope rope;

  Capstan(double speed, int turns) {
    load = &graph.add<PointMass>("load", {.mass = kLoad, .position = {-0.2, -2, 0}});
    graph.add<PointForce>("pull down", {load->marker()}, {.force = {0, -kLoad * kGravity, 0}});
    auto& hand = graph.add<RigidBody>("hand", {.position = {0.2, -2, 0}, .velocity = {0, speed, 0}});
    auto& guide =
        graph.add<PrismaticJoint>("guide", {graph.ground().marker({0.2, -2, 0}, kUp), hand.marker({0, 0, 0}, kUp)});
    graph.add<CoordinateDrive>("pull", {guide.displacement()}, {.motion = ramp(0, speed)});
    rope = reeve(
        graph, "rope", {{load->marker()}, {hand.marker()}},
        {.pulleys =
             {{.marker = graph.ground().marker(), .radius = 0.2, .sense = -1, .friction = kFriction, .turns = turns}},
         .axial_stiffness = 1e5,
         .axial_damping = 2e3,
         .mass_per_length = 0.2,
         .pretension = kLoad * kGravity});
  }
};

/// Drawn over a bollard, the rope needs e^(μα) of the load; let down, it holds all but e^(-μα) of it.
TEST(RopeFriction, ASlippingRopeHasTheCapstanRatio) {
  for (int turns : {0, 1})
    for (double speed : {-0.05, 0.05}) {
      Capstan capstan(speed, turns);
      const System system = assemble(capstan.graph);
      State state = system.initial_state();
      const Method method = radau(1e-9);
      Simulation simulation{system, *method};
      simulation.run(state, 12);
      const double wrap = M_PI * (1 + 2 * turns), ratio = std::exp(-std::copysign(kFriction * wrap, speed));
      const double measured =
          read(system, state, tension(capstan.rope, 1)) / read(system, state, tension(capstan.rope, 0));
      expect_below("capstan ratio", std::abs(measured / ratio - 1), 1e-6);
      EXPECT_NEAR(read(system, state, tension(capstan.rope, 0)), kLoad * kGravity, 1e-4);
    }
}

/// A load of 10 kg over a bollard that holds another of up to 25 kg.
SystemGraph& draw_loads(SystemGraph& graph, double heavy_mass) {
  auto& light = graph.add<PointMass>("light", {.mass = 10, .position = {-0.2, -2, 0}});
  auto& heavy = graph.add<PointMass>("heavy", {.mass = heavy_mass, .position = {0.2, -2, 0}});
  reeve(graph, "rope", {{light.marker()}, {heavy.marker()}},
        {.pulleys = {{.marker = graph.ground().marker(), .radius = 0.2, .sense = -1, .friction = kFriction}},
         .axial_stiffness = 1e5,
         .axial_damping = 2e3,
         .mass_per_length = 0.2,
         .pretension = 15 * kGravity});
  return graph;
}

TEST(RopeFriction, ALoadBelowTheLimitIsHeldWithoutDrift) {
  SystemGraph graph{kDown};
  const System system = assemble(draw_loads(graph, 20));
  State state = system.initial_state();
  const Method method = radau(1e-10);
  Simulation simulation{system, *method};
  simulation.run(state, 3);
  const VectorX settled = state.q;
  simulation.run(state, 60);
  expect_below("drift in a minute, m", (state.q - settled).head<6>().cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(std::abs(settled[4] + 2), 0.01);
}

/// The bristles of a rope in equilibrium have not slipped: they hold the loads as they are bent then.
TEST(RopeFriction, AnEquilibriumHasItsFriction) {
  SystemGraph graph{kDown};
  const System system = assemble(draw_loads(graph, 20));
  Equilibrium rest = find_equilibrium(system, system.initial_state());
  EXPECT_LT(std::abs(rest.state.q[4] + 2), 0.01);
  const VectorX q = rest.state.q;
  const Method method = radau(1e-9);
  Simulation simulation{system, *method};
  simulation.run(rest.state, 1);
  EXPECT_LT((rest.state.q - q).head<6>().cwiseAbs().maxCoeff(), 1e-8);
}

/// A state is all that there is to know: the bristles are in it.
TEST(RopeFriction, ARestartedRunGoesOnAsItWas) {
  SystemGraph graph{kDown};
  const System system = assemble(draw_loads(graph, 20));
  State whole = system.initial_state(), parts = whole;
  const Method method = runge_kutta_fixed(1e-4), other = runge_kutta_fixed(1e-4);
  Simulation{system, *method}.run(whole, 0.2);
  Simulation{system, *method}.run(parts, 0.1);
  Simulation{system, *other}.run(parts, 0.2);
  EXPECT_LT((whole.q - parts.q).cwiseAbs().maxCoeff(), 1e-13);
}

/// Held and sliding.
TEST(RopeFriction, EveryIntegratorAgrees) {
  for (const double heavy_mass : {20.0, 35.0}) {
    const auto end = [&](Method method) {
      SystemGraph graph{kDown};
      const System system = assemble(draw_loads(graph, heavy_mass));
      State state = system.initial_state();
      Simulation simulation{system, *method};
      simulation.run(state, 0.3);
      return Vector3(state.q[1], state.q[4], state.q[6]);
    };
    const Vector3 reference = end(runge_kutta8(1e-11));
    EXPECT_EQ(reference[1]<-2.05, heavy_mass> 30) << reference[1];
    const double h = 2e-4;
    const auto check = [&](const std::string& name, Method method, double bound) {
      expect_below(name, (end(std::move(method)) - reference).norm(), bound);
    };
    check("runge_kutta", runge_kutta(1e-8), 1e-6);
    check("adams", adams(1e-8), 1e-6);
    check("automatic", automatic(1e-8), 1e-6);
    check("ida", ida(1e-8), 1e-5);
    check("index3", index3(h), 1e-5);
    check("index2", index2(h), 1e-5);
    if (heavy_mass > 30) check("rattle", rattle(h / 10), 1e-5);  // explicit: h < 2 δ/v
    check("radau", radau(1e-8), 1e-6);
    check("bdf", bdf(1e-8), 1e-5);
    check("hht", hht(h), 1e-5);
    check("linearly_implicit", linearly_implicit(h, 2), 1e-4);
    check("energy_momentum", energy_momentum(h), 1e-5);
  }
}

// ---- belts ----

constexpr double kR1 = 0.1, kR2 = 0.2, kEA = 1e5, kPretension = 100, kSpeed = 20;

/// A driven wheel, a belt, and a wheel that a brake holds back.
struct BeltDrive {
  SystemGraph graph{kWeightless};
  RevoluteJoint *driver, *driven;
  Rope belt;

  BeltDrive(double friction, std::function<double(double)> brake) {
    const auto wheel = [&](const std::string& name, double x, double speed) {
      auto& body = graph.add<RigidBody>(
          name, {.inertia = {0.02, 0.02, 0.02}, .position = {x, 0, 0}, .angular_velocity = {0, 0, speed}});
      return &graph.add<RevoluteJoint>(name + " pin", {graph.ground().marker({x, 0, 0}), body.marker()});
    };
    driver = wheel("driver", 0, kSpeed);
    driven = wheel("driven", 1, kSpeed * kR1 / kR2);
    graph.add<CoordinateDrive>("motor", {driver->angle()}, {.motion = ramp(0, kSpeed)});
    graph.add<CoordinateMotor>("brake", {driven->angle()},
                               {[brake](double, double, double speed) { return -brake(speed); }});
    const auto pulley = [&](const RevoluteJoint& pin, double radius) {
      return RopePulley{.marker = pin.markers()[0], .radius = radius, .friction = friction, .wheel = pin.angle()};
    };
    belt = reeve(graph, "belt", {},
                 {.pulleys = {pulley(*driver, kR1), pulley(*driven, kR2)},
                  .axial_stiffness = kEA,
                  .axial_damping = 1e3,
                  .mass_per_length = 0.1,
                  .pretension = kPretension,
                  .speed = kSpeed * kR1});
  }
};

/// In steady running the belt takes on each wheel's speed where it runs on: v₁/v₂ = (1 + T₁/EA)/(1 + T₂/EA).
TEST(BeltDrive, CreepsByTheDifferenceOfItsTensions) {
  const double torque = 10;
  BeltDrive drive(0.5, [=](double) { return torque; });
  const System system = assemble(drive.graph);
  State state = system.initial_state();
  const Method method = automatic(1e-10);
  Simulation simulation{system, *method};
  simulation.run(state, 2);
  // Span 0 runs from the driver to the driven wheel: slack.
  const double slack = read(system, state, tension(drive.belt, 0)), tight = read(system, state, tension(drive.belt, 1));
  EXPECT_NEAR(tight - slack, torque / kR2, 1e-4);
  EXPECT_NEAR(tight + slack, 2 * kPretension, 0.05);  // (T₁ - T₂)²/2EA
  const double w1 = read(system, state, coordinate_rate(drive.driver->angle(), "w1"));
  const double w2 = read(system, state, coordinate_rate(drive.driven->angle(), "w2"));
  const double creep = 1 - w2 * kR2 / (w1 * kR1);
  expect_below("creep", std::abs(creep / ((tight - slack) / (kEA + tight)) - 1), 1e-5);
}

/// Braked beyond the friction of its smaller wheel, the belt slips there with the ratio e^(μα).
TEST(BeltDrive, SlipsOnItsSmallerWheelAtTheCapstanRatio) {
  const double friction = 0.15;
  BeltDrive drive(friction, [](double speed) { return 4 * speed; });
  const System system = assemble(drive.graph);
  State state = system.initial_state();
  const Method method = automatic(1e-9);
  Simulation simulation{system, *method};
  simulation.run(state, 2);
  const double slack = read(system, state, tension(drive.belt, 0)), tight = read(system, state, tension(drive.belt, 1));
  const double ratio = std::exp(friction * drive.belt.wraps[0]);
  expect_below("ratio at slip", std::abs(tight / slack / ratio - 1), 1e-6);
  EXPECT_LT(read(system, state, coordinate_rate(drive.driven->angle(), "w2")), 0.9 * kSpeed * kR1 / kR2);
}

/// The whole scene as a simpler one: a body on a pin becomes one that turns.
TEST(BeltDrive, RunsInASimplifiedScene) {
  const auto speed_of = [](bool simplify) {
    BeltDrive drive(0.5, [](double speed) { return speed; });
    Simulation simulation{drive.graph, [] { return runge_kutta(1e-9); }, {.simplify = simplify}};
    State state = simulation.start();
    Recorder recorder{{coordinate_rate(drive.driven->angle(), "w2"), tension(drive.belt, 0), tension(drive.belt, 1)}};
    simulation.observe(recorder, every(0.1));
    simulation.run(state, 0.1);
    const Table& table = recorder.table();
    return Vector3(table.column("w2").back(), table.column("belt_tension_0").back(),
                   table.column("belt_tension_1").back());
  };
  EXPECT_LT((speed_of(true) - speed_of(false)).norm(), 1e-5);
}

TEST(BeltDrive, ATimingBeltKeepsTheRatioOfItsWheels) {
  BeltDrive drive(kNoSlip, [](double speed) { return 0.5 * speed; });
  const System system = assemble(drive.graph);
  State state = system.initial_state();
  const Method method = radau(1e-9);
  Simulation simulation{system, *method};
  simulation.run(state, 3);
  EXPECT_NEAR(read(system, state, coordinate_rate(drive.driven->angle(), "w2")), kSpeed * kR1 / kR2, 1e-7);
  const double slack = read(system, state, tension(drive.belt, 0)), tight = read(system, state, tension(drive.belt, 1));
  EXPECT_NEAR(tight - slack, 0.5 * 10 / kR2, 0.05);
}

}  // namespace
}  // namespace lithe::test::rope_friction_test
