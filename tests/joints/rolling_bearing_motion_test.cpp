#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/bearings/ball_bearing.h"
#include "joints/bearings/roller_bearing.h"
#include "joints/planar_joint.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/methods.h"

/// Rotors on rolling bearings: varying compliance, energy, natural frequencies.
namespace lithe::test::rolling_bearing_motion_test {
namespace {

/// A deep-groove ball bearing 6204.
const BallBearing::Parameters k6204{.balls = 8,
                                    .ball_diameter = 7.94e-3,
                                    .pitch_diameter = 33.5e-3,
                                    .inner_groove_radius = 0.515 * 7.94e-3,
                                    .outer_groove_radius = 0.525 * 7.94e-3,
                                    .clearance = 10e-6};
constexpr double kSpeed = 30, kLoad = 200;  // rad/s, N along -y

/// A rotor of 1 kg that moves in the plane, its bearing under a constant radial load.
struct Rotor {
  SystemGraph graph{{.gravity = {0, -kLoad, 0}}};
  RigidBody& shaft;
  BallBearing& bearing;
  System system;
  State state;

  Rotor(const BallBearing::Parameters& p, double polar)
      : shaft(graph.add<RigidBody>("shaft", {.mass = 1,
                                             .inertia = {polar, polar, polar},
                                             .position = position(p),
                                             .angular_velocity = {0, 0, kSpeed}})),
        bearing(graph.add<BallBearing>("bearing", {shaft.marker(), graph.ground().marker()}, p)),
        system([&] {
          graph.add<PlanarJoint>("plane", {graph.ground().marker(), shaft.marker()});
          return assemble(graph);
        }()),
        state(system.initial_state()) {}

  /// Where the load holds it as drawn.
  static Vector3 position(const BallBearing::Parameters& p) {
    SystemGraph alone;
    return alone.add<BallBearing>("alone", {alone.ground().marker(), alone.ground().marker()}, p)
        .deflection(-kLoad * Vector5::Unit(1))
        .head<3>();
  }
  Table run(Method method, std::vector<Sensor> sensors, double step, double end) {
    Recorder recorder{std::move(sensors)};
    Simulation simulation{system, *method};
    simulation.observe(recorder, every(step));
    simulation.run(state, end);
    return recorder.table();
  }
};

double amplitude(const std::vector<double>& t, const std::vector<double>& y, double from, double frequency) {
  std::complex<double> sum = 0;
  double mean = 0;
  int count = 0;
  for (std::size_t i = 0; i < t.size(); ++i)
    if (t[i] >= from) mean += y[i], ++count;
  mean /= count;
  for (std::size_t i = 0; i < t.size(); ++i)
    if (t[i] >= from) sum += (y[i] - mean) * std::polar(1.0, -2 * M_PI * frequency * t[i]);
  return 2 * std::abs(sum) / count;
}

/// Slow beside its natural frequency the shaft follows the static deflection under each place of the cage.
TEST(BallBearing, ShakesAtTheBallPassFrequencyOfTheOuterRing) {
  BallBearing::Parameters p = k6204;
  p.losses.damping_time = 5e-5;
  Rotor rotor(p, 1);
  const double pass = rotor.bearing.frequencies(kSpeed).outer_pass / (2 * M_PI);
  EXPECT_NEAR(pass, 8 * 0.5 * (1 - 7.94 / 33.5) * kSpeed / (2 * M_PI), 1e-9);
  const double periods = 10, settle = 0.1;
  const Table table = rotor.run(index3(1e-4), {ring_deflection(rotor.bearing, "d")}, 1e-4, settle + periods / pass);
  const auto t = table.column("t"), x = table.column("d_x"), y = table.column("d_y");
  const double at_pass = amplitude(t, x, settle, pass);
  EXPECT_GT(at_pass, 1e-7);
  for (double other : {0.5, 0.7, 1.3, 1.5}) EXPECT_LT(amplitude(t, x, settle, other * pass), 0.05 * at_pass) << other;

  double lowest = 0, highest = 0, worst = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (t[i] < settle) continue;
    const double cage = 0.5 * (1 - 7.94 / 33.5) * kSpeed * t[i];
    const Vector5 e = rotor.bearing.deflection(-kLoad * Vector5::Unit(1), cage);
    lowest = std::min(lowest, e[0]), highest = std::max(highest, e[0]);
    worst = std::max(worst, std::hypot(x[i] - e[0], y[i] - e[1]));
  }
  EXPECT_LT(worst, 0.05 * (highest - lowest));
}

/// What the passing balls take from the shaking they take from the turning: the moment about z is part of the
/// potential.
TEST(BallBearing, EnergyIsConservedWhileBallsPass) {
  BallBearing::Parameters p = k6204;
  p.clearance = 30e-6;
  Rotor rotor(p, 1e-6);  // so light that the turning notices
  const Table table =
      rotor.run(runge_kutta8(1e-11),
                {total_energy("E"), elastic_energy("V"),
                 coordinate_rate(angle_between(rotor.graph.ground().marker(), rotor.shaft.marker()), "w")},
                1e-3, 0.1);
  const auto E = table.column("E"), V = table.column("V"), w = table.column("w");
  const auto [low, high] = std::minmax_element(w.begin(), w.end());
  double drift = 0;
  for (double e : E) drift = std::max(drift, std::abs(e - E[0]));
  EXPECT_GT(*high - *low, 0.05);
  EXPECT_LT(drift, 1e-8 * V[0]);
}

/// A shaft of 10 kg on two angular-contact bearings against each other, 0.1 m apart along z.
struct Spindle {
  SystemGraph graph;
  RigidBody& shaft;
  const BallBearing *left, *right;
  System system;

  Spindle(double preload, const Vector3& gravity, double balls_at = 0)  // rad/s
      : graph{{.gravity = gravity}},
        shaft(graph.add<RigidBody>("shaft", {.mass = 10, .inertia = {0.1, 0.1, 0.1}})),
        left(add("left", -1, preload, balls_at)),
        right(add("right", 1, preload, balls_at)),
        system(assemble(graph)) {}

  const BallBearing* add(const char* name, double side, double preload, double balls_at) {
    BallBearing::Parameters p = k6204;
    p.clearance = 0, p.preload = preload, p.contact_angle = side * 0.26, p.speed = balls_at;
    const Vector3 place(0, 0, 0.05 * side);
    return &graph.add<BallBearing>(name, {shaft.marker(place), graph.ground().marker(place)}, p);
  }
};

/// Hz, of small oscillations along the axis.
double axial_frequency(Spindle& spindle, double about) {
  State state = spindle.system.initial_state();
  state.v[2] = 1e-4;
  Recorder recorder{{position(spindle.shaft.marker(), "p")}};
  const Method method = runge_kutta8(1e-11);
  Simulation simulation{spindle.system, *method};
  simulation.observe(recorder, every(0.01 / about));
  simulation.run(state, 10.3 / about);
  const auto t = recorder.table().column("t"), z = recorder.table().column("p_z");
  std::vector<double> crossings;
  for (std::size_t i = 1; i < t.size(); ++i)
    if (z[i - 1] < 0 && z[i] >= 0) crossings.push_back(t[i - 1] - z[i - 1] * (t[i] - t[i - 1]) / (z[i] - z[i - 1]));
  return static_cast<double>(crossings.size() - 1) / (crossings.back() - crossings.front());
}

/// √(2 K/m), of the motion and of the linearization alike.
TEST(BallBearing, PreloadRaisesTheNaturalFrequency) {
  double last = 0;
  for (double preload : {50.0, 200.0, 800.0}) {
    Spindle spindle(preload, Vector3::Zero());
    const double expected = std::sqrt(2 * spindle.left->stiffness(Vector5::Zero())(2, 2) / 10) / (2 * M_PI);
    EXPECT_NEAR(axial_frequency(spindle, expected), expected, 1e-3 * expected);
    double nearest = 1e9;
    for (const Mode& mode : linearize(spindle.system, spindle.system.initial_state(), {.step = 1e-6}).modes)
      nearest = std::min(nearest, std::abs(mode.frequency() - expected));
    EXPECT_LT(nearest, 1e-6 * expected);
    EXPECT_GT(expected, 1.2 * last);
    last = expected;
  }
}

/// The same with balls that their orbit throws outwards, which softens it.
TEST(BallBearing, BallsAtSpeedLowerTheNaturalFrequency) {
  Spindle rest(50, Vector3::Zero()), fast(50, Vector3::Zero(), 2000);
  const double K = fast.left->stiffness(Vector5::Zero())(2, 2), expected = std::sqrt(2 * K / 10) / (2 * M_PI);
  EXPECT_LT(K, 0.9 * rest.left->stiffness(Vector5::Zero())(2, 2));
  EXPECT_NEAR(axial_frequency(fast, expected), expected, 1e-3 * expected);
  double nearest = 1e9;
  for (const Mode& mode : linearize(fast.system, fast.system.initial_state(), {.step = 1e-7}).modes)
    nearest = std::min(nearest, std::abs(mode.frequency() - expected));
  EXPECT_LT(nearest, 1e-5 * expected);
}

/// Across the axis, with balls at speed, about rest without load and under one that some balls do not carry: small
/// oscillations have the frequency of the linearization there.
TEST(BallBearing, RingsAtSpeedAsItIsLinearizedAboutItsRest) {
  for (const double gravity : {0.0, 20.0, 60.0}) {
    Spindle spindle(50, {0, -gravity, 0}, 2000);
    const State drawn = spindle.system.initial_state();
    const State rest = find_equilibrium(spindle.system, drawn).state;
    State state = rest;
    state.v[1] = 1e-6;
    Recorder recorder{{position(spindle.shaft.marker(), "p")}};
    const Method method = runge_kutta8(1e-13);
    Simulation simulation{spindle.system, *method};
    simulation.observe(recorder, every(2e-5));
    simulation.run(state, 0.02);
    const auto t = recorder.table().column("t"), y = recorder.table().column("p_y");
    std::vector<double> crossings;
    for (std::size_t i = 1; i < t.size(); ++i) {
      const double a = y[i - 1] - rest.q[1], b = y[i] - rest.q[1];
      if (a < 0 && b >= 0) crossings.push_back(t[i - 1] - a * (t[i] - t[i - 1]) / (b - a));
    }
    ASSERT_GT(crossings.size(), 3u);
    const double found = static_cast<double>(crossings.size() - 1) / (crossings.back() - crossings.front());
    double nearest = 1e9;
    for (const Mode& mode : linearize(spindle.system, rest, {.step = 1e-7}).modes)
      nearest = std::min(nearest, std::abs(mode.frequency() - found));
    expect_below("at " + std::to_string(gravity) + " m/s²", nearest / found, 1e-6);
  }
}

TEST(BallBearing, StandsInEquilibriumUnderItsWeight) {
  Spindle spindle(100, {0, -9.81, 0});
  const Equilibrium found = find_equilibrium(spindle.system, spindle.system.initial_state());
  EXPECT_LT(found.out_of_balance, 1e-6);
  Snapshot now{spindle.system, found.state};
  for (const BallBearing* bearing : {spindle.left, spindle.right}) {
    const Sensor ring = ring_deflection(*bearing);
    std::array<double, 5> e;
    ring.evaluate(now, e);
    EXPECT_LT(e[1], -1e-7);
    EXPECT_NEAR(bearing->load(Eigen::Map<const Vector5>(e.data()))[1], -0.5 * 98.1, 1e-5);
  }
}

/// Balls push each other with thousands of newtons, and nothing else acts: what is left of that by round-off is no lack
/// of balance, though the scene has no other force that it could be compared with.
TEST(BallBearing, PreloadedPairStandsInEquilibriumWithoutALoad) {
  for (const double preload : {50.0, 100.0, 400.0, 800.0})
    for (const double balls_at : {0.0, 2000.0}) {
      SCOPED_TRACE(std::to_string(preload) + " N, " + std::to_string(balls_at) + " rad/s");
      Spindle spindle(preload, Vector3::Zero(), balls_at);
      const State drawn = spindle.system.initial_state();
      State start = drawn;
      for (const double aside : {0.0, 1e-7}) {
        start.q[1] = drawn.q[1] + aside, start.q[2] = drawn.q[2] - 0.5 * aside;
        const Equilibrium found = find_equilibrium(spindle.system, start);
        expect_below("aside of the middle, m", (found.state.q - drawn.q).head<3>().norm(), 1e-13);
        expect_below("out of balance, N", found.out_of_balance, 1e-9);
      }
    }
}

/// One bearing without clearance: its rows are without load, its balls are not.
TEST(BallBearing, JammedAloneStandsInEquilibriumInItsMiddle) {
  BallBearing::Parameters p = k6204;
  p.clearance = -20e-6;
  SystemGraph graph({.gravity = Vector3::Zero()});
  auto& shaft = graph.add<RigidBody>("shaft", {.mass = 1, .inertia = {1e-3, 1e-3, 1e-3}});
  graph.add<PlanarJoint>("plane", {graph.ground().marker(), shaft.marker()});
  graph.add<BallBearing>("bearing", {shaft.marker(), graph.ground().marker()}, p);
  const System system = assemble(graph);
  for (const double aside : {0.0, 1e-7}) {
    State start = system.initial_state();
    start.q[0] = aside, start.q[1] = -0.3 * aside;
    const Equilibrium found = find_equilibrium(system, start);
    expect_below("aside of the middle, m", found.state.q.head<3>().norm(), 1e-13);
    expect_below("out of balance, N", found.out_of_balance, 1e-9);
  }
}

/// From the middle of its clearance, without stiffness there, to the static deflection: in time by any method, and at
/// once.
TEST(BallBearing, FallsThroughItsClearanceAndComesToRest) {
  BallBearing::Parameters p = k6204;
  p.clearance = 40e-6, p.losses.damping_time = 1e-4;
  const auto draw = [&](SystemGraph& graph) {
    auto& shaft = graph.add<RigidBody>("shaft", {});
    graph.add<PlanarJoint>("plane", {graph.ground().marker(), shaft.marker()});
    return &graph.add<BallBearing>("bearing", {shaft.marker(), graph.ground().marker()}, p);
  };
  for (auto& [name, method] : every_method(1e-4, 1e-8)) {
    SCOPED_TRACE(name);
    SystemGraph graph{{.gravity = {0, -kLoad, 0}}};
    const BallBearing* bearing = draw(graph);
    const System system = assemble(graph);
    State state = system.initial_state();
    Simulation{system, *method}.run(state, 0.05);
    const double expected = bearing->deflection(-kLoad * Vector5::Unit(1))[1];
    EXPECT_NEAR(state.q[1], expected, 1e-8);
    EXPECT_NEAR(find_equilibrium(system, system.initial_state()).state.q[1], expected, 1e-9);
  }
}

/// Turning between ground and a shaft without load friction brakes it by M_0: 0.1 f_0 d_m³ · 160 while ν n < 2000.
TEST(BallBearing, PalmgrenFrictionBrakesTheShaft) {
  BallBearing::Parameters p = k6204;
  p.clearance = 0, p.contact_angle = 0.26, p.losses = {.speed_factor = 2, .viscosity = 2e-6, .creep_speed = 1e-3};
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  auto& shaft =
      graph.add<RigidBody>("shaft", {.mass = 1, .inertia = {1e-3, 1e-3, 1e-3}, .angular_velocity = {0, 0, 50}});
  auto& bearing = graph.add<BallBearing>("bearing", {shaft.marker(), graph.ground().marker()}, p);
  const System system = assemble(graph);
  State state = system.initial_state();
  Snapshot now{system, state};
  const double moment = 0.1 * 2 * std::pow(33.5e-3, 3) * 160;
  EXPECT_NEAR(power(bearing).value(now), -50 * moment, 1e-12);
  const Method method = automatic(1e-9);
  Simulation{system, *method}.run(state, 0.5);
  EXPECT_NEAR(state.v[5], 50 - moment / 1e-3 * 0.5, 1e-6);
}

/// A roller bearing between two spinning bodies: nothing is lost in all, and sensors read what the law says.
TEST(RollerBearing, SensorsReadElementLoads) {
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  auto& shaft = graph.add<RigidBody>("shaft", {.position = {4e-5, 0, 0}});
  auto& bearing = graph.add<RollerBearing>(
      "bearing", {shaft.marker(), graph.ground().marker()},
      {.rollers = 14, .roller_diameter = 10e-3, .roller_length = 9.6e-3, .pitch_diameter = 65e-3, .clearance = 4e-5});
  const System system = assemble(graph);
  Snapshot now{system, system.initial_state()};
  const Vector5 e = 4e-5 * Vector5::Unit(0);
  double sum = 0;
  for (int j = 0; j < 14; ++j) {
    const double Q = rolling_element_loads(bearing).value(now, j);
    EXPECT_NEAR(Q, bearing.element_loads(e)[static_cast<std::size_t>(j)].force, 1e-9);
    EXPECT_EQ(contact_angles(bearing).value(now, j), 0);
    sum += Q * std::cos(2 * M_PI * j / 14);
  }
  EXPECT_GT(sum, 1000);
  EXPECT_NEAR(applied_force(bearing, 0).value(now), -sum, 1e-9 * sum);
  EXPECT_NEAR(ring_deflection(bearing).value(now, 0), 4e-5, 1e-18);
}

}  // namespace
}  // namespace lithe::test::rolling_bearing_motion_test
