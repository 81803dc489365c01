#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/base/rotations.h"
#include "engine/model/world_placement.h"
#include "engine/page/page.h"
#include "engine/run/simulation.h"
#include "integrators/radau.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/revolute_joint.h"
#include "joints/rope/rope.h"
#include "tests/engine/page/page_reader.h"

/// Ropes on pages: as lines that lie on their wheels.
namespace lithe::test::rope_page_test {
namespace {

using namespace page;

constexpr int kArc = 13;  // points of an arc

/// A drum winds up a rope over a pulley; a load hangs from it. With mass or without.
struct Hoist {
  const Vector3 drum_at{0, 0, 0}, pulley_at{3, 0, 6};
  const double drum_radius = 0.3, pulley_radius = 0.25;
  SystemGraph graph;

  explicit Hoist(double mass_per_length) {
    const Matrix3 axle = rotation_about({1, 0, 0}, M_PI / 2);
    auto& ground = graph.ground();
    auto& drum = graph.add<RigidBody>("drum", {.mass = 10, .inertia = {1, 1, 1}});
    auto& load = graph.add<RigidBody>("load", {.mass = 100, .inertia = {8, 8, 8}, .position = {3.25, 0, 2}});
    auto& pin = graph.add<RevoluteJoint>("pin", at_world(ground, drum, {.axis = {0, -1, 0}}));
    graph.add<CoordinateDrive>("drive", {pin.angle()}, {.motion = smooth_step(0, 8, 0, 1)});
    reeve(graph, "rope", {{pin.markers()[1], drum_radius, -1}, {load.marker({0, 0, 0.5})}},
          {.pulleys = {{ground.marker(pulley_at, axle), pulley_radius, -1}},
           .axial_stiffness = 5e5,
           .axial_damping = 1e4,
           .mass_per_length = mass_per_length,
           .pretension = 981});
  }
};

/// Points on the rim, the straight part tangent to it at `rim`; m.
void expect_on_wheel(const Matrix3X& arc, const Vector3& centre, double radius, const Vector3& rim,
                     const Vector3& beyond) {
  for (Eigen::Index i = 0; i < arc.cols(); ++i) EXPECT_NEAR((arc.col(i) - centre).norm(), radius, 1e-6);
  EXPECT_NEAR((rim - centre).dot((beyond - rim).normalized()), 0, 1e-6);
}

TEST(RopePage, LinesLieOnTheirWheels) {
  const ScratchFolder folder;
  for (const double mass : {0.0, 0.5}) {
    Hoist hoist(mass);
    const System system = assemble(hoist.graph);
    State state = system.initial_state();
    Radau radau({.tolerance = {1e-6, 1e-8}});
    Simulation simulation(system, radau);
    lithe::Run run{system};
    simulation.observe(run, every(0.25));
    simulation.run(state, 1);
    write_page(run, folder.path("hoist.html"));
    const Page page(folder.path("hoist.html"));

    const MatrixX load = page.array(page.body("load")["position"], 3);
    ASSERT_EQ(load.cols(), 5);
    EXPECT_GT(load(2, 4) - load(2, 0), 2);
    for (int frame = 0; frame < 5; ++frame) {
      // The drum's arc, the pulley's in two halves, the end.
      Matrix3X line(3, 3 * kArc + 1);
      if (mass == 0) {
        line = page.array(page.connector("rope")["line"], line.size()).col(frame).reshaped(3, line.cols());
      } else {
        const VectorX first = page.array(page.connector("rope span 1")["line"], 6 * kArc).col(frame),
                      second = page.array(page.connector("rope span 2")["line"], 3 * kArc + 3).col(frame);
        line << first.reshaped(3, 2 * kArc), second.reshaped(3, kArc + 1);
      }
      expect_on_wheel(line.leftCols(kArc), hoist.drum_at, hoist.drum_radius, line.col(kArc - 1), line.col(kArc));
      const Matrix3X over = line.middleCols(kArc, 2 * kArc);
      expect_on_wheel(over, hoist.pulley_at, hoist.pulley_radius, over.col(0), line.col(kArc - 1));
      expect_on_wheel(over, hoist.pulley_at, hoist.pulley_radius, over.col(2 * kArc - 1), line.rightCols<1>());
      EXPECT_LT((over.col(kArc) - over.col(kArc - 1)).norm(), 1e-6) << "in one piece";
      EXPECT_GT(over.row(2).maxCoeff(), 6.24) << "over the pulley, not under it";
      const Vector3 end = load.col(frame) + Vector3(0, 0, 0.5);
      EXPECT_LT((line.rightCols<1>() - end).norm(), 0.05) << "it hardly turns";
    }
    // Wheels are discs; the drum has its own shape too.
    const auto count = [&](const char* body, const char* role) {
      int found = 0;
      for (const Json& shape : page.body(body)["shapes"]) found += shape["role"] == role;
      return found;
    };
    for (const Json& body : page.scene["runs"][0]["bodies"])  // what is nowhere is not drawn
      EXPECT_TRUE(body["name"].get<std::string>().rfind("rope travel", 0) != 0 || body["shapes"].empty())
          << body["name"];
    EXPECT_EQ(count("drum", "visual"), 1);
    EXPECT_GE(count("drum", "inferred"), 1);
    const std::string ground = page.scene["runs"][0]["bodies"][0]["name"];
    EXPECT_EQ(count(ground.c_str(), "visual"), 1);
    EXPECT_NEAR(page.body("drum")["shapes"][0]["size"][0].get<double>(), hoist.drum_radius, 1e-12);
  }
}

}  // namespace
}  // namespace lithe::test::rope_page_test
