#include "joints/sliding/sliding_joint.h"

#include <gtest/gtest.h>

#include "bodies/beam/beam.h"
#include "bodies/cable/cable.h"
#include "bodies/point_mass.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/motion/projection.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"

/// A point on a curve through markers: on the ground, on bodies that move, on beams and cables that bend.
namespace lithe::test::sliding_joint_test {
namespace {

constexpr double kGravity = 9.81;

double read(const System& system, const State& state, const Sensor& sensor) {
  Snapshot now{system, state};
  return sensor.value(now);
}

State run(const System& system, State state, Method method, double end) {
  Simulation simulation{system, *method};
  simulation.run(state, end);
  return state;
}

/// Ground markers on a circle of radius 1 about the origin, in the plane xz, from one angle to another; zero is down.
std::vector<Marker> circle(SystemGraph& graph, double from, double to, int count) {
  std::vector<Marker> rail;
  for (int i = 0; i < count; ++i) {
    const double phi = from + (to - from) * i / (count - 1);
    rail.push_back(graph.ground().marker({std::sin(phi), 0, -std::cos(phi)}));
  }
  return rail;
}

// ---- rows ----

/// Three bodies and a slider, bent and moving: g_dot and g_dotdot by differences along the motion that they make.
TEST(SlidingJoint, ItsRowsAreDerivativesOfEachOther) {
  SystemGraph graph;
  std::vector<Marker> rail;
  const Vector3 places[] = {{0, 0, 0}, {0.5, 0.1, 0.2}, {1.1, -0.1, 0.1}, {1.6, 0.2, -0.2}, {2.0, 0, 0.1}};
  for (int i = 0; i < 5; ++i)
    rail.push_back(graph
                       .add<RigidBody>("b" + std::to_string(i), {.mass = 1.0 + i,
                                                                 .inertia = {0.1, 0.2, 0.15},
                                                                 .position = places[i],
                                                                 .velocity = {0.3 * i, 0.2 - 0.1 * i, 0.4},
                                                                 .angular_velocity = {0.5, -0.3 * i, 0.2}})
                       .marker({0.02, 0.01, -0.03}));
  auto& bead = graph.add<RigidBody>("bead", {.mass = 0.5,
                                             .inertia = {0.01, 0.02, 0.03},
                                             .position = {0.8, 0, 0.15},
                                             .velocity = {2, 0.3, -0.4},
                                             .angular_velocity = {1, 2, 3}});
  auto& joint = add_sliding_joint(graph, "slide", bead.marker({0, 0.01, 0.02}), rail);
  const System system = assemble(graph);
  const State start = system.initial_state();  // on the rail, with velocities along it
  EXPECT_LT(read(system, start, place_on_rail(joint)), joint.length());
  const auto rows = [&](const State& state, Level level) {
    Snapshot now(system, state);
    VectorX out(2);
    now.evaluator().evaluate(state.time, state.q, state.v, Level::acceleration);
    now.evaluator().constraint(level, out);
    return out;
  };
  expect_below("g", rows(start, Level::position).norm(), 1e-12);
  expect_below("g_dot", rows(start, Level::velocity).norm(), 1e-12);
  // Any motion: G by differences of g.
  RandomNumbers random(5);
  for (int k = 0; k < 5; ++k) {
    State moving = start;
    moving.v = random.vector(moving.v.size(), 1);
    const double h = 1e-6;
    State ahead = moving, behind = moving;
    system.layout().retract(start.q, h * moving.v, ahead.q);
    system.layout().retract(start.q, -h * moving.v, behind.q);
    const VectorX difference = (rows(ahead, Level::position) - rows(behind, Level::position)) / (2 * h);
    expect_below("G", (difference - rows(moving, Level::velocity)).norm(), 1e-8);
  }
  // The free motion under gravity keeps the rail: g stays zero to fourth order of a step.
  Method exact = runge_kutta8_fixed(1e-3);
  const State later = run(system, start, std::move(exact), 0.05);
  expect_below("g after a while", rows(later, Level::position).norm(), 1e-11);
}

// ---- rails on the ground ----

TEST(SlidingJoint, ABeadOnACircleIsAPendulum) {
  // From rest at 1 rad: a quarter period is K(sin² 0.5) / sqrt(g).
  const double quarter = std::comp_ellint_1(std::sin(0.5)) / std::sqrt(kGravity);
  double error[2];
  for (int k : {0, 1}) {
    SystemGraph graph;
    auto& bead = graph.add<PointMass>("bead", {.mass = 2, .position = {std::sin(1), 0, -std::cos(1)}});
    add_sliding_joint(graph, "slide", bead.marker(), circle(graph, -2, 2, 21 << k));
    const System system = assemble(graph);
    const State state = run(system, system.initial_state(), radau(1e-10), quarter);
    error[k] = std::abs(state.q[0]);
    expect_below("height", std::abs(state.q[2] + 1), 1e-3);
    expect_below("speed", std::abs(state.v.norm() / std::sqrt(2 * kGravity * (1 - std::cos(1))) - 1), 1e-4);
  }
  expect_below("place after a quarter period, 21 markers", error[0], 1e-3);
  expect_below("42 markers", error[1], error[0] / 6);  // third order or better
}

/// Through the hill and the dip of a rail: the energy of a bead, and the force that keeps it there.
TEST(SlidingJoint, EveryMethodKeepsTheEnergyOfABead) {
  for (auto& [name, method] : every_method(1e-3, 1e-8)) {
    SystemGraph graph;
    std::vector<Marker> rail;
    for (int i = 0; i <= 20; ++i)
      rail.push_back(graph.ground().marker({0.2 * i, 0.1 * std::sin(0.5 * i), 0.3 * std::cos(0.6 * i)}));
    auto& bead = graph.add<RigidBody>("bead", {.mass = 2,
                                               .inertia = {0.1, 0.1, 0.1},
                                               .position = {0.2, 0.1 * std::sin(0.5), 0.3 * std::cos(0.6)},
                                               .velocity = {2.5, 0, 0}});
    auto& joint = add_sliding_joint(graph, "slide", bead.marker(), rail);
    const System system = assemble(graph);
    const State start = system.initial_state();
    const Sensor energy = total_energy();
    const double before = read(system, start, energy);
    const State end = run(system, start, std::move(method), 1);
    expect_below(name + ": energy", std::abs(read(system, end, energy) - before), 5e-3);
    EXPECT_GT(read(system, end, place_on_rail(joint)), 1.5) << name;
    Snapshot now(system, end);
    VectorX g(2);
    now.evaluator().constraint(Level::position, g);
    expect_below(name + ": g", g.norm(), 1e-6);
  }
}

TEST(SlidingJoint, BeyondItsEndTheRailGoesOnStraight) {
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  std::vector<Marker> rail;
  for (double x : {0.0, 0.4, 1.0}) rail.push_back(graph.ground().marker({x, 0.5 * x, 0}));
  auto& bead = graph.add<PointMass>("bead", {.mass = 1, .position = {0.8, 0.4, 0}, .velocity = {1, 0.5, 0}});
  auto& joint = add_sliding_joint(graph, "slide", bead.marker(), rail);
  const System system = assemble(graph);
  const State end = run(system, system.initial_state(), radau(1e-8), 2);
  expect_below("place", (end.q.head<3>() - Vector3(2.8, 1.4, 0)).norm(), 1e-9);
  expect_below("distance along it", std::abs(read(system, end, place_on_rail(joint)) - 2.8 * std::sqrt(1.25)), 1e-9);
  expect_below("speed", std::abs(read(system, end, speed_on_rail(joint)) - std::sqrt(1.25)), 1e-9);
}

// ---- friction ----

TEST(SlidingJoint, FrictionOnAnInclineHoldsOrBrakes) {
  const double slope = 0.3;  // rad
  for (const double mu : {0.2, 0.5}) {
    SystemGraph graph;
    std::vector<Marker> rail;
    for (int i = 0; i <= 10; ++i) rail.push_back(graph.ground().marker({i * std::cos(slope), 0, -i * std::sin(slope)}));
    auto& bead = graph.add<PointMass>("bead", {.mass = 3, .position = {std::cos(slope), 0, -std::sin(slope)}});
    auto& joint = add_sliding_joint(graph, "slide", bead.marker(), rail);
    add_sliding_friction(graph, "rub", joint, {.coefficient = mu, .creep_speed = 3e-4});
    const System system = assemble(graph);
    const State end = run(system, system.initial_state(), radau(1e-8), 1);
    const double way = read(system, end, place_on_rail(joint)) - 1;
    const double pull = std::sin(slope) - mu * std::cos(slope);
    if (pull > 0)
      expect_below("way", std::abs(way / (0.5 * kGravity * pull) - 1), 1e-3);
    else
      // Below the creep speed: tanh(3 s / v_c) = tan(slope) / μ.
      expect_below("creep", std::abs(way / (1e-4 * std::atanh(std::tan(slope) / mu)) - 1), 1e-2);
  }
}

// ---- beams and cables ----

/// A force that moves along a simply supported beam with constant speed (Frýba, Vibration of Solids and Structures
/// under Moving Loads, 1999, 1.3): w = Σ 2P/μL sin(nπx/L) (sin Ω_n t - Ω_n/ω_n sin ω_n t) / (ω_n² - Ω_n²), Ω_n = nπc/L.
TEST(SlidingJoint, AMovingLoadBendsABeamAsFrybaSays) {
  const double L = 2, EI = 40, mu = 1.5, P = 4, speed = 3;
  const BeamSection section = BeamSection::diagonal({4e6, 4e6, 4e6, EI, EI, EI}, mu, {2e-6, 1e-6, 1e-6});
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  auto& beam = graph.add<Beam>(
      "beam",
      {.axis = BeamAxis::straight({0, 0, 0}, {L, 0, 0}, {0, 1, 0}), .sections = {{0, section}}, .elements = 24});
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  graph.add<RevoluteJoint>("left",
                           {graph.ground().marker({0, 0, 0}, along_y), beam.marker_at_world({0, 0, 0}, along_y)});
  // The right end is free along the beam: a slider on a short straight rail of the ground.
  add_sliding_joint(
      graph, "right", beam.marker(L),
      {graph.ground().marker({L - 1, 0, 0}), graph.ground().marker({L, 0, 0}), graph.ground().marker({L + 1, 0, 0})});
  auto& load = graph.add<PointMass>("load", {.mass = 1e-3, .position = {0.01, 0, 0}, .velocity = {speed, 0, 0}});
  graph.add<CoordinateDrive>("drive", {displacement_between(graph.ground().marker(), load.marker(), 0)},
                             {.motion = ramp(0.01, speed)});
  graph.add<PointForce>("weight", {load.marker()}, {.force = {0, 0, -P}});
  add_sliding_joint(graph, "rolls", load.marker(), along(beam));
  const Marker middle = beam.marker(L / 2);
  const System system = assemble(graph);
  GeneralizedAlpha method({.step = 1e-3});
  Simulation simulation(system, method);
  State state = system.initial_state();
  double worst = 0, largest = 0;
  for (int i = 1; i <= 12; ++i) {
    const double t = 0.05 * i;
    simulation.run(state, t);
    double w = 0;
    for (int n = 1; n < 40; ++n) {
      const double omega = n * n * M_PI * M_PI / (L * L) * std::sqrt(EI / mu), Omega = n * M_PI * speed / L,
                   at = t + 0.01 / speed;  // it begins a little way in
      w += 2 * P / (mu * L) * std::sin(n * M_PI / 2) * (std::sin(Omega * at) - Omega / omega * std::sin(omega * at)) /
           (omega * omega - Omega * Omega);
    }
    Snapshot now(system, state);
    worst = std::max(worst, std::abs(-now.marker(middle).p.z() - w)), largest = std::max(largest, w);
  }
  expect_below("deflection of the middle, of the largest", worst / largest, 0.005);
}

/// A clamped beam falls, and a mass runs down along it: over all nodes, without loss.
TEST(SlidingJoint, AMassRunsDownABeamThatFalls) {
  const BeamSection section = BeamSection::diagonal({1e5, 1e5, 1e5, 20, 30, 30}, 1, {2e-4, 1e-4, 1e-4});
  Vector3 ends[3];
  for (int k = 0; k < 3; ++k) {
    SystemGraph graph;
    auto& beam = graph.add<Beam>(
        "beam",
        {.axis = BeamAxis::straight({0, 0, 0}, {1.5, 0, 0}, {0, 1, 0}), .sections = {{0, section}}, .elements = 12});
    graph.add<FixedJoint>("clamp", {graph.ground().marker({0, 0, 0}, beam.axes(0)), beam.marker(0)});
    auto& mass = graph.add<RigidBody>(
        "mass", {.mass = 0.8, .inertia = {1e-3, 2e-3, 1e-3}, .position = {0.2, 0, 0}, .velocity = {1, 0, 0}});
    auto& joint = add_sliding_joint(graph, "slide", mass.marker(), along(beam));
    const System system = assemble(graph);
    const State start = system.initial_state();
    const double before = read(system, start, total_energy());
    Method methods[] = {radau(1e-7), bdf(1e-7), index3(2e-4)};
    const State end = run(system, start, std::move(methods[k]), 0.4);
    expect_below("energy", std::abs(read(system, end, total_energy()) - before), 1e-6);
    EXPECT_GT(read(system, end, place_on_rail(joint)), 0.65);
    ends[k] = end.q.tail<7>().head<3>();
  }
  expect_below("BDF from Radau", (ends[1] - ends[0]).norm(), 1e-6);
  expect_below("generalized-alpha from Radau", (ends[2] - ends[0]).norm(), 1e-5);
}

/// A bead of weight W in the middle of a taut string: sag h with W = 2 T h / l, l half the stretched string.
TEST(SlidingJoint, ABeadOnAStringRestsInItsMiddle) {
  const double L = 2, EA = 2e3, pull = 0.95, W = 0.5 * kGravity;  // unstretched 1.9 m
  SystemGraph graph;
  auto& string = graph.add<Cable>("string", {.from = {0, 0, 0},
                                             .to = {L, 0, 0},
                                             .length = pull * L,
                                             .elements = 40,
                                             .mass_per_length = 1e-6,
                                             .axial_stiffness = EA});
  graph.add<SphericalJoint>("left", {graph.ground().marker({0, 0, 0}), string.start()});
  graph.add<SphericalJoint>("right", {graph.ground().marker({L, 0, 0}), string.end()});
  auto& bead = graph.add<PointMass>("bead", {.mass = 0.5, .position = {1, 0, 0}});
  add_sliding_joint(graph, "slide", bead.marker(), along(string));
  const System system = assemble(graph);
  const State rest = find_equilibrium(system, system.initial_state()).state;
  const Vector3 p = rest.q.tail<3>();
  double h = 0.01;
  for (int i = 0; i < 100; ++i) {
    const double l = std::hypot(L / 2, h), T = EA * (l / (pull * L / 2) - 1);
    h = W * l / (2 * T);
  }
  expect_below("along", std::abs(p.x() - 1), 1e-9);
  expect_below("sag", std::abs(-p.z() / h - 1), 1e-4);
}

// ---- input ----

TEST(SlidingJoint, SaysWhatIsWrong) {
  SystemGraph graph;
  auto& bead = graph.add<PointMass>("bead", {.mass = 1, .position = {0, 0, 0}});
  const auto at = [&](double x, double z = 0) { return graph.ground().marker({x, 0, z}); };
  EXPECT_THROW(add_sliding_joint(graph, "none", bead.marker(), {}), SceneError);
  EXPECT_THROW(add_sliding_joint(graph, "two", bead.marker(), {at(0), at(1)}), SceneError);
  EXPECT_THROW(add_sliding_joint(graph, "many", bead.marker(), std::vector<Marker>(300, at(0))), SceneError);
  const auto refused = [](const Vector3& place, std::initializer_list<double> xs) {
    SystemGraph scene;
    auto& point = scene.add<PointMass>("bead", {.mass = 1, .position = place});
    std::vector<Marker> rail;
    for (double x : xs) rail.push_back(scene.ground().marker({x, 0, 0}));
    add_sliding_joint(scene, "slide", point.marker(), rail);
    assemble(scene);
  };
  EXPECT_NO_THROW(refused({0.5, 0, 0.01}, {0, 1, 2}));
  EXPECT_THROW(refused({0.5, 0, 0.5}, {0, 1, 2}), SceneError);
  EXPECT_THROW(refused({0.5, 0, 0}, {0, 1, 1, 2}), SceneError);
  SystemGraph rubbed;
  auto& point = rubbed.add<PointMass>("bead", {.mass = 1});
  std::vector<Marker> rail{rubbed.ground().marker({-1, 0, 0}), rubbed.ground().marker(),
                           rubbed.ground().marker({1, 0, 0})};
  auto& joint = add_sliding_joint(rubbed, "slide", point.marker(), rail);
  EXPECT_THROW(add_sliding_friction(rubbed, "a", joint, {.coefficient = -1}), SceneError);
  EXPECT_THROW(add_sliding_friction(rubbed, "b", joint, {.creep_speed = 0}), SceneError);
}

}  // namespace
}  // namespace lithe::test::sliding_joint_test
