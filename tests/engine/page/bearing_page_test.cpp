#include <gtest/gtest.h>

#include "bodies/beam/beam.h"
#include "bodies/rigid_body.h"
#include "engine/page/page.h"
#include "engine/run/simulation.h"
#include "integrators/radau.h"
#include "joints/bearings/ball_bearing.h"
#include "joints/bearings/journal_bearing.h"
#include "joints/fixed_joint.h"
#include "tests/engine/page/page_reader.h"

/// Bearings on pages, as rings; and a shaft that deforms less than a page shows.
namespace lithe::test::bearing_page_test {
namespace {

using namespace page;

TEST(BearingPage, ShowsRingsAndAShaftThatHardlyDeforms) {
  const ScratchFolder folder;
  SystemGraph graph;
  const BeamAxis axis = BeamAxis::straight({0, 0, 0}, {0, 0, 0.3}, {1, 0, 0});
  const Matrix3 upright = axis.pose(0).axes.transpose();
  auto& shaft = graph.add<Beam>(
      "shaft", {.axis = axis, .sections = {{0, BeamSection::circle(0.02, {2.1e11, 0.3, 7850})}}, .elements = 3});
  auto& hub = graph.add<RigidBody>("hub", {});
  graph.add<FixedJoint>("fit", {shaft.marker(0, {}, upright), hub.marker()});
  graph.add<JournalBearing>("film", {hub.marker(), graph.ground().marker()},
                            {.radius = 0.02, .length = 0.02, .clearance = 5e-5, .viscosity = 0.02});
  graph.add<BallBearing>("balls", {shaft.marker(0.3, {}, upright), graph.ground().marker({0, 0, 0.3})},
                         {.balls = 9,
                          .ball_diameter = 8e-3,
                          .pitch_diameter = 50e-3,
                          .inner_groove_radius = 4.2e-3,
                          .outer_groove_radius = 4.2e-3});
  const System system = assemble(graph);
  State state = system.initial_state();
  Radau radau({.tolerance = {1e-6, 1e-8}});
  Simulation simulation(system, radau);
  lithe::Run run{system};
  simulation.observe(run, every(5e-4));
  simulation.run(state, 1e-3);
  write_page(run, folder.path("shaft.html"));

  const Page page(folder.path("shaft.html"));
  EXPECT_TRUE(page.body("shaft")["mesh"]["modes"].empty());
  const Matrix3X points = page.mesh_points(page.body("shaft"), 2);
  EXPECT_NEAR(points.row(2).maxCoeff(), 0.3, 1e-4);
  EXPECT_NEAR(points.row(2).minCoeff(), 0, 1e-4);
  int rings = 0;  // the bush and the outer ring
  for (const Json& shape : page.scene["runs"][0]["bodies"][0]["shapes"]) rings += shape["kind"] == "mesh";
  EXPECT_EQ(rings, 2);
  EXPECT_NEAR(page.body("hub")["shapes"][0]["size"][0].get<double>(), 0.02 - 5e-5, 1e-12);
}

}  // namespace
}  // namespace lithe::test::bearing_page_test
