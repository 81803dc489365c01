#include "joints/gears/sprocket_pair.h"

#include <gtest/gtest.h>

#include "tests/joints/mechanisms.h"
#include "tests/support/joint_checks.h"
#include "tests/support/pairs.h"

namespace lithe::test::sprocket_pair_test {
namespace {

TEST(SprocketPair, PullsByWhatItsPotentialLosesOnAllBodies) {
  for (const bool polygon : {true, false})
    for (const Pair& pair : pairs()) {
      SCOPED_TRACE(pair.name + (polygon ? " chain" : " belt"));
      SystemGraph graph{{.gravity = Vector3::Zero()}};
      const std::vector<Marker> markers = pair.draw(graph, {12, 9, 0});
      check_force(graph,
                  graph.add<SprocketPair>("chain", markers,
                                          {.teeth_A = 9,
                                           .teeth_B = 15,
                                           .pitch = 2,
                                           .axial_stiffness = 100,
                                           .damping = 0.5,
                                           .pretension = 40,
                                           .polygon = polygon}),
                  {.tolerance = 1e-6, .difference = 2e-5});
    }
}

}  // namespace
}  // namespace lithe::test::sprocket_pair_test
