#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdio.h>

#include <array>

#include "engine/base/error.h"
#include "engine/output/vtu.h"
#include "tests/engine/output/output_scratch_folder.h"

namespace lithe::test::output_vtu_test {

using lithe::FileError;
using lithe::Matrix3X;
using lithe::MatrixX;
using lithe::PvdSeries;
using lithe::SceneError;
using lithe::VtuCells;
using lithe::VtuField;
using lithe::write_vtu;
using lithe::test::file_text;
using lithe::test::message_of;
using lithe::test::ScratchFolder;
using testing::HasSubstr;

namespace {

// What VTK's own reader finds in a file; see read_vtu.py. A missing VTK fails the test, with the package to install.
std::string read_by_vtk(const std::string& path) {
  const std::string reader = LITHE_SOURCE_DIR "/tests/engine/output/read_vtu.py";
  const std::string command = "/usr/bin/python3 '" + reader + "' '" + path + "' 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  std::string text;
  std::array<char, 4096> part;
  while (const std::size_t size = fread(part.data(), 1, part.size(), pipe)) text.append(part.data(), size);
  EXPECT_EQ(pclose(pipe), 0) << command << "\n"
                             << text << "\nVTK is needed: apt-get install python3-vtk9, used by /usr/bin/python3.";
  return text;
}

// An array as read_vtu.py prints it. The values are halves and quarters, so that sums are exact in both languages.
std::string described(const std::string& name, const MatrixX& values) {
  std::ostringstream text;
  text << name << ": " << values.rows() << " components, sum " << values.sum() << ", weighted "
       << values.reshaped().dot(Eigen::VectorXd::LinSpaced(values.size(), 1, static_cast<double>(values.size())))
       << "\n";
  return text.str();
}

// The unit cube's corners in the order of C3D8: bottom face counter-clockwise seen from above, then the top face.
Matrix3X cube_corners() {
  Matrix3X corners(3, 8);
  corners << 0, 1, 1, 0, 0, 1, 1, 0,  //
      0, 0, 1, 1, 0, 0, 1, 1,         //
      0, 0, 0, 0, 1, 1, 1, 1;
  return corners;
}

// Corners, and after them a node in the middle of each edge.
Matrix3X with_middle_nodes(const Matrix3X& corners, const std::vector<std::pair<int, int>>& edges) {
  Matrix3X nodes(3, corners.cols() + static_cast<int>(edges.size()));
  nodes.leftCols(corners.cols()) = corners;
  for (std::size_t i = 0; i < edges.size(); ++i)
    nodes.col(corners.cols() + static_cast<int>(i)) = (corners.col(edges[i].first) + corners.col(edges[i].second)) / 2;
  return nodes;
}

std::vector<int> counted(int n) {
  std::vector<int> indices;
  for (int i = 0; i < n; ++i) indices.push_back(i);
  return indices;
}

}  // namespace

TEST(output_vtu, vtk_reads_a_series_of_two_hexahedra_with_its_fields) {
  const ScratchFolder folder;
  // Two unit cubes side by side along x share four of their twelve points.
  Matrix3X points(3, 12);
  for (int i = 0; i < 12; ++i) points.col(i) << i % 3, i / 3 % 2, i / 6;
  const std::vector<VtuCells> cells = {{"C3D8I", {{0, 1, 4, 3, 6, 7, 10, 9}, {1, 2, 5, 4, 7, 8, 11, 10}}}};
  MatrixX temperature = MatrixX::Constant(1, 12, 0.5), stress = MatrixX::Constant(6, 12, -0.25);
  stress(5, 11) = 1;

  PvdSeries series(folder.path("beams/beam"));
  const std::string times[] = {"0", "0.25", "0.5"};
  std::string expected;
  for (int frame = 0; frame < 3; ++frame) {
    const Matrix3X displacement = Matrix3X::Constant(3, 12, frame);
    series.add(0.25 * frame, points + displacement, cells,
               {{"displacement", displacement}, {"temperature <T & \"co\">", temperature}, {"stress", stress}});
    EXPECT_EQ(series.frame_count(), frame + 1);
    expected += "t = " + times[frame] + ", beam_000" + std::to_string(frame) + ".vtu\n" +
                "12 points, 2 cells, types [12], volume 2, middle nodes off by 0\n" +
                described("positions", points + displacement) + described("displacement", displacement) +
                described("temperature <T & \"co\">", temperature) + described("stress", stress);
  }

  EXPECT_EQ(read_by_vtk(folder.path("beams/beam.pvd")), expected);
  EXPECT_EQ(folder.file_count(), 4);
}

TEST(output_vtu, every_element_type_keeps_its_volume_and_its_middle_nodes) {
  const ScratchFolder folder;
  const Matrix3X cube = cube_corners();
  Matrix3X wedge(3, 6), tetrahedron(3, 4);
  wedge << cube.col(0), cube.col(1), cube.col(3), cube.col(4), cube.col(5), cube.col(7);
  tetrahedron << cube.col(0), cube.col(1), cube.col(3), cube.col(4);
  // The edges on which the manuals of CalculiX and Abaqus place nodes 9 to 20 and 5 to 10, counted from 0.
  const Matrix3X cube20 = with_middle_nodes(
      cube, {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}});
  const Matrix3X tetrahedron10 = with_middle_nodes(tetrahedron, {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}});

  const auto found = [&](const std::string& type, const Matrix3X& nodes) {
    write_vtu(folder.path("one.vtu"), nodes, {{type, {counted(static_cast<int>(nodes.cols()))}}}, {});
    return read_by_vtk(folder.path("one.vtu"));
  };
  for (const std::string type : {"C3D8", "C3D8I", "C3D8R"})
    EXPECT_THAT(found(type, cube), HasSubstr("types [12], volume 1, "));
  EXPECT_THAT(found("C3D4", tetrahedron), HasSubstr("types [10], volume 0.166666667, "));
  EXPECT_THAT(found("C3D6", wedge), HasSubstr("types [13], volume 0.5, "));
  for (const std::string type : {"C3D20", "C3D20R"})
    EXPECT_THAT(found(type, cube20), HasSubstr("types [25], volume 1, middle nodes off by 0\n"));
  EXPECT_THAT(found("C3D10", tetrahedron10), HasSubstr("types [24], volume 0.166666667, middle nodes off by 0\n"));
}

TEST(output_vtu, a_mesh_may_mix_element_types) {
  const ScratchFolder folder;
  Matrix3X points(3, 10);
  points.leftCols(8) = cube_corners();
  points.col(8) << 2, 0, 0;
  points.col(9) << 2, 0, 1;
  write_vtu(folder.path("mixed.vtu"), points, {{"C3D8", {counted(8)}}, {"C3D6", {{1, 8, 2, 5, 9, 6}}}}, {});
  EXPECT_THAT(read_by_vtk(folder.path("mixed.vtu")), HasSubstr("10 points, 2 cells, types [12, 13], volume 1.5, "));
}

TEST(output_vtu, points_without_cells_become_vertices) {
  const ScratchFolder folder;
  // One to three bytes of cell types end base64 in each of its three ways.
  for (int n = 1; n <= 3; ++n) {
    const std::string path = folder.path("points.vtu"), count = std::to_string(n);
    write_vtu(path, Matrix3X::Constant(3, n, 0.1), {}, {{"mass", MatrixX::Constant(1, n, 2)}});
    const std::string found = read_by_vtk(path);
    EXPECT_THAT(found, HasSubstr(count + " points, " + count + " cells, types [1], "));
    EXPECT_THAT(found, HasSubstr("mass: 1 components, sum " + std::to_string(2 * n)));
  }
}

TEST(output_vtu, a_mesh_that_does_not_fit_is_refused_before_anything_is_written) {
  const ScratchFolder folder;
  const auto message = [&](const std::vector<VtuCells>& cells, const std::vector<VtuField>& fields) {
    return message_of<SceneError>([&] { write_vtu(folder.path("bad.vtu"), cube_corners(), cells, fields); });
  };
  EXPECT_THAT(message({{"S4", {{0, 1, 2, 3}}}}, {}), testing::AllOf(HasSubstr("'S4'"), HasSubstr("C3D20")));
  EXPECT_THAT(message({{"C3D8", {counted(7)}}}, {}), HasSubstr("has 7 nodes"));
  EXPECT_THAT(message({{"C3D4", {{5, 6, 7, 8}}}}, {}), HasSubstr("names point 8"));
  EXPECT_THAT(message({{"C3D4", {{-1, 6, 7, 5}}}}, {}), HasSubstr("names point -1"));
  EXPECT_THAT(message({}, {{"speed", MatrixX::Zero(8, 3)}}), HasSubstr("'speed' is 8 x 3"));
  EXPECT_EQ(folder.file_count(), 0);
}

TEST(output_vtu, a_series_tells_its_frames_after_each_of_them_and_refuses_to_go_back_in_time) {
  const ScratchFolder folder;
  const std::string path = folder.path("run.pvd");
  PvdSeries series(folder.path("run"));
  series.add(0, cube_corners(), {}, {});
  EXPECT_THAT(read_by_vtk(path), HasSubstr("t = 0, run_0000.vtu\n8 points"));
  series.add(0.5, cube_corners(), {}, {});
  EXPECT_THAT(read_by_vtk(path), HasSubstr("t = 0.5, run_0001.vtu\n8 points"));

  const std::string before = file_text(path);
  EXPECT_THAT(message_of<SceneError>([&] { series.add(0.5, cube_corners(), {}, {}); }), HasSubstr("run.pvd"));
  EXPECT_EQ(file_text(path), before);
  EXPECT_EQ(folder.file_count(), 3);

  PvdSeries unwritable(folder.path("run.pvd/nowhere"));
  EXPECT_THROW(unwritable.add(0, cube_corners(), {}, {}), FileError);
  EXPECT_EQ(unwritable.frame_count(), 0);
}

}  // namespace lithe::test::output_vtu_test
