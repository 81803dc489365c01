// Eight models of MSC ADAMS, read from their data sets as they are and run, beside every column of the results that
// ADAMS computed, within the bounds of the same models drawn by hand (tests/reference/adams_test.cpp).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>

#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "models/draw_model.h"
#include "models/read_model.h"
#include "tests/models/scratch_folder.h"
#include "tests/support/adams_results.h"
#include "tests/support/methods.h"

namespace lithe::test::adams_cases_test {
namespace {

using Columns = std::vector<std::string>;

std::string data(const std::string& file) { return std::string(LITHE_TEST_DATA) + "/adams/" + file; }

std::string text_of(const std::string& path) {
  std::ifstream in(path);
  std::ostringstream all;
  all << in.rdbuf();
  return all.str();
}

struct Case {
  const char *model, *results;
  Columns forces;                                              // of REQUEST/5, force then torque
  std::vector<std::pair<const char*, const char*>> changes{};  // of the text, where the results belong to another model
  bool joint_too = false;                                      // the results add the reaction of JOINT/1
};

const Columns kOfJoint = {"f2", "f3", "f4", "f6", "f7", "f8"}, kOfMarkers = {"fx", "fy", "fz", "tx", "ty", "tz"};

const Case kCases[] = {
    {"Revolute_Case02", "Revolute_Case02", kOfJoint},
    {"Spherical_Case02", "Spherical_Case02", kOfJoint},
    {"Prismatic_Case02", "Prismatic_Case02", kOfJoint},
    {"Cylindrical_Case03", "Cylindrical_Case03", kOfJoint},
    {"Universal_Case02", "Universal_Case02", kOfJoint},
    {"Distance_Case03", "Distance_Case03", kOfMarkers},
    // The results are those of other constants: c = 5; k = 200 N m/rad, c = 10 N m s/rad.
    {"TransSpring_Case01", "TranSpring_Case02", kOfJoint, {{", - 1.0*vr(204,205)", ", - 5.0*vr(204,205)"}}},
    {"RotSpring_Case01",
     "RotSpring_Case01",
     kOfJoint,
     {{"- 1.0*RTOD*(az", "- 200*(az"}, {", - 5.0E-002*RTOD*wz", ", - 10*wz"}},
     /*joint_too=*/true}};

class AdamsFile : public testing::TestWithParam<Case> {};

TEST_P(AdamsFile, GivesAllColumnsOfAdamsWithinItsDigits) {
  const Case& c = GetParam();
  const ScratchFolder folder;
  std::string text = text_of(data("test_" + std::string(c.model) + ".adm"));
  for (const auto& [from, to] : c.changes) {
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, std::string(from).size(), to);
  }
  const ModelDescription model = read_model(folder.write("model.adm", text));
  SystemGraph graph{{.gravity = model.gravity}};
  const DrawnModel drawn = draw_model(graph, model);
  std::vector<Sensor> sensors = drawn.outputs();
  if (c.joint_too) sensors.push_back(reaction(drawn.joint("JOINT/1"), 1, kWorldAxes, "more"));
  const System system = assemble(graph);
  Recorder recorder(sensors);
  const Method method = runge_kutta8(1e-12);
  Simulation simulation(system, *method);
  simulation.observe(recorder, every(0.01));
  State state = system.initial_state();
  simulation.run(state, 5);

  const Table& table = recorder.table();
  const auto column = [&](const std::string& name) {
    const auto found = std::find(table.columns.begin(), table.columns.end(), name);
    EXPECT_NE(found, table.columns.end()) << name;
    return static_cast<int>(found - table.columns.begin());
  };
  const std::array<Columns, 8> names = {Columns{"1_x", "1_y", "1_z"},
                                        {"2_x", "2_y", "2_z"},
                                        {"3_x", "3_y", "3_z"},
                                        {"4_f2", "4_f3", "4_f4", "4_f6"},
                                        {"2_wx", "2_wy", "2_wz"},
                                        {"3_wdx", "3_wdy", "3_wdz"},
                                        {"5_" + c.forces[0], "5_" + c.forces[1], "5_" + c.forces[2]},
                                        {"5_" + c.forces[3], "5_" + c.forces[4], "5_" + c.forces[5]}};
  std::array<std::vector<AddedColumns>, 8> columns;
  for (std::size_t k = 0; k < columns.size(); ++k)
    for (std::size_t i = 0; i < names[k].size(); ++i) {
      AddedColumns& sum = columns[k].emplace_back(1, column("REQUEST/" + names[k][i]));
      if (c.joint_too && k >= 6) sum.push_back(column(std::string(k == 6 ? "more_force_" : "more_moment_") + "xyz"[i]));
    }
  expect_adams_results(c.results, table, columns);
}

INSTANTIATE_TEST_SUITE_P(Cases, AdamsFile, testing::ValuesIn(kCases),
                         [](const auto& c) { return std::string(c.param.model); });

TEST(AdamsFileAsItIs, SaysWhatItHoldsAndWhatDoesNotAct) {
  const ModelDescription model = read_model(data("test_RotSpring_Case01.adm"));
  EXPECT_EQ(model.name, "test_Revolute_Case01");
  EXPECT_EQ(model.format, "Adams data set");
  EXPECT_DOUBLE_EQ(model.gravity.z(), -9.80665);
  EXPECT_FALSE(model.tolerance || model.duration);
  const std::string sheet = model.sheet(), table = model.table();
  for (const char* words :
       {"2 links", "1 REVOLUTE", "1 SFORCE, rotational", "GRAPHICS: pictures", "OUTPUT", "line 37, 5 times"})
    EXPECT_NE(sheet.find(words), std::string::npos) << words << "\n" << sheet;
  for (const char* words : {"PART/2", "JOINT/1", "REVOLUTE", "PART/2 - PART/1"})
    EXPECT_NE(table.find(words), std::string::npos) << words << "\n" << table;
  // 1.0*RTOD is 57.3 N m/rad: the torque of the spring turned by AZ.
  SystemGraph graph{{.gravity = model.gravity}};
  const DrawnModel drawn = draw_model(graph, model);
  EXPECT_EQ(assemble(graph).degrees_of_freedom(), 1);
  EXPECT_EQ(drawn.outputs().size(), 5U + 3U);  // REQUESTs, VARIABLEs
  EXPECT_THROW(drawn.adams_marker(7), SceneError);
  EXPECT_EQ(drawn.adams_marker(202).body, static_cast<const Body*>(drawn.body("PART/2")));
}

}  // namespace
}  // namespace lithe::test::adams_cases_test
