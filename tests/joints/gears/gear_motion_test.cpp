#include <gtest/gtest.h>

#include <algorithm>

#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/point_force.h"
#include "joints/gear_pair.h"
#include "joints/gears/toothed_rack.h"
#include "joints/prismatic_joint.h"
#include "tests/joints/gears/gear_scenes.h"

/// Toothed gears in motion, against closed forms.
namespace lithe::test::gear_motion_test {
namespace {

using gears::GearScene, gears::kPressure, gears::small, gears::value;

/// From the middle of the backlash a constant torque takes the time √(j J/(r_b T)) to cross half of it; with 1 µs less
/// there is no force, a moment later there is.
TEST(ToothedGearPair, CrossesItsBacklashFreely) {
  const double J = 2e-3, T = 0.5, j = 60e-6;
  for (const double way : {1.0, -1.0}) {
    ToothedGearPair::Parameters parameters{.gears = small()};
    parameters.gears.backlash = j;
    GearScene scene(parameters, J, 3e-3, way * T, 0);
    const System system = assemble(scene.graph);
    const double time = std::sqrt(j * J / (scene.mesh->geometry().A.base_radius * T));
    for (const double late : {-1e-6, 1e-6}) {
      State state = system.initial_state();
      Method method = runge_kutta8(1e-12);
      Simulation{system, *method}.run(state, time + late);
      const double force = std::hypot(value(system, state, applied_force(*scene.mesh, 1), 0),
                                      value(system, state, applied_force(*scene.mesh, 1), 1));
      if (late > 0) {
        EXPECT_GT(force, 1);
        continue;
      }
      EXPECT_EQ(force, 0);
      EXPECT_NEAR(value(system, state, coordinate(scene.A.angle(), "")), way * 0.5 * T / J * std::pow(time + late, 2),
                  1e-12);
    }
  }
}

/// Helical teeth that hit either flank in turn, some twenty times: energy is kept; with damping it falls, and flanks
/// push the gears apart, never together.
TEST(ToothedGearPair, KeepsItsEnergyAndNeverPulls) {
  for (const double damping : {0.0, 3e4}) {
    ToothedGearPair::Parameters parameters{.gears = small(0.2),
                                           .teeth = {.damping = damping, .error = {0, 2e-6, 0, 1e-6}}};
    parameters.gears.backlash = 30e-6;
    GearScene scene(parameters, 1e-3, 2e-3, 0, 0);
    const System system = assemble(scene.graph);
    State state = system.initial_state();
    state.v[5] = 3;
    Method method = runge_kutta8(1e-13);
    Recorder recorder{{total_energy("E"), applied_force(*scene.mesh, 1, kWorldAxes, "F")}};
    Simulation simulation{system, *method};
    simulation.observe(recorder, every(2e-6));
    simulation.run(state, 10e-3);
    const std::vector<double> E = recorder.table().column("E"), F = recorder.table().column("F_force_x"),
                              tangential = recorder.table().column("F_force_y");
    const double initial = 0.5 * 1e-3 * 9;
    int hits = 0;
    for (std::size_t i = 1; i < F.size(); ++i) {
      EXPECT_GE(F[i], -1e-12);
      hits += F[i] > 1 && F[i - 1] <= 1;
      if (damping == 0) {
        EXPECT_NEAR(E[i], initial, 1e-8 * initial);
      } else {
        EXPECT_LE(E[i], E[i - 1] + 1e-9 * initial);
      }
    }
    EXPECT_GT(hits, damping == 0 ? 10 : 1);
    if (damping == 0) {
      EXPECT_LT(*std::min_element(tangential.begin(), tangential.end()), -100);
    } else {
      EXPECT_LT(E.back(), 0.9 * initial);
    }
  }
}

/// The rigid limit: the motion of a GearPair of the working radii, and its bearing forces but for the pressure angle.
TEST(ToothedGearPair, MovesAsTheIdealPairWhereTeethAreStiff) {
  const double J_A = 2e-3, J_B = 8e-3, T = 4;
  for (const bool ring : {false, true}) {
    const ToothedGearPair::Parameters parameters{
        .gears = small(0, ring), .teeth = {.model = ToothStiffness::table, .stiffness = {1e10}, .damping = 1e5}};
    GearScene toothed(parameters, J_A, J_B, T, 0);
    const GearGeometry& g = toothed.mesh->geometry();
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    const Shaft A = draw_shaft(graph, "A", J_A), B = draw_shaft(graph, "B", J_B, {std::abs(g.centre_distance), 0, 0});
    graph.add<GearPair>("mesh", {A.body->marker(), B.body->marker()},
                        {.radius_A = g.A.working_radius, .radius_B = g.B.working_radius});
    graph.add<PointForce>("torque A", {A.body->marker()}, {.torque = {0, 0, T}});
    const System system = assemble(toothed.graph), ideal = assemble(graph);
    State state = system.initial_state(), expected = ideal.initial_state();
    Method method = radau(1e-8), other = radau(1e-8);
    Simulation{system, *method}.run(state, 0.2);
    Simulation{ideal, *other}.run(expected, 0.2);
    const double phi = value(ideal, expected, coordinate(B.angle(), ""));
    EXPECT_GT(std::abs(phi), 4);
    EXPECT_NEAR(value(system, state, coordinate(toothed.B.angle(), "")), phi, 2e-5 * std::abs(phi));
    const auto bearing = [&](int column) {
      return std::pair{value(system, state, reaction(*toothed.B.pin, 1), column),
                       value(ideal, expected, reaction(*B.pin, 1), column)};
    };
    const auto [push, ideal_push] = bearing(1);
    EXPECT_NEAR(push, ideal_push, 1e-3 * std::abs(ideal_push));
    // Ring or not, flanks press the centres the way that opens their teeth.
    EXPECT_NEAR(bearing(0).first, (ring ? 1 : -1) * std::abs(ideal_push) * std::tan(kPressure),
                1e-3 * std::abs(ideal_push));
  }
}

/// Driven at constant speed against a torque: the power that teeth lose by friction is that of Ohlendorf's loss factor,
///   P_V = P μ π (1/z_A + 1/z_B) (1 - ε_α + ε_A² + ε_B²)
/// (Niemann & Winter), and the element's mean power is minus that.
TEST(ToothedGearPair, LosesThePowerOfItsFriction) {
  const double mu = 0.06, speed = 60, T = 20;
  const ToothedGearPair::Parameters parameters{
      .gears = small(),
      .teeth = {
          .model = ToothStiffness::table, .stiffness = {4e8}, .damping = 5e3, .friction = mu, .creep_speed = 1e-3}};
  GearScene scene(parameters, 1e-3, 2e-3, 0, T, speed);
  const GearGeometry& g = scene.mesh->geometry();
  auto& drive = scene.graph.add<CoordinateDrive>("drive", {scene.A.angle()}, {.motion = ramp(0, speed)});
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  Method method = radau(1e-7);
  Recorder recorder{{power(drive, "in"), power(*scene.mesh, "mesh")}};
  const double cycle = 2 * kPi / (20 * speed);
  Simulation simulation{system, *method};
  simulation.run(state, 5 * cycle);
  simulation.observe(recorder, every(cycle / 200));
  simulation.run(state, 15 * cycle);
  const auto mean = [&](const char* column) {
    const std::vector<double> all = recorder.table().column(column);
    double sum = 0;
    for (std::size_t i = 1; i < all.size(); ++i) sum += all[i];
    return sum / static_cast<double>(all.size() - 1);
  };
  const double e_A = g.recess / g.base_pitch, e_B = g.approach / g.base_pitch, out = T * speed * 20 / 31;
  const double loss = mu * kPi * (1.0 / 20 + 1.0 / 31) * (1 - g.contact_ratio + e_A * e_A + e_B * e_B);
  EXPECT_NEAR(mean("in") - out, loss * out, 0.03 * loss * out);
  EXPECT_NEAR(mean("mesh"), -loss * out, 0.03 * loss * out);
}

/// A gear drives its rack: F = T/r along it and F tan α away, and a carriage of m moves as one of m + J/r².
TEST(ToothedRack, DrivesAsItsPitchCircleRolls) {
  const double J = 1e-3, m = 4, T = 3, r = 30e-3;
  ToothedRack::Parameters parameters{.gears = {.module = 3e-3, .teeth_A = 20, .face_width = 20e-3},
                                     .teeth = {.model = ToothStiffness::table, .stiffness = {1e10}, .damping = 1e5}};
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  const Shaft A = draw_shaft(graph, "A", J);
  const Matrix3 along = rotation_about({0, 1, 0}, kPi / 2);
  auto& rack = graph.add<RigidBody>("rack", {.mass = m, .position = {0, -r, 0}});
  auto& slide = graph.add<PrismaticJoint>("slide", {graph.ground().marker({0, -r, 0}, along), rack.marker({}, along)});
  auto& mesh = graph.add<ToothedRack>("mesh", {A.body->marker(), rack.marker()}, parameters);
  graph.add<PointForce>("torque", {A.body->marker()}, {.torque = {0, 0, T}});
  const System system = assemble(graph);
  State state = system.initial_state();
  Method method = index3(1e-3, 0.5);
  Simulation{system, *method}.run(state, 0.2);
  const double acceleration = T / r / (m + J / (r * r));
  const double x = value(system, state, coordinate(slide.displacement(), ""));
  EXPECT_NEAR(x, 0.5 * acceleration * 0.04, 1e-4 * x);
  EXPECT_NEAR(value(system, state, applied_force(mesh, 1), 0), m * acceleration, 1e-3 * m * acceleration);
  EXPECT_NEAR(value(system, state, applied_force(mesh, 1), 1), -m * acceleration * std::tan(kPressure),
              1e-3 * m * acceleration);
}

}  // namespace
}  // namespace lithe::test::gear_motion_test
