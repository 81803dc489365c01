#include "bodies/beam/beam_table.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>

#include "engine/analysis/equilibrium.h"
#include "joints/fixed_joint.h"
#include "joints/forces/user_force.h"

/// Files of beams; statics against the cases of tests/data/beams/beamdyn, which README.md there explains.
namespace lithe::test::beam_table_test {
namespace {

std::string data(const std::string& name) { return std::string(LITHE_TEST_DATA) + "/beams/beamdyn/" + name; }

/// Clamped at the root; where its tip goes under a dead wrench there.
Vector3 tip_displacement(Beam::Parameters table, int elements, const Wrench& load, int steps = 1) {
  SystemGraph graph({.gravity = Vector3::Zero()});
  table.elements = elements;
  auto& beam = graph.add<Beam>("beam", table);
  const FramePose root = table.axis.pose(0);
  graph.add<FixedJoint>("clamp", {graph.ground().marker(root.position, root.axes), beam.marker(0)});
  graph.add<UserForce>("load", {beam.marker(table.axis.length)},
                       {[load](double share, const MarkerView&) { return share * load; }});
  const System system = assemble(graph);
  State state = system.initial_state();
  for (int i = 1; i <= steps; ++i) {
    state.time = static_cast<double>(i) / steps;
    state = find_equilibrium(system, state).state;
  }
  Snapshot now(system, state);
  return now.marker(beam.marker(table.axis.length)).p - table.axis.pose(table.axis.length).position;
}

/// Without the error of second order.
Vector3 extrapolated(const std::function<Vector3(int elements)>& tip, int elements) {
  return (4 * tip(2 * elements) - tip(elements)) / 3;
}

void expect_near(const std::string& what, const Vector3& found, const Vector3& expected, double tolerance) {
  if (std::getenv("LITHE_PRINT"))
    std::printf("  %s: %.9g %.9g %.9g, off by %.2g\n", what.c_str(), found[0], found[1], found[2],
                (found - expected).norm());
  EXPECT_LT((found - expected).norm(), tolerance) << what << ": " << found.transpose();
}

TEST(BeamTable, MomentRollsUpB03) {
  const Wrench moment{Vector3::Zero(), {-12.5664, 0, 0}};
  const Vector3 exact(0, 5.4986774284354, -2.4317431853411637);
  expect_near("B03", tip_displacement(beam_table(data("B01.inp")), 16, moment), exact, 1e-9);
  const Beam::Parameters blade_alone = beam_table(data("B01_blade.inp"), {.length = 10});
  expect_near("B03, blade file", tip_displacement(blade_alone, 16, moment), exact, 1e-9);
}

TEST(BeamTable, ForceBendsTheSplineOfB02) {
  const Beam::Parameters table = beam_table(data("B02.inp"));
  const auto tip = [&](int n) { return tip_displacement(table, n, {{0, 600, 0}, Vector3::Zero()}, 4); };
  const Vector3 found = extrapolated(tip, 20);
  expect_near("B02", found, {-13.46875979092156, 53.34719535419496, -23.57235653924552}, 1e-5);
  expect_near("B02, peer", found, {-13.46, 53.35, -23.58}, 0.015);
}

TEST(BeamTable, ForceBendsTheTwistedB04) {
  const Beam::Parameters table = beam_table(data("B04.inp"));
  const auto tip = [&](int n) { return tip_displacement(table, n, {{0, -4e6, 0}, Vector3::Zero()}, 4); };
  const Vector3 found = extrapolated(tip, 20);
  expect_near("B04", found, {1.7180533464648777, -3.593213240271939, -1.1415259995405016}, 1e-5);
  expect_near("B04, peer", found, {1.71810805, -3.59245231, -1.14114462}, 2e-3);
}

TEST(BeamTable, SectionsTurnFromTheAxesOfTheBlade) {
  const Beam::Parameters table = beam_table(data("B04.inp"), {.root = {.position = {1, 2, 3}}});
  EXPECT_NEAR(table.axis.length, 10, 1e-12);
  const FramePose middle = table.axis.pose(5);
  EXPECT_LT((middle.position - Vector3(1, 2, 8)).norm(), 1e-12);
  const double half = std::sqrt(0.5);
  EXPECT_LT((middle.axes.col(0) - Vector3(0, 0, 1)).norm(), 1e-12);
  EXPECT_LT((middle.axes.col(1) - Vector3(half, -half, 0)).norm(), 1e-12);
  EXPECT_LT((middle.axes.col(2) - Vector3(half, half, 0)).norm(), 1e-12);
  const BeamSection& section = table.sections.front().section;
  EXPECT_EQ(section.stiffness(0, 0), 25e9);         // axial
  EXPECT_EQ(section.stiffness(4, 4), 520833000.0);  // about x
  EXPECT_EQ(section.stiffness(5, 5), 130208333.0);  // about y
  Vector6 damping;
  damping << 0.003, 0.001, 0.002, 0.006, 0.004, 0.005;  // mu3, mu1, mu2, mu6, mu4, mu5
  EXPECT_LT((beam_table(data("B01.inp")).sections.front().section.damping - damping).norm(), 1e-15);
}

// ---- tables in columns, and what is wrong with them ----

std::string written(const std::string& text, const std::string& name = "table.csv") {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "lithe_beam_table";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / name) << text;
  return (folder / name).string();
}

const std::string kNames = "EA,GA2,GA3,GJ,EI2,EI3,mass,J1,J2,J3";
const std::string kValues = "1e4,1e4,1e4,200,100,100,1,0.02,0.01,0.01";

TEST(BeamTable, ColumnsGiveTheSameBeam) {
  const std::string path = written("# roll-up\nz," + kNames + "\n0," + kValues + "\n10," + kValues + "\n");
  expect_near("B03, csv", tip_displacement(beam_table(path), 16, {Vector3::Zero(), {-12.5664, 0, 0}}),
              {0, 5.4986774284354, -2.4317431853411637}, 1e-9);
}

TEST(BeamTable, ColumnsTakeCouplingsAndDamping) {
  const std::string path = written("arc,twist,C15,M26,M35,damping,damping4," + kNames + "\n0,0,30,0,0,0.1,0.2," +
                                   kValues + "\n4,20,10,0,0,0.1,0.2," + kValues + "\n");
  const Beam::Parameters table = beam_table(path);
  ASSERT_EQ(table.sections.size(), 2u);
  EXPECT_DOUBLE_EQ(table.sections[1].arc, 4);
  const BeamSection& first = table.sections[0].section;
  EXPECT_EQ(first.stiffness(0, 4), 30);
  EXPECT_EQ(first.stiffness(4, 0), 30);
  EXPECT_EQ(first.damping[0], 0.1);
  EXPECT_EQ(first.damping[3], 0.2);
}

template <typename E>
std::string message(const std::string& path, const BeamTablePlace& place = {}) {
  try {
    beam_table(path, place);
  } catch (const E& error) {
    return error.what();
  }
  return "no error";
}

void expect_in(const std::string& part, const std::string& text) {
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

TEST(BeamTable, BadColumnsAreNamed) {
  const std::string first = "z," + kNames + "\n0," + kValues + "\n";
  expect_in("no such file", message<FileError>("nowhere.csv"));
  expect_in("the table is empty", message<FileError>(written("")));
  expect_in("'EIx' is unknown", message<FileError>(written("z,EIx\n")));
  expect_in("C11 is missing", message<FileError>(written("z,mass\n")));
  expect_in("where its stations are", message<FileError>(written(kNames + "\n")));
  expect_in("what another has given", message<FileError>(written("z,EA,C11\n")));
  expect_in("fewer than two stations", message<FileError>(written(first)));
  expect_in("table.csv:3", message<FileError>(written(first + "10,1e4\n")));
  expect_in("not a number", message<FileError>(written(first + "ten," + kValues + "\n")));
  expect_in("station 2 has z 0.0", message<SceneError>(written(first + "0," + kValues + "\n")));
  expect_in("station 2 (", message<SceneError>(written(first + "9,1e4,1e4,1e4,-200,100,100,1,0.02,0.01,0.01\n")));
}

std::string text_of(const std::string& name) {
  std::ifstream file(data(name));
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.rfind(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(BeamTable, BadBeamDynFilesAreNamed) {
  const std::string blade = text_of("B04_blade.inp"), primary = text_of("B04.inp");
  expect_in("has no length", message<SceneError>(data("B04_blade.inp")));
  expect_in("no BeamDyn file", message<FileError>(data("README.md")));
  const auto of_blade = [&](const std::string& from, const std::string& to) {
    return written(changed(blade, from, to), "blade.inp");
  };
  const BeamTablePlace ten{.length = 10};
  expect_in("modal damping", message<FileError>(of_blade("0   damp_type", "2   damp_type"), ten));
  expect_in("station_total is 1", message<FileError>(of_blade("2   station_total", "1   station_total"), ten));
  expect_in("the file ends before", message<FileError>(of_blade("2   station_total", "3   station_total"), ten));
  expect_in("from 0.000000 to 0.9", message<FileError>(of_blade("\n1.0\n", "\n0.9\n"), ten));
  expect_in("station 2 has the place", message<SceneError>(of_blade("\n1.0\n", "\n0.0\n"), ten));
  expect_in("station 2 (", message<SceneError>(of_blade("1.302083330E+08", "-1.302083330E+08"), ten));
  const auto of_primary = [&](const std::string& from, const std::string& to) {
    return written(changed(primary, from, to), "primary.inp");
  };
  expect_in("key point 11 has z 8.0", message<SceneError>(of_primary("0  0  10  90", "0  0  8  90")));
  expect_in("not a number", message<FileError>(of_primary("0  0  10  90", "0  0  1o  90")));
  expect_in("no such file", message<FileError>(of_primary("B04_blade.inp", "none.inp")));
}

}  // namespace
}  // namespace lithe::test::beam_table_test
