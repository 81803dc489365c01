#include "bodies/flexible/deformation_writer.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>

#include "engine/observe/snapshot.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "joints/revolute_joint.h"
#include "tests/bodies/flexible_models.h"
#include "tests/engine/output/output_scratch_folder.h"

namespace lithe::test::deformation_writer_test {
namespace {

TEST(DeformationWriter, gives_paraview_the_moving_mesh_with_its_volume_and_its_nodes) {
  const FiniteElementModel model = pendulum_model("hex8i");
  SystemGraph graph;
  auto& rod = graph.add<FlexibleBody>("rod", {.basis = make_basis(model, HingeFrame{model.node_set("hinge")}, 9)});
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  graph.add<RevoluteJoint>(
      "hinge", {graph.ground().marker({0, 0.005, 0}, along_y), rod.average(model.node_set("hinge"), along_y)});
  const System system = assemble(graph);
  State state = system.initial_state();
  GeneralizedAlpha integrator({.step = 1e-3});
  const ScratchFolder folder;
  DeformationWriter writer(rod, folder.path("rod"));
  Simulation simulation(system, integrator);
  simulation.observe(writer, every(0.05));
  simulation.run(state, 0.1);

  // Through VTK's own reader: tests/engine/output/read_vtu.py prints points, cells, volume and sums of the fields.
  const std::string reader = LITHE_SOURCE_DIR "/tests/engine/output/read_vtu.py";
  const std::string command = "/usr/bin/python3 '" + reader + "' '" + folder.path("rod_0002.vtu") + "' 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  std::string text;
  std::array<char, 4096> part;
  while (const std::size_t size = fread(part.data(), 1, part.size(), pipe)) text.append(part.data(), size);
  ASSERT_EQ(pclose(pipe), 0) << text << "\nVTK is needed: apt-get install python3-vtk9, used by /usr/bin/python3.";
  EXPECT_NE(text.find("54 points, 16 cells, types [12]"), std::string::npos) << text;
  const double volume = std::stod(text.substr(text.find("volume ") + 7));
  EXPECT_NEAR(volume / (0.1 * 0.01 * 0.015), 1, 1e-2);  // small strain
  Snapshot now(system, state);
  const auto motion = rod.nodal_motion(now.body_state(rod), now.state().v_dot.data());
  const double sum = std::stod(text.substr(text.find("sum ", text.find("positions")) + 4));
  EXPECT_NEAR(sum, motion.position.sum(), 1e-6);  // VTK prints what it read; the file holds doubles
  EXPECT_NE(text.find("deformation: 3 components"), std::string::npos) << text;
  EXPECT_NE(text.find("velocity: 3 components"), std::string::npos) << text;
}

}  // namespace
}  // namespace lithe::test::deformation_writer_test
