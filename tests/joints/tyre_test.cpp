#include "joints/tyre/tyre.h"

#include <gtest/gtest.h>

#include "bodies/flexible/flexible_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/model/marker_motions.h"
#include "engine/observe/snapshot.h"
#include "joints/fixed_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/joints/mechanisms.h"
#include "tests/joints/tyre_scenes.h"
#include "tests/support/joint_checks.h"
#include "tests/support/message_of.h"
#include "tests/support/motion.h"
#include "tests/support/pairs.h"
#include "tests/support/scenes.h"

namespace lithe::test::tyre_test {
namespace {

constexpr double kGravity = 9.81;

Tyre::Contact contact_of(const Scene& scene, const Tyre& tyre) {
  Snapshot now{scene.system, scene.state};
  return tyre.contact(MarkerMotions(tyre.markers(), [&](const Marker& m) { return now.marker(m); }));
}

/// Large and soft, to touch at any pose near the drawing; without |Ω|, whose kink differences may step over.
TyreCoefficients giant() {
  TyreCoefficients c = car_tyre();
  c.unloaded_radius = 4, c.fnomin = 60, c.vertical_stiffness = 40, c.q_fz2 = 1, c.vertical_damping = 0.7,
  c.vxlow = 0.05;
  c.longitudinal_stiffness = 100, c.lateral_stiffness = 60, c.fzmax = c.cammax = c.kpumax = TyreCoefficients::kNone;
  c.q_v2 = 0;
  c.cammin = c.kpumin = -TyreCoefficients::kNone;
  return c;
}

const ForceExpectation kTyreExpectation{.conservative = false, .tolerance = 1e-6};

TEST(Tyre, HasItsExactTangentOnEveryBody) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    {
      SystemGraph graph;
      const std::vector<Marker> m = pair.draw(graph, {0.25, -0.35, 0.5});
      // Markers are drawn parallel: the road is taken along their x, so that the wheel stands.
      auto& post = graph.add<RigidBody>("post", {.orientation = rotation_exp(Vector3(0.4, -0.7, 0.9))});
      auto& states = graph.add<FirstOrderStates>("carcass", {.start = Vector3(0.2, -0.1, 0)});
      check_force(
          graph,
          graph.add<Tyre>("tyre", {post.marker({-1, 0, 0}, rotation_about({0, 1, 0}, kPi / 2)), m[1], states.point(0)},
                          {.coefficients = giant()}),
          kTyreExpectation);
    }
    SystemGraph graph;
    const std::vector<Marker> m = pair.draw(graph, {0.2, -0.3, 0.45});
    auto& wheel = graph.add<RigidBody>(
        "wheel",
        {.position = {0.35, 1.2, 1.6}, .orientation = Matrix3(rotation_exp(Vector3(0.4, -0.7, 0.9)) * axle_left(0.3))});
    auto& states = graph.add<FirstOrderStates>("carcass", {.start = Vector3(0.2, -0.1, 0)});
    check_force(
        graph,
        graph.add<Tyre>("tyre", {m[0], wheel.marker(), states.point(0)}, {.coefficients = giant(), .mirrored = true}),
        kTyreExpectation);
  }
}

/// A wheel so heavy that nothing changes its motion, at `height`, its heading `heading` from its path along x.
struct Steady {
  static constexpr double kSpeed = 12;
  const Tyre* tyre = nullptr;
  Scene scene;

  Steady(double heading, double camber, double spin, double height, Tyre::Parameters p)
      : scene(Vector3::Zero(), [&](SystemGraph& graph) {
          const Matrix3 axes = rotation_about({0, 0, 1}, heading) * rotation_about({1, 0, 0}, camber) * axle_left();
          auto& wheel = graph.add<RigidBody>("wheel", {.mass = 1e16,
                                                       .inertia = {1e16, 1e16, 1e16},
                                                       .position = {0, 0, height},
                                                       .orientation = axes,
                                                       .velocity = {kSpeed, 0, 0},
                                                       .angular_velocity = {0, 0, spin}});
          tyre = &draw_tyre(graph, "tyre", graph.ground().marker(), wheel.marker(), std::move(p));
        }) {}
};

TEST(Tyre, EqualsTheFormulaOnceItHasRolled) {
  double worst = 0;
  for (const auto& [heading, camber, spin] : {std::tuple(0.05, 0.0, 38.0), std::tuple(-0.2, 0.05, 42.0),
                                              std::tuple(0.1, -0.1, 30.0), std::tuple(0.0, 0.1, 39.0)})
    for (const bool mirrored : {false, true}) {
      Steady run(heading, camber, spin, 0.295, {.coefficients = car_tyre(), .mirrored = mirrored});
      run.scene.run(*runge_kutta_fixed(2e-3), 2);
      const Tyre::Contact c = contact_of(run.scene, *run.tyre);
      const double side = mirrored ? -1 : 1;
      auto expected = run.tyre->formula().at({.kappa = -c.slip_x / std::abs(c.speed),
                                              .alpha = side * std::atan(c.slip_y / std::abs(c.speed)),
                                              .camber = side * c.camber,
                                              .load = c.load,
                                              .speed = c.speed});
      EXPECT_GT(std::abs(expected.Fx) + std::abs(expected.Fy), 100);
      EXPECT_NEAR(c.camber, camber, 1e-11);
      EXPECT_NEAR(c.speed, Steady::kSpeed * std::cos(heading), 1e-9);
      EXPECT_NEAR(c.slip_y, -Steady::kSpeed * std::sin(heading), 1e-9);
      for (double* x : {&expected.Fy, &expected.Mx, &expected.Mz}) *x *= side;
      // As the wheel feels it, about its centre.
      const Vector3 force = read_vector(run.scene, applied_force(*run.tyre, 1));
      const Vector3 moment = read_vector(run.scene, applied_force(*run.tyre, 1), 3);
      const Vector3 left = c.normal.cross(c.forward);
      const Vector3 F = expected.Fx * c.forward + expected.Fy * left + c.load * c.normal;
      const Vector3 M = expected.Mx * c.forward + expected.My * left + expected.Mz * c.normal;
      worst = std::max(worst, (force - F).norm() / c.load);
      worst = std::max(worst, (moment - M - (c.point - run.scene.position(0)).cross(F)).norm() / c.load);
      EXPECT_NEAR(c.point.z(), 0, 1e-12);
    }
  expect_below("steady force against the formula, of the load", worst, 1e-12);
}

/// Steer by a step at constant speed: v grows to its end as 1 - exp(-V t / σ), σ = K / C; likewise u.
TEST(Tyre, RelaxesOverItsLength) {
  const double heading = 0.03, spin = 37;
  Steady run(heading, 0, spin, 0.295, {.coefficients = car_tyre()});
  const Tyre::Contact start = contact_of(run.scene, *run.tyre);
  const auto K = run.tyre->formula().stiffness(start.load);
  const double V = Steady::kSpeed * std::cos(heading), sigma_x = K.longitudinal / 360000,
               sigma_y = -K.cornering / 125000;
  EXPECT_GT(sigma_y, 0.25);
  EXPECT_GT(sigma_x, 0.15);
  const Method method = runge_kutta_fixed(1e-4);
  for (const double time : {0.01, 0.03, 0.1}) {
    run.scene.run(*method, time);
    const Tyre::Contact c = contact_of(run.scene, *run.tyre);
    EXPECT_NEAR(std::tan(c.alpha), -std::tan(heading) * (1 - std::exp(-V * time / sigma_y)), 1e-8);
    EXPECT_NEAR(c.kappa, -(V - spin * c.radius) / V * (1 - std::exp(-V * time / sigma_x)), 1e-8);
  }
}

/// A free wheel that is towed turns by its effective rolling radius, and grows by its spin.
TEST(Tyre, RollsByItsEffectiveRadius) {
  const TyreCoefficients t = even_tyre();
  RevoluteJoint* pin;
  const Tyre* tyre;
  RigidBody* wheel;
  Scene scene(Vector3::Zero(), [&](SystemGraph& graph) {
    auto& tow = graph.add<RigidBody>("tow", {.mass = 1e14,
                                             .inertia = {1e14, 1e14, 1e14},
                                             .position = {0, 0, 0.295},
                                             .orientation = axle_left(),
                                             .velocity = {20, 0, 0}});
    wheel = &graph.add<RigidBody>("wheel", {.mass = 15,
                                            .inertia = {0.5, 0.5, 0.9},
                                            .position = {0, 0, 0.295},
                                            .orientation = axle_left(),
                                            .velocity = {20, 0, 0},
                                            .angular_velocity = {0, 0, 50}});
    pin = &graph.add<RevoluteJoint>("pin", {tow.marker(), wheel->marker()});
    tyre = &draw_tyre(graph, "tyre", graph.ground().marker(), wheel->marker(), {.coefficients = t});
  });
  scene.run(*radau(1e-9), 3);
  const double spin = read(scene, coordinate_rate(pin->angle(), "spin")), load = contact_of(scene, *tyre).load;
  const double free = 0.313 * (t.q_re0 + t.q_v1 * std::pow(0.313 * spin / t.longvl, 2));
  const double r = (free - 0.295) / 0.313, linear = std::sqrt(std::pow(209651 * 0.313 / 4000, 2) - 4 * 12.0);
  EXPECT_NEAR(load / (4000 * (linear * r + 12 * r * r) * (1 + 0.03 * 0.313 * spin / t.longvl)), 1, 1e-7);
  const double effective = free - 4000 / 209651.0 * (0.25826 * std::atan(8.386 * load / 4000) + 0.07394 * load / 4000);
  EXPECT_NEAR(20 / spin / effective, 1, 1e-6);
  EXPECT_GT(effective, 0.3);
}

/// Dropped, it comes to rest where spring and weight balance; it never pulls.
TEST(Tyre, CarriesItsLoadAndNeverPulls) {
  TyreCoefficients t = even_tyre();
  t.vertical_damping = 2000;
  const Tyre* tyre;
  Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
    auto& wheel = graph.add<RigidBody>("wheel", {.mass = 400, .position = {0, 0, 0.4}, .orientation = axle_left()});
    tyre = &draw_tyre(graph, "tyre", graph.ground().marker(), wheel.marker(), {.coefficients = t});
  });
  const Method method = radau(1e-8);
  bool flew = false;
  for (double time = 0.01; time < 8; time += 0.01) {
    scene.run(*method, time);
    const Tyre::Contact c = contact_of(scene, *tyre);
    ASSERT_GE(c.load, 0);
    if (c.deflection < 0) {
      flew = true;
      ASSERT_EQ(c.load, 0);
      ASSERT_EQ(read_vector(scene, applied_force(*tyre, 1)).norm(), 0);
    }
  }
  EXPECT_TRUE(flew);
  EXPECT_NEAR(scene.position(0).z(), 0.313 - sag(t, 400 * kGravity), 1e-7);
  EXPECT_NEAR(scene.position(0).head<2>().norm(), 0, 1e-9);
}

TEST(Tyre, KeepsItsEnergyWithoutDamping) {
  TyreCoefficients t = even_tyre();
  t.vertical_damping = 0;
  Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
    auto& wheel = graph.add<RigidBody>("wheel", {.mass = 20, .position = {0, 0, 0.35}, .orientation = axle_left()});
    draw_tyre(graph, "tyre", graph.ground().marker(), wheel.marker(), {.coefficients = t});
  });
  const double start = scene.energy();
  scene.run(*runge_kutta(1e-10), 0.6);
  EXPECT_NEAR(scene.energy(), start, 1e-6 * start);
}

/// A box on four tyres that do not turn, on a slope along and across: after it has settled it does not move.
TEST(Tyre, StandsOnASlopeWithoutCreep) {
  TyreCoefficients t = car_tyre();
  t.vertical_damping = 3000;
  RigidBody* box;
  Scene scene({1.2, 0.7, -9.6}, [&](SystemGraph& graph) {
    box = &graph.add<RigidBody>("box", {.mass = 1500, .inertia = {500, 2000, 2100}, .position = {0, 0, 0.6}});
    for (const auto& [x, y] : {std::pair(1.3, 0.75), {1.3, -0.75}, {-1.3, 0.75}, {-1.3, -0.75}})
      draw_tyre(graph, "tyre " + std::to_string(graph.forces().size()), graph.ground().marker(),
                box->marker({x, y, -0.3}, axle_left()), {.coefficients = t});
  });
  const Method method = index3(1e-2);
  scene.run(*method, 20);
  const Vector3 before = scene.position(0);
  scene.run(*method, 50);
  expect_below("creep on a slope in half a minute, m", (scene.position(0) - before).norm(), 1e-9);
  EXPECT_GT(before.head<2>().norm(), 1e-3);  // it hangs in its carcasses
  EXPECT_LT(before.head<2>().norm(), 2e-2);
}

/// A locked wheel slides to rest; what it takes from its motion is what the sensor says.
TEST(Tyre, SensorTellsSlipForceAndPower) {
  Steady run(0, 0, 0, 0.295, {.coefficients = even_tyre()});
  run.scene.run(*runge_kutta_fixed(2e-3), 1);
  const Sensor sensor = tyre_contact(*run.tyre);
  EXPECT_EQ(sensor.columns()[0], "tyre_kappa");
  EXPECT_EQ(sensor.unit(6), "N");
  EXPECT_NEAR(read(run.scene, sensor, 0), -1, 1e-9);
  const double Fx = read(run.scene, sensor, 4), load = read(run.scene, sensor, 6);
  EXPECT_LT(Fx, -0.7 * load);
  EXPECT_NEAR(read(run.scene, sensor, 10), Fx * Steady::kSpeed, 1e-6 * load);
}

/// Understeer: the angle of steer beyond L/R grows with the lateral acceleration by m/L (b/C_f - a/C_r).
TEST(Tyre, CarFollowsTheSingleTrackModel) {
  constexpr double kMass = 1500, kWheel = 10, a = 1.1, b = 1.5, L = a + b, kTrack = 1.5, speed = 30, steer = 4e-4;
  TyreCoefficients t = even_tyre();
  t.vertical_damping = 8000, t.ltr = t.lres = 0, t.ssz2 = t.ssz3 = t.ssz4 = 0;  // no trail
  TyreCoefficients front = t;
  front.lky = 0.8;
  std::vector<const Tyre*> tyres;
  RigidBody* chassis;
  constexpr double total = kMass + 4 * kWheel, load_front = total * kGravity * b / L / 2,
                   load_rear = total * kGravity * a / L / 2;
  // The wheels' own masses put the centre of mass where a and b say: the chassis's is a little ahead.
  constexpr double shift = -4 * kWheel * ((a - b) / 2) / kMass, height = 0.45;
  Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
    chassis = &graph.add<RigidBody>(
        "chassis",
        {.mass = kMass, .inertia = {450, 2200, 2400}, .position = {shift, 0, height}, .velocity = {speed, 0, 0}});
    for (const double x : {a, -b})
      for (const double y : {kTrack / 2, -kTrack / 2}) {
        const TyreCoefficients& its = x > 0 ? front : t;
        const double radius = 0.313 - sag(its, x > 0 ? load_front : load_rear);
        const std::string name = std::to_string(tyres.size());
        const Matrix3 axes = axle_left(x > 0 ? steer : 0);
        auto& wheel = graph.add<RigidBody>("wheel " + name, {.mass = kWheel,
                                                             .inertia = {0.4, 0.4, 0.7},
                                                             .position = {x, y, radius},
                                                             .orientation = axes,
                                                             .velocity = {speed, 0, 0},
                                                             .angular_velocity = {0, 0, speed / 0.305}});
        graph.add<RevoluteJoint>("hub " + name, {chassis->marker_at_world({x, y, radius}, axes), wheel.marker()});
        tyres.push_back(
            &draw_tyre(graph, "tyre " + name, graph.ground().marker(), wheel.marker(), {.coefficients = its}));
      }
  });
  scene.run(*index3(2e-3, 0.5), 6);
  const double yaw = scene.state.v[5], V = scene.state.v.head<2>().norm(), lateral = V * yaw;
  const double K_front = -2 * tyres[0]->formula().stiffness(load_front).cornering;
  const double K_rear = -2 * tyres[2]->formula().stiffness(load_rear).cornering;
  const double gradient = total / L * (b / K_front - a / K_rear), measured = (steer - L * yaw / V) / lateral;
  EXPECT_GT(lateral, 0.05);
  EXPECT_LT(lateral, 0.3);
  EXPECT_GT(gradient * V * V / L, 0.3);  // a good part of the angle
  expect_below("understeer gradient against the single-track model", std::abs(measured / gradient - 1), 0.01);
}

/// A wheel on nodes of a flexible hub that a guide holds at its other nodes: the tyre carries the hub's weight.
TEST(Tyre, StandsUnderAFlexibleHub) {
  const TyreCoefficients t = even_tyre();
  SystemGraph graph;
  const Marker wheel = draw_flexible(graph, "hub", {0, 0, 0.31}, axle_left());
  auto& slide = graph.add<RigidBody>("slide", {.mass = 0.3, .position = {0, 0, 2}});
  graph.add<PrismaticJoint>("guide", {graph.ground().marker({0, 0, 2}), slide.marker()});
  FlexibleBody& hub = dynamic_cast<FlexibleBody&>(*graph.bodies()[1].body);
  const Marker far = hub.average({1, 2, 3, 4});
  const System drawn = assemble(graph);
  Snapshot at{drawn, drawn.initial_state()};
  const MarkerKinematics held = at.marker(far);
  graph.add<FixedJoint>("clamp", {slide.marker_at_world(held.p, held.R), far});
  const Tyre& tyre = draw_tyre(graph, "tyre", graph.ground().marker(), wheel, {.coefficients = t});
  const System system = assemble(graph);
  const Equilibrium rest = find_equilibrium(system, system.initial_state());
  Snapshot now{system, rest.state};
  const double weight = kGravity * (0.3 + hub.basis().integrals.mass);
  EXPECT_NEAR(tyre_contact(tyre).value(now, 6) / weight, 1, 1e-8);
  const double camber = tyre_contact(tyre).value(now, 2);  // soft as the hub is, the wheel leans
  EXPECT_NEAR(tyre_contact(tyre).value(now, 3) / sag(t, weight * std::cos(camber)), 1, 1e-6);
}

TEST(Tyre, RefusesWhatIsNoTyre) {
  const auto refusal = [](auto&& change) {
    return message_of<SceneError>([&] {
      SystemGraph graph;
      Tyre::Parameters p{.coefficients = car_tyre()};
      change(p);
      draw_tyre(graph, "tyre", graph.ground().marker(), graph.add<RigidBody>("wheel").marker({}, axle_left()), p);
    });
  };
  EXPECT_EQ(refusal([](auto&) {}), "");
  expect_says(refusal([](auto& p) { p.pressure = -1; }), {"tyre", "pressure"});
  expect_says(refusal([](auto& p) { p.low_speed_damping = NAN; }), {"low_speed_damping"});
  expect_says(refusal([](auto& p) { p.coefficients.vertical_stiffness = 0; }), {"vertical_stiffness"});
  expect_says(refusal([](auto& p) { p.coefficients.q_fz1 = 5, p.coefficients.q_fz2 = -9; }), {"q_fz2"});
  expect_says(refusal([](auto& p) { p.coefficients.lateral_stiffness = 0; }), {"relaxation", "lateral_stiffness"});
  expect_says(refusal([](auto& p) { p.coefficients.unloaded_radius = -1; }), {"unloaded_radius", "-1"});
  SystemGraph graph;
  draw_tyre(graph, "tyre", graph.ground().marker(), graph.add<RigidBody>("wheel").marker(),
            {.coefficients = car_tyre()});
  expect_says(message_of<SceneError>([&] { assemble(graph); }), {"tyre", "z"});
}

}  // namespace
}  // namespace lithe::test::tyre_test
