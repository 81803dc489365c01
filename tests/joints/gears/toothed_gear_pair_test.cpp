#include "joints/gears/toothed_gear_pair.h"

#include <gtest/gtest.h>

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
        check_force(graph, graph.add<ToothedGearPair>("teeth", markers, parameters), {.tolerance = 1e-6, .difference = 2e-5});
      }
    }
}

}  // namespace
}  // namespace lithe::test::toothed_gear_pair_test
