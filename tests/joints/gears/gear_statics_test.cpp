#include <gtest/gtest.h>

#include <algorithm>

#include "engine/analysis/equilibrium.h"
#include "joints/forces/point_force.h"
#include "joints/gears/bevel_gear_pair.h"
#include "tests/joints/gears/gear_scenes.h"
#include "tests/joints/gears/winding.h"
#include "tests/support/message_of.h"

/// Toothed gears at rest under load, against closed forms, and as drawn.
namespace lithe::test::gear_statics_test {
namespace {

using gears::GearScene, gears::kPressure, gears::small, gears::value;

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

/// Under a torque with the other gear held: F_t at the mean radius; of F_t tan α the cone angle's cosine radially and
/// its sine along the axis, away from the apex on either gear. The moment about the held axis is that of the ratio.
TEST(ToothedGearPair, RefusesAStateWithinItsBaseCircles) {
  GearScene scene({.gears = small()}, 1e-3, 1e-3, 0, 0);
  const System system = assemble(scene.graph);
  const GearGeometry g(small());
  const double base = g.A.base_radius + g.B.base_radius;
  for (const double apart : {1.001 * base, 0.999 * base}) {
    State state = system.initial_state();
    state.q[system.layout().bodies().back().q] = apart;
    const auto look = [&] { Snapshot(system, state).marker(scene.A.body->marker()); };
    if (apart > base)
      EXPECT_NO_THROW(look());
    else
      expect_says(message_of<SimulationError>(look), {"within the base circles", "mesh", "bearings"});
  }
}

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

/// Bevel gears are drawn by closed surfaces, the teeth of either in the spaces of the other.
TEST(BevelGearPair, IsDrawnWithItsTeeth) {
  const double shaft_angle = 80 * kPi / 180;
  const Matrix3 across = rotation_about({1, 0, 0}, -shaft_angle);
  const Vector3 at_A(0, 0, 0.05), at_B = across * Vector3(0, 0, 0.04);
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  const Shaft A = draw_shaft(graph, "A", 1e-3, at_A);
  auto& mesh = graph.add<BevelGearPair>("mesh", {A.body->marker(), graph.ground().marker(at_B, across)},
                                        {.module = 3e-3,
                                         .teeth_A = 18,
                                         .teeth_B = 24,
                                         .shaft_angle = shaft_angle,
                                         .face_width = 15e-3,
                                         .backlash = 3e-4,
                                         .teeth = {.model = ToothStiffness::table, .stiffness = {4e8}}});
  const System system = assemble(graph);
  const DrawnShape a = mesh.drawn_shapes(0)[0], b = mesh.drawn_shapes(1)[0];
  EXPECT_EQ(a.points.size(), 18u * 24);
  // No point of either is within the other; turned by half a pitch some are. Where y is small they are far apart.
  const auto is_near = [](const Vector3& from_A) { return from_A.y() > 15e-3; };
  const auto overlaps = [&](double turn) {
    const Matrix3 turned = rotation_about({0, 0, 1}, turn);
    int inside = 0;
    for (const Vector3& point : a.points) {
      if (!is_near(turned * point)) continue;
      const double w = winding(b, across.transpose() * (turned * point + at_A - at_B));
      EXPECT_NEAR(w, std::round(w), 1e-9);
      inside += w > 0.5;
    }
    for (const Vector3& point : b.points) {
      const Vector3 from_A = across * point + at_B - at_A;
      if (is_near(from_A)) inside += winding(a, turned.transpose() * from_A) > 0.5;
    }
    return inside;
  };
  EXPECT_EQ(overlaps(0), 0);
  EXPECT_GT(overlaps(kPi / 18), 4);
  // A point within a tooth of A, on its own.
  const Vector3 tooth = (a.points[0] + a.points[10] + a.points[20] + a.points[3]) / 4;
  EXPECT_NEAR(winding(a, tooth), 1, 1e-9);
}

}  // namespace
}  // namespace lithe::test::gear_statics_test
