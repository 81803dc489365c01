#include "bodies/surface_writer.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <sstream>

#include "bodies/beam/beam_model.h"
#include "bodies/cable/cable.h"
#include "bodies/flexible/deformation_writer.h"
#include "bodies/rigid_body.h"
#include "engine/base/error.h"
#include "engine/observe/snapshot.h"
#include "tests/engine/output/output_scratch_folder.h"

namespace lithe::test::surface_writer_test {
namespace {

/// What VTK's own reader finds in a file.
std::string read(const std::string& path) {
  const std::string command =
      "/usr/bin/python3 '" LITHE_SOURCE_DIR "/tests/engine/output/read_vtu.py' '" + path + "' 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  std::string text;
  std::array<char, 4096> part;
  while (const std::size_t size = fread(part.data(), 1, part.size(), pipe)) text.append(part.data(), size);
  EXPECT_EQ(pclose(pipe), 0) << text << "\nVTK is needed: apt-get install python3-vtk9, used by /usr/bin/python3.";
  return text;
}

BeamSection section() { return BeamSection::rectangle(0.02, 0.01, {2.1e11, 0.3, 7850}); }
Beam::Parameters line(int elements) {
  return {
      .axis = BeamAxis::straight({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), .sections = {{0, section()}}, .elements = elements};
}

TEST(SurfaceWriter, GivesParaviewABeamWithItsForces) {
  SystemGraph graph;
  auto& beam = graph.add<Beam>("beam", line(4));
  const System system = assemble(graph);
  State state = system.initial_state();
  // Stretched by 1 % along x: n_1 = EA / 100, nothing else.
  for (int i = 0; i < 5; ++i) state.q[7 * i] *= 1.01;
  const ScratchFolder folder;
  SurfaceWriter writer(beam, folder.path("beam"), section_fields(beam));
  Snapshot now(system, system.initial_state());
  writer.observe(now);
  state.time = 0.5;
  now.evaluate(state);
  writer.observe(now);

  // 5 nodes and 13 rings of 4; 12 x 8 triangles round it and 2 on each end.
  const std::string text = read(folder.path("beam_0001.vtu"));
  EXPECT_NE(text.find("57 points, 100 cells, types [5]"), std::string::npos) << text;
  const auto sum = [&](const std::string& field) {
    const std::size_t at = text.find(field + ": 3 components");
    EXPECT_NE(at, std::string::npos) << text;
    return std::stod(text.substr(text.find("sum ", at) + 4));
  };
  EXPECT_NEAR(sum("force") / (57 * 0.01 * section().stiffness(0, 0)), 1, 1e-5);
  EXPECT_NEAR(sum("strain"), 57 * 0.01, 1e-5);
  EXPECT_NEAR(sum("curvature"), 0, 1e-9);
  EXPECT_NEAR(sum("displacement"), 0.01 * (2.5 + 4 * 6.5), 1e-5);
  const std::string series = read(folder.path("beam.pvd"));
  EXPECT_NE(series.find("0.5"), std::string::npos) << series;
}

TEST(SurfaceWriter, GivesParaviewACable) {
  SystemGraph graph;
  auto& cable = graph.add<Cable>(
      "cable", {.points = {{0, 0, 0}, {1, 0, 0}}, .elements = 3, .mass_per_length = 1, .axial_stiffness = 1e5});
  const System system = assemble(graph);
  const ScratchFolder folder;
  SurfaceWriter writer(cable, folder.path("cable"));
  Snapshot now(system, system.initial_state());
  writer.observe(now);
  const std::string text = read(folder.path("cable_0000.vtu"));
  EXPECT_NE(text.find("28 points, 44 cells, types [5]"), std::string::npos) << text;
}

TEST(SurfaceWriter, RefusesABodyWithoutOne) {
  SystemGraph graph;
  auto& body = graph.add<RigidBody>("stone", RigidBody::Parameters{});
  EXPECT_THROW(SurfaceWriter(body, "stone"), SceneError);
}

/// A beam reduced to modes is lines.
TEST(DeformationWriter, GivesParaviewAModalBeam) {
  SystemGraph graph;
  const Beam beam(line(4));
  auto& body = graph.add<FlexibleBody>("beam", {.basis = make_basis(beam, TangentFrame{{1}}, 4)});
  const System system = assemble(graph);
  const ScratchFolder folder;
  DeformationWriter writer(body, folder.path("modal"));
  Snapshot now(system, system.initial_state());
  writer.observe(now);
  const std::string text = read(folder.path("modal_0000.vtu"));
  EXPECT_NE(text.find("5 points, 4 cells, types [3]"), std::string::npos) << text;
}

}  // namespace
}  // namespace lithe::test::surface_writer_test
