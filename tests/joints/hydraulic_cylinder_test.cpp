// A hydraulic cylinder: oil against its own volume curve, oil columns, steady speeds, balances of energy.
#include "joints/hydraulics/hydraulic_cylinder.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/analysis/linearization.h"
#include "engine/archive/archive.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/control/control_force.h"
#include "joints/forces/first_order_states.h"
#include "joints/forces/point_force.h"
#include "joints/prismatic_joint.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/joint_checks.h"
#include "tests/support/message_of.h"
#include "tests/support/pairs.h"

namespace lithe::test::hydraulic_cylinder_test {
namespace {

constexpr double kMass = 800, kLength = 0.7, kStroke = 0.5, kClosed = 0.6;
const double kCap = kPi / 4 * 0.08 * 0.08, kRod = kPi / 4 * (0.08 * 0.08 - 0.05 * 0.05);

HydraulicCylinder::Parameters parameters() {
  return {.bore = 0.08,
          .rod = 0.05,
          .stroke = kStroke,
          .closed_length = kClosed,
          .cap_dead_volume = 2e-4,
          .rod_dead_volume = 1.5e-4};
}

/// A mass that a cylinder pushes along z from the ground; the state starts with these pressures.
struct Lift {
  Lift(const HydraulicCylinder::Parameters& p, double cap, double rod, double load = 0, double length = kLength)
      : scene({0, 0, 0}, [&](SystemGraph& graph) {
          auto& block = graph.add<RigidBody>("block", {.mass = kMass, .position = {0, 0, length}});
          slide = &graph.add<PrismaticJoint>("slide", {graph.ground().marker(), block.marker()});
          oil = &graph.add<FirstOrderStates>("oil", {.start = HydraulicCylinder::start(cap, rod)});
          cylinder = &graph.add<HydraulicCylinder>("lift", {graph.ground().marker(), block.marker(), oil->point(0)}, p);
          graph.add<PointForce>("load", {block.marker()}, {.force = {0, 0, -load}});
        }) {}
  double place() { return scene.state.q[2]; }
  double speed() { return scene.state.v[2]; }
  double pressure(int chamber) { return read(scene, cylinder->pressures(), chamber); }

  PrismaticJoint* slide = nullptr;
  FirstOrderStates* oil = nullptr;
  HydraulicCylinder* cylinder = nullptr;
  Scene scene;
};

TEST(HydraulicOil, IsSqueezedAsItsVolumeSaysAndHoldsThatWork) {
  for (const double air : {0.0, 0.01}) {
    const HydraulicOil oil{.air = air};
    const auto volume = [&](double p) {
      return std::exp(-p / oil.bulk_modulus) +
             air * std::pow(oil.atmosphere / (p + oil.atmosphere), 1 / oil.polytropic);
    };
    double work = 0;
    const double top = 5e6;
    constexpr int kParts = 200000;
    for (int i = 0; i < kParts; ++i) {
      const double a = top * i / kParts, b = top * (i + 1) / kParts;
      work += 0.5 * (a + b) * (volume(a) - volume(b));
    }
    EXPECT_NEAR(oil.at(top).stored, work / volume(top), 1e-6 * work);
    for (const double p : {0.0, 2e5, 5e6, 2e7}) {
      const double h = 100;
      EXPECT_NEAR(oil.at(p).modulus, -volume(p) * 2 * h / (volume(p + h) - volume(p - h)), 1e-5 * oil.at(p).modulus);
    }
    if (air > 0)
      EXPECT_LT(oil.at(0).modulus, 0.02 * oil.bulk_modulus);
    else
      EXPECT_NEAR(oil.at(0).stored, 0, 1e-6);
  }
}

TEST(HydraulicCylinder, IsExactInNewtonsMatrixBetweenAllBodies) {
  for (const Pair& pair : pairs())
    for (const double opening : {0.0, 0.6, -0.4}) {
      SCOPED_TRACE(pair.name + ", opening " + std::to_string(opening));
      SystemGraph graph{{.gravity = Vector3::Zero()}};
      std::vector<Marker> markers = pair.draw(graph, {0.3, 0.5, -0.4});
      auto& oil = graph.add<FirstOrderStates>("oil", {.start = HydraulicCylinder::start(5e6, 3e6)});
      markers.push_back(oil.point(0));
      HydraulicCylinder::Parameters p = parameters();
      p.closed_length = 0.05, p.stroke = 3;  // random states stay within
      p.leakage = 1e-12, p.friction = 50, p.oil.air = 0.01;
      p.valve = {.area = 3e-6,
                 .command = constant(opening),
                 .time_constant = opening > 0 ? 0.02 : 0,
                 .supply = constant(1e7),
                 .relief = 4.9e6,
                 .relief_flow = 1e-10};
      auto& cylinder = graph.add<HydraulicCylinder>("lift", markers, p);
      check_force(graph, cylinder, {.conservative = false, .tolerance = 1e-7});
    }
}

/// ω² = E (A_c²/V_c + A_r²/V_r) / m
TEST(HydraulicCylinder, HoldsAMassBetweenTwoColumnsOfOil) {
  Lift lift(parameters(), 4e6, 4e6 * kCap / kRod);
  const double E = HydraulicOil{}.bulk_modulus, s = kLength - kClosed;
  const double stiffness = E * (kCap * kCap / (2e-4 + kCap * s) + kRod * kRod / (1.5e-4 + kRod * (kStroke - s)));
  const Linearization linear = linearize(lift.scene.system, lift.scene.state);
  double frequency = 0;
  for (const Mode& mode : linear.modes) frequency = std::max(frequency, mode.eigenvalue.imag());
  EXPECT_NEAR(frequency, std::sqrt(stiffness / kMass), 1e-6 * frequency);
  // It sinks under a load by what that stiffness says, and swings about there: twice as far.
  const double load = 500, sinks = load / stiffness;
  for (auto* make : {+[] { return automatic(1e-8); }, +[] { return radau(1e-8); }, +[] { return bdf(1e-8); },
                     +[] { return ida(1e-9); }, +[] { return index2(1e-4); }, +[] { return runge_kutta(1e-9); }}) {
    Lift loaded(parameters(), 4e6, 4e6 * kCap / kRod, load);
    const Method method = make();
    loaded.scene.run(*method, kPi / frequency);
    EXPECT_NEAR(loaded.place(), kLength - 2 * sinks, 0.01 * sinks) << method->name();
    loaded.scene.run(*method, 2 * kPi / frequency);
    EXPECT_NEAR(loaded.place(), kLength, 0.01 * sinks) << method->name();
  }
}

TEST(HydraulicCylinder, HoldsItsLoadAndSinksByItsLeak) {
  const double load = 2e4, leak = 2e-11;
  HydraulicCylinder::Parameters p = parameters();
  Lift tight(p, load / kCap, 0, load);
  const Method method = radau(1e-8);
  tight.scene.run(*method, 5);
  EXPECT_NEAR(tight.place(), kLength, 1e-9);
  // Equal areas: the leak alone lets it sink, at v = q / A with q = k_l F / A.
  p.rod = 0, p.leakage = leak;
  Lift leaking(p, load / kCap / 2, -load / kCap / 2, load);
  const Method other = radau(1e-8);
  leaking.scene.run(*other, 1);
  const double from = leaking.place();
  leaking.scene.run(*other, 3);
  EXPECT_NEAR((from - leaking.place()) / 2, leak * load / (kCap * kCap), 1e-6 * leak * load / (kCap * kCap));
}

/// Q_c = A_c v, Q_r = A_r v through orifices, A_c p_c = A_r p_r + F: for both directions.
TEST(HydraulicCylinder, MovesAtTheSpeedThatItsValveLetsThrough) {
  const double supply = 2e7, tank = 3e5, load = 1.5e4, friction = 2000, area = 4e-6;
  for (const double opening : {0.7, -0.5}) {
    HydraulicCylinder::Parameters p = parameters();
    p.friction = friction;
    p.valve = {.area = area, .laminar = 100, .command = constant(opening), .supply = constant(supply), .tank = tank};
    Lift lift(p, 5e6, 2e6, load, opening > 0 ? 0.65 : 1.0);
    const Method method = radau(1e-7);
    lift.scene.run(*method, 1);
    const double v = lift.speed(), c = 0.6 * std::abs(opening) * area * std::sqrt(2 / 860.0);
    const double drop_cap = std::pow(kCap * v / c, 2), drop_rod = std::pow(kRod * v / c, 2);
    const double p_cap = opening > 0 ? supply - drop_cap : tank + drop_cap;
    const double p_rod = opening > 0 ? tank + drop_rod : supply - drop_rod;
    EXPECT_GT(v * opening, 0);
    EXPECT_NEAR(kCap * p_cap - kRod * p_rod, load + friction * v, 1e-4 * load) << opening;
    EXPECT_NEAR(lift.pressure(0), p_cap, 1e-4 * p_cap);
    EXPECT_NEAR(lift.pressure(1), p_rod, 1e-4 * p_rod);
    EXPECT_NEAR(read(lift.scene, lift.cylinder->flows(), 0), kCap * v, 1e-6 * std::abs(kCap * v));
    EXPECT_NEAR(read(lift.scene, lift.cylinder->force()), load, 1e-4 * load);
    EXPECT_NEAR(read(lift.scene, power(*lift.cylinder)), load * v, 1e-4 * load * std::abs(v));  // of its states: none
  }
}

/// What supply and tank bring goes into motion, work, heat and the squeezed oil; from stop to stop.
TEST(HydraulicCylinder, BalancesItsEnergy) {
  HydraulicCylinder::Parameters p = parameters();
  p.friction = 3000, p.leakage = 1e-12, p.oil.air = 0.005, p.stop_dissipation = 2, p.stop_stiffness = 1e7;
  p.valve = {.area = 8e-6,
             .command = harmonic(-1, 4),
             .time_constant = 0.03,
             .supply = constant(1.6e7),
             .relief = 1.2e7,
             .relief_flow = 1e-10,
             .makeup_flow = 1e-9};
  Lift lift(p, 3e6, 3e6 * kCap / kRod, 0, 0.65);
  const Method method = radau(1e-9);
  Recorder record{{lift.cylinder->powers("p"), total_energy("energy"), coordinate(lift.slide->displacement(), "z")}};
  Simulation simulation{lift.scene.system, *method};
  simulation.observe(record, every(2e-4));
  simulation.run(lift.scene.state, 2);
  const Table& table = record.table();
  const auto energy = table.column("energy"), z = table.column("z");
  const auto work = [&](const char* name) {  // Simpson
    const auto y = table.column(name);
    double sum = 0;
    for (std::size_t i = 0; i + 2 < y.size(); i += 2) sum += 2e-4 / 3 * (y[i] + 4 * y[i + 1] + y[i + 2]);
    return sum;
  };
  const double supplied = work("p_supply"), lost = work("p_throttled") + work("p_friction");
  EXPECT_LT(*std::min_element(z.begin(), z.end()), kClosed);  // it has met a stop
  EXPECT_GT(supplied, 1000);
  EXPECT_NEAR(energy.back() - energy.front(), supplied - lost, 2e-5 * supplied);
  for (const double heat : table.column("p_throttled")) EXPECT_GE(heat, -1e-6);
}

TEST(HydraulicCylinder, EndsAtItsStopsAndOpensItsRelief) {
  HydraulicCylinder::Parameters p = parameters();
  p.valve = {.area = 2e-5, .command = constant(1), .supply = constant(2e7), .relief = 1.5e7, .relief_flow = 1e-9};
  p.friction = 5000;
  Lift lift(p, 1e6, 1e6);
  const Method method = radau(1e-6);
  lift.scene.run(*method, 3);
  // The cap is held by supply and relief: c √(p_S - p) = k (p - p_r); the rod's chamber has drained to the tank.
  const double c = 0.6 * 2e-5 * std::sqrt(2 / 860.0), cap = lift.pressure(0);
  EXPECT_NEAR(c * std::sqrt(2e7 - cap), 1e-9 * (cap - 1.5e7), 1e-3 * c * std::sqrt(2e7 - cap));
  EXPECT_NEAR(lift.pressure(1), 0, 1e3);
  EXPECT_NEAR(lift.place() - kClosed - kStroke, kCap * cap / 1e8, 1e-6);
  EXPECT_NEAR(lift.speed(), 0, 1e-6);
}

/// The spool as a state of the cylinder: by its own lag, and driven by a control diagram that closes a loop of place.
TEST(HydraulicCylinder, IsMovedByAControlDiagram) {
  const double goal = 0.85, tau = 0.02, gain = 6;
  HydraulicCylinder::Parameters p = parameters();
  p.friction = 3e4;
  p.valve = {.area = 5e-6, .supply = constant(1.5e7)};
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  auto& block = graph.add<RigidBody>("block", {.mass = kMass, .position = {0, 0, kLength}});
  auto& slide = graph.add<PrismaticJoint>("slide", {graph.ground().marker(), block.marker()});
  auto& oil = graph.add<FirstOrderStates>("oil", {.start = HydraulicCylinder::start(3e6, 3e6 * kCap / kRod)});
  auto& cylinder = graph.add<HydraulicCylinder>("lift", {graph.ground().marker(), block.marker(), oil.point(0)}, p);
  const JointCoordinate spool = displacement_between(graph.ground().marker(), oil.point(0), 2);
  ControlDiagram servo;
  const ControlSignal wanted = servo.saturated(gain * (goal - servo.value(slide.displacement())), -1, 1);
  const ControlSignal opening = servo.rate(spool);
  servo.push(spool, (1 / tau) * (wanted - opening));
  auto& states = graph.add<FirstOrderStates>("servo states", {.start = servo.start()});
  auto& control = graph.add<ControlForce>("servo", servo.markers(states), {servo});
  const System system = assemble(graph);
  const Method method = automatic(1e-6);
  Simulation simulation{system, *method};
  State state = system.initial_state();
  simulation.run(state, 0.1);  // the command is full so far, and the spool's lag known
  Snapshot now(system, state);
  EXPECT_NEAR(control.sensor(opening, "x").value(now), 0.9 * (1 - std::exp(-0.1 / tau)), 0.05);
  simulation.run(state, 30);
  Snapshot end(system, state);
  EXPECT_NEAR(state.q[2], goal, 1e-4);
  EXPECT_NEAR(cylinder.flows().value(end), 0, 1e-7);
  // The command without a diagram: the same lag.
  p.valve.command = constant(0.8), p.valve.time_constant = tau;
  Lift lagged(p, 3e6, 3e6 * kCap / kRod);
  const Method other = radau(1e-8);
  lagged.scene.run(*other, 0.03);
  EXPECT_NEAR(read(lagged.scene, generalized_velocities(*lagged.oil), 2), 0.8 * (1 - std::exp(-1.5)), 1e-6);
}

/// Through an open valve the oil is stiff and damped: implicit methods take steps of the motion.
TEST(HydraulicCylinder, CostsImplicitMethodsFewSteps) {
  HydraulicCylinder::Parameters p = parameters();
  p.valve = {.area = 1e-6, .command = smooth_step(0, 1, 0, 0.5), .supply = constant(1e7)};
  p.friction = 2e4;
  const auto steps = [&](const Method& method) {
    Lift lift(p, 3e6, 3e6 * kCap / kRod, 0, 0.65);
    Simulation simulation{lift.scene.system, *method};
    simulation.run(lift.scene.state, 20);
    return static_cast<double>(simulation.statistics().steps);
  };
  const double by_explicit = steps(runge_kutta(1e-5));
  for (auto* make : {+[] { return automatic(1e-5); }, +[] { return radau(1e-5); }, +[] { return bdf(1e-5); }}) {
    const Method method = make();
    expect_below("steps of " + method->name() + ", of those of Runge-Kutta", steps(method) / by_explicit, 0.1);
  }
}

TEST(HydraulicCylinder, ResumesWithTheSameBits) {
  HydraulicCylinder::Parameters p = parameters();
  p.friction = 3000;
  p.valve = {.area = 8e-6, .command = harmonic(1, 4), .time_constant = 0.03, .supply = constant(1.6e7)};
  const auto lift = [&] { return std::make_unique<Lift>(p, 3e6, 3e6 * kCap / kRod); };
  for (auto* make : {+[] { return automatic(1e-6); }, +[] { return bdf(1e-6); }}) {
    const auto whole = lift(), first = lift(), second = lift();
    const Method a = make(), b = make(), c = make();
    Simulation all{whole->scene.system, *a}, begins{first->scene.system, *b}, goes_on{second->scene.system, *c};
    all.run(whole->scene.state, 0.21), all.run(whole->scene.state, 0.5);
    begins.run(first->scene.state, 0.21);
    Archive archive;
    begins.save(first->scene.state, archive);
    archive.rewind();
    State state = goes_on.resume(archive);
    goes_on.run(state, 0.5);
    EXPECT_EQ(state.q, whole->scene.state.q);
    EXPECT_EQ(state.v, whole->scene.state.v);
  }
}

TEST(HydraulicCylinder, SaysWhatIsWrongAndHowToFixIt) {
  const auto refused = [](auto change) {
    return message_of<SceneError>([&] {
      HydraulicCylinder::Parameters p = parameters();
      change(p);
      Lift(p, 0, 0);
    });
  };
  expect_says(refused([](auto& p) { p.bore = 0; }), {"'lift'", "bore"});
  expect_says(refused([](auto& p) { p.rod = 0.09; }), {"rod is not thinner than the bore"});
  expect_says(refused([](auto& p) { p.rod_dead_volume = 0; }), {"rod_dead_volume"});
  expect_says(refused([](auto& p) { p.oil.air = 1; }), {"oil.air"});
  expect_says(refused([](auto& p) { p.valve.relief = -1; }), {"valve.relief is not above valve.tank"});
  expect_says(refused([](auto& p) { p.valve.supply = nullptr; }), {"valve.supply is empty"});
}

}  // namespace
}  // namespace lithe::test::hydraulic_cylinder_test
