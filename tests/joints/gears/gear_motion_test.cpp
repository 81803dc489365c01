#include <gtest/gtest.h>

#include <algorithm>

#include "engine/analysis/equilibrium.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "joints/gear_pair.h"
#include "joints/gears/bevel_gear_pair.h"
#include "joints/gears/toothed_gear_pair.h"
#include "joints/gears/toothed_rack.h"
#include "joints/prismatic_joint.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/message_of.h"

/// Toothed gears in motion, against closed forms.
namespace lithe::test::gear_motion_test {
namespace {

constexpr double kPressure = 20 * kPi / 180;

GearDesign small(double helix = 0, bool ring = false) {
  return {.module = 3e-3,
          .teeth_A = 20,
          .teeth_B = ring ? -62.0 : 31.0,
          .helix_angle = helix,
          .shortening_B = ring ? 0.45 : 0,
          .face_width = 20e-3};
}

/// Two shafts of the ground, meshing.
struct GearScene {
  GearScene(const ToothedGearPair::Parameters& parameters, double J_A, double J_B, double torque_A, double torque_B,
            double speed = 0) {
    const GearGeometry g(parameters.gears);
    A = draw_shaft(graph, "A", J_A, {0, 0, 0}, Matrix3::Identity(), speed);
    B = draw_shaft(graph, "B", J_B, {std::abs(g.centre_distance), 0, 0}, Matrix3::Identity(),
                   -speed * g.A.teeth / g.B.teeth);
    mesh = &graph.add<ToothedGearPair>("mesh", {A.body->marker(), B.body->marker()}, parameters);
    if (torque_A != 0) graph.add<PointForce>("torque A", {A.body->marker()}, {.torque = {0, 0, torque_A}});
    if (torque_B != 0) graph.add<PointForce>("torque B", {B.body->marker()}, {.torque = {0, 0, torque_B}});
  }
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  Shaft A, B;
  ToothedGearPair* mesh;
};

double value(const System& system, const State& state, const Sensor& sensor, int column = 0) {
  Snapshot now{system, state};
  return sensor.value(now, column);
}

/// The drawing with the first body turned about z.
State turned(const System& system, double angle) {
  State state = system.initial_state();
  VectorX turn = VectorX::Zero(system.layout().v_count());
  turn[5] = angle;
  system.layout().retract(system.initial_state().q, turn, state.q);
  return state;
}

/// A under torque T, B held: the transmission error is δ = F/k(ψ) with F = T/r_b, but for what the change of stiffness
/// takes, ½ k' δ²/p_b, at all phases, with three curves of stiffness; external and ring gears, either way of driving.
TEST(ToothedGearPair, HasTheTransmissionErrorOfForceOverStiffness) {
  for (const bool ring : {false, true})
    for (const auto model : {ToothStiffness::weber_banaschek, ToothStiffness::iso_6336, ToothStiffness::table})
      for (const double way : {1.0, -1.0}) {
        double least = 1, most = 0;
        for (const double phase : {0.0, 0.2, 0.35, 0.5, 0.8}) {
          ToothedGearPair::Parameters parameters{.gears = small(0, ring), .teeth = {.model = model, .phase = phase}};
          if (model == ToothStiffness::table) parameters.teeth.stiffness = {3e8, 3.2e8, 4e8, 5e8, 4.2e8, 3.1e8};
          parameters.gears.backlash = 40e-6;
          SystemGraph graph{{.gravity = {0, 0, 0}}};
          const GearGeometry g(parameters.gears);
          const Shaft A = draw_shaft(graph, "A", 1e-3);
          const Marker B = graph.ground().marker({std::abs(g.centre_distance), 0, 0});
          auto& mesh = graph.add<ToothedGearPair>("mesh", {A.body->marker(), B}, parameters);
          const double r_b = g.A.base_radius, F = 3000;
          graph.add<PointForce>("torque", {A.body->marker()}, {.torque = {0, 0, way * F * r_b}});
          const System system = assemble(graph);
          // Started in contact: within the backlash nothing holds the gear.
          const Equilibrium found = find_equilibrium(system, turned(system, way * 28e-6 / r_b));
          const double error = way * r_b * value(system, found.state, coordinate(A.angle(), "angle")) - 20e-6;
          // The phase moves with half the advance of A; B holds still.
          const double advance = 0.5 * way * (error + 20e-6) / g.base_pitch;
          const auto at = [&](double at_phase) {
            const double thickness = g.A.tooth_thickness * g.A.teeth / (2 * kPi * g.A.working_radius);
            return mesh.mesh().stiffness()(way > 0 ? at_phase : thickness - at_phase);
          };
          const auto k = at(phase + advance);
          EXPECT_NEAR(error, F / k.value, 0.01 * error) << phase;
          const double change = 0.25 * way * (way > 0 ? 1 : -1) * k.slope / g.base_pitch * error * error;
          EXPECT_NEAR(k.value * error + change, F, 1e-6 * F) << phase;
          least = std::min(least, error), most = std::max(most, error);
        }
        EXPECT_GT(most, 1.3 * least);
      }
}

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

/// At rest on helical teeth: F_t = T/r, the axial force F_t tan β against the driver's thread, the radial one F_t tan
/// α_t.
TEST(ToothedGearPair, PushesAlongItsHelix) {
  for (const double helix : {0.3, -0.3}) {
    const ToothedGearPair::Parameters parameters{.gears = small(helix),
                                                 .teeth = {.model = ToothStiffness::table, .stiffness = {4e8}}};
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    const GearGeometry g(parameters.gears);
    const Shaft A = draw_shaft(graph, "A", 1e-3);
    auto& mesh = graph.add<ToothedGearPair>(
        "mesh", {A.body->marker(), graph.ground().marker({g.centre_distance, 0, 0})}, parameters);
    const double T = 30, F = T / g.A.pitch_radius;
    graph.add<PointForce>("torque", {A.body->marker()}, {.torque = {0, 0, T}});
    const System system = assemble(graph);
    const State rest = find_equilibrium(system, system.initial_state()).state;
    const auto on_B = [&](int column) { return value(system, rest, applied_force(mesh, 1), column); };
    EXPECT_NEAR(on_B(1), F, 1e-6 * F);
    EXPECT_NEAR(on_B(0), F * std::tan(g.transverse_pressure_angle), 1e-6 * F);
    EXPECT_NEAR(on_B(2), -F * std::tan(helix), 1e-6 * F);
    EXPECT_NEAR(on_B(5), F * g.B.pitch_radius * -1 + 0, 1e-6 * F * g.B.pitch_radius);
  }
}

/// B is held on a tilted axis: teeth touch along the face where δ - γ y > 0. Where the whole face does, F = k δ with
/// its resultant γ k b²/12F off the middle; where a length l = δ/γ + b/2 of it does, F = k γ l²/2b, its resultant at a
/// third of it. An axis held further away opens the backlash by 2 sin α a metre.
TEST(ToothedGearPair, CarriesAtTheEndOfItsFaceOnATiltedAxis) {
  const double k = 4e8, b = 20e-3, F = 3000;
  ToothedGearPair::Parameters parameters{.gears = small(), .teeth = {.model = ToothStiffness::table, .stiffness = {k}}};
  parameters.gears.backlash = 60e-6;  // without it the other flank would touch at the other end
  const GearGeometry g(parameters.gears);
  for (const Vector3& turn : {Vector3(-1e-4, 0, 0), Vector3(0, 2e-4, 0), Vector3(-2e-3, 0, 0), Vector3(2e-3, 0, 0)}) {
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    const Shaft A = draw_shaft(graph, "A", 1e-3);
    const Matrix3 tilted = rotation_exp(turn);
    auto& mesh = graph.add<ToothedGearPair>(
        "mesh", {A.body->marker(), graph.ground().marker({g.centre_distance, 0, 0}, tilted)}, parameters);
    graph.add<PointForce>("torque", {A.body->marker()}, {.torque = {0, 0, F * g.A.base_radius}});
    const System system = assemble(graph);
    const State rest = find_equilibrium(system, turned(system, 32e-6 / g.A.base_radius)).state;
    const Vector3 n(std::sin(kPressure), std::cos(kPressure), 0);
    const double tilt = n.dot(tilted.col(2)), h = 0.5 * b * std::abs(tilt), whole = F / k;
    const double length = std::sqrt(2 * b * F / (k * std::abs(tilt)));
    const double approach = whole > h ? whole : std::abs(tilt) * (length - 0.5 * b);
    const double middle = whole > h ? -tilt * k * b * b / (12 * F) : std::copysign(1, tilt) * (length / 3 - 0.5 * b);
    EXPECT_NEAR(g.A.base_radius * value(system, rest, coordinate(A.angle(), "")), 30e-6 + approach, 2e-3 * whole);
    const Sensor load = applied_force(mesh, 1);
    const Vector3 moment(value(system, rest, load, 3), value(system, rest, load, 4), value(system, rest, load, 5));
    EXPECT_NEAR(Vector3::UnitZ().cross(n).dot(moment) / F, middle, 0.01 * b);
  }
  EXPECT_NEAR(2 * g.half_play(g.centre_distance + 1e-6) - g.backlash, 2e-6 * std::sin(kPressure), 1e-10);
}

/// Pages draw gears by closed surfaces that look outwards: their volume is about that of a disc or ring.
TEST(ToothedGearPair, IsDrawnByClosedSurfaces) {
  for (const bool ring : {false, true}) {
    GearScene scene({.gears = small(0.2, ring)}, 1e-3, 1e-3, 0, 0);
    const System system = assemble(scene.graph);
    for (int marker : {0, 1}) {
      const DrawnShape shape = scene.mesh->drawn_shapes(marker)[0];
      double volume = 0;
      for (const auto& [a, b, c] : shape.triangles) {
        const auto at = [&](int i) { return shape.points[static_cast<std::size_t>(i)]; };
        volume += at(a).dot(at(b).cross(at(c))) / 6;
      }
      const InvoluteGear& gear = marker == 0 ? scene.mesh->geometry().A : scene.mesh->geometry().B;
      const double inner = gear.teeth < 0 ? gear.pitch_radius : 0.4 * gear.root_radius;
      const double outer = gear.teeth < 0 ? -gear.root_radius + 6e-3 : gear.pitch_radius;
      const double disc = kPi * 20e-3 * (outer * outer - inner * inner);
      EXPECT_NEAR(volume, disc, 0.08 * disc);
    }
  }
}

TEST(ToothedGearPair, RefusesCentresAtWhichItDoesNotMesh) {
  const auto at = [](double x, const Matrix3& axes) {
    return message_of<SceneError>([&] {
      SystemGraph graph;
      const Shaft A = draw_shaft(graph, "A", 1e-3);
      graph.add<ToothedGearPair>("mesh", {A.body->marker(), graph.ground().marker({x, 0, 0}, axes)},
                                 {.gears = small()});
      assemble(graph);
    });
  };
  EXPECT_EQ(at(76.5e-3, Matrix3::Identity()), "");
  expect_says(at(76.3e-3, Matrix3::Identity()), {"mesh", "0.0763", "must not overlap"});
  expect_says(at(80e-3, Matrix3::Identity()), {"0.08", "mesh at 0.0765"});
  expect_says(at(76.5e-3, rotation_about({1, 0, 0}, kPi)), {"z"});
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

/// Under a torque with the other gear held: F_t at the mean radius; of F_t tan α the cone angle's cosine radially and
/// its sine along the axis, away from the apex on either gear. The moment about the held axis is that of the ratio.
TEST(BevelGearPair, PushesBothConesFromTheirApex) {
  const double shaft_angle = 80 * kPi / 180, T = 20;
  const Matrix3 across = rotation_about({1, 0, 0}, -shaft_angle);  // z of B in the yz plane, towards +y
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  const Shaft A = draw_shaft(graph, "A", 1e-3, {0, 0, 0.05});
  auto& mesh =
      graph.add<BevelGearPair>("mesh", {A.body->marker(), graph.ground().marker(across * Vector3(0, 0, 0.04), across)},
                               {.module = 3e-3,
                                .teeth_A = 20,
                                .teeth_B = 32,
                                .shaft_angle = shaft_angle,
                                .face_width = 15e-3,
                                .teeth = {.model = ToothStiffness::table, .stiffness = {4e8}}});
  graph.add<PointForce>("torque", {A.body->marker()}, {.torque = {0, 0, T}});
  const System system = assemble(graph);
  const State rest = find_equilibrium(system, system.initial_state()).state;
  const auto on = [&](int marker, int first) {
    const Sensor load = applied_force(mesh, marker);
    return Vector3(value(system, rest, load, first), value(system, rest, load, first + 1),
                   value(system, rest, load, first + 2));
  };
  EXPECT_NEAR(std::tan(mesh.cone_angle_A()), std::sin(shaft_angle) / (1.6 + std::cos(shaft_angle)), 1e-12);
  const double F = T / 30e-3, separating = F * std::tan(kPressure);
  // A's teeth at +y run towards -x under +z.
  EXPECT_NEAR(on(0, 0).x(), F, 1e-5 * F);
  EXPECT_NEAR(on(0, 0).y(), -separating * std::cos(mesh.cone_angle_A()), 1e-5 * F);
  EXPECT_NEAR(on(0, 0).z(), separating * std::sin(mesh.cone_angle_A()), 1e-5 * F);
  EXPECT_NEAR(on(1, 0).dot(across.col(2)), separating * std::sin(mesh.cone_angle_B()), 1e-5 * F);
  EXPECT_NEAR(on(1, 3).dot(across.col(2)), -T * 1.6, 1e-5 * T);
}

}  // namespace
}  // namespace lithe::test::gear_motion_test
