#pragma once

#include "joints/forces/point_force.h"
#include "joints/gears/toothed_gear_pair.h"
#include "tests/joints/mechanisms.h"

/// Pieces of the scenes of toothed gears.
namespace lithe::test::gears {

inline constexpr double kPressure = 20 * kPi / 180;

inline GearDesign small(double helix = 0, bool ring = false) {
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

inline double value(const System& system, const State& state, const Sensor& sensor, int column = 0) {
  Snapshot now{system, state};
  return sensor.value(now, column);
}

}  // namespace lithe::test::gears
