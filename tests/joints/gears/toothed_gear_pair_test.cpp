#include "joints/gears/toothed_gear_pair.h"

#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "joints/gears/bevel_gear_pair.h"
#include "joints/gears/toothed_rack.h"
#include "tests/support/joint_checks.h"
#include "tests/support/pairs.h"

/// Toothed gears: what every force owes, on all kinds of bodies.
namespace lithe::test::toothed_gear_pair_test {
namespace {

/// Gears of metres, which random moves of the check leave in mesh; soft, with teeth whose stiffness changes a lot.
ToothedGearPair::Parameters large(double helix, bool ring) {
  return {.gears = {.module = 1,
                    .teeth_A = 20,
                    .teeth_B = ring ? -70.0 : 32.0,
                    .helix_angle = helix,
                    .shortening_B = ring ? 0.45 : 0,
                    .face_width = 4,
                    .backlash = 0.02},
          .teeth = {.model = ToothStiffness::table,
                    .stiffness = {100, 130, 180, 150, 110, 90},
                    .damping = 3,
                    .error = {0, 0.01, 0.02, 0.015},
                    .phase = 0.2}};
}

TEST(ToothedGearPair, PushesByWhatItsPotentialLosesOnAllBodies) {
  for (const double helix : {0.0, 0.3, -0.2})
    for (const bool ring : {false, true}) {
      const ToothedGearPair::Parameters parameters = large(helix, ring);
      const double apart = std::abs(GearGeometry(parameters.gears).centre_distance);
      for (const Pair& pair : pairs()) {
        SCOPED_TRACE(pair.name + " " + std::to_string(helix) + (ring ? " ring" : ""));
        SystemGraph graph{{.gravity = Vector3::Zero()}};
        const std::vector<Marker> markers = pair.draw(graph, {0.6 * apart, 0.8 * apart, 0});
        check_force(graph, graph.add<ToothedGearPair>("teeth", markers, parameters),
                    {.tolerance = 1e-6, .difference = 2e-5});
      }
    }
}

TEST(ToothedRack, PushesByWhatItsPotentialLosesOnAllBodies) {
  for (const double helix : {0.0, 0.3}) {
    const auto [gears, teeth] = large(helix, false);
    ToothedRack::Parameters parameters{gears, teeth};
    parameters.gears.teeth_B = 0;
    const double height = 0.5 * gears.teeth_A / std::cos(helix);
    for (const Pair& pair : pairs()) {
      SCOPED_TRACE(pair.name + " " + std::to_string(helix));
      SystemGraph graph{{.gravity = Vector3::Zero()}};
      std::vector<Marker> markers = pair.draw(graph, {3, height, 0});  // B over A: B is the gear
      std::swap(markers[0], markers[1]);
      check_force(graph, graph.add<ToothedRack>("teeth", markers, parameters), {.tolerance = 1e-6, .difference = 2e-5});
    }
  }
}

TEST(BevelGearPair, PushesByWhatItsPotentialLosesOnAllBodies) {
  const Matrix3 across = rotation_about({1, 0, 0}, 0.4 * std::numbers::pi);
  for (const bool at_apex : {true, false}) {
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    auto& a = graph.add<RigidBody>("a", {.mass = 1, .inertia = {1, 1, 1}});
    auto& b = graph.add<RigidBody>("b", {.mass = 1, .inertia = {1, 1, 1}, .orientation = across});
    check_force(graph,
                graph.add<BevelGearPair>(
                    "teeth", {a.marker({0, 0, at_apex ? 0.0 : 10.0}), b.marker({0, 0, at_apex ? 0.0 : 7.0})},
                    {.module = 1,
                     .teeth_A = 20,
                     .teeth_B = 32,
                     .shaft_angle = 0.4 * std::numbers::pi,
                     .face_width = 4,
                     .backlash = 0.02,
                     .teeth = large(0, false).teeth}),
                {.tolerance = 1e-6, .difference = 2e-5});
  }
}

}  // namespace
}  // namespace lithe::test::toothed_gear_pair_test
