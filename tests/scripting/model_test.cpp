#include <gtest/gtest.h>

#include "engine/observe/recorder.h"
#include "engine/output/csv.h"
#include "engine/run/simulation.h"
#include "integrators/automatic.h"
#include "models/draw_model.h"
#include "models/read_model.h"
#include "tests/scripting/command.h"

namespace lithe::test {
namespace {

bool says(const Outcome& outcome, const std::string& words) { return outcome.output.find(words) != std::string::npos; }

TEST(Model, ARobotIsInspectedAndMoves) {
  ScriptFolder folder;
  const std::string robots = std::string(LITHE_TEST_DATA) + "/robots/";
  const Outcome sheet = folder.shell("lithe model inspect " + robots + "panda.urdf");
  EXPECT_EQ(sheet.exit_code, 0) << sheet.output;
  EXPECT_TRUE(says(sheet, "Model 'panda' (URDF)") && says(sheet, "limits do not act")) << sheet.output;
  const Outcome run = folder.shell("lithe model run " + robots +
                                   "iiwa.urdf --duration 0.2 --set lbr_iiwa_joint_2=0.5 -o pages/iiwa.html");
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_TRUE(says(run, "iiwa: 7 freedoms, 0.2 s")) << run.output;
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "pages/iiwa.html"));
  folder.write("wrong.urdf", "<robot name='r'>\n<link/></robot>");
  const Outcome wrong = folder.shell("lithe model run wrong.urdf");
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_TRUE(says(wrong, "wrong.urdf:2") && says(wrong, "<link> has no name")) << wrong.output;
  EXPECT_TRUE(says(folder.shell("lithe model run " + robots + "iiwa.urdf --set elbow"), "is not joint=value"));
  EXPECT_TRUE(says(folder.shell("lithe model run " + robots + "iiwa.urdf --set elbow=1"), "no joint 'elbow'"));
}

TEST(Model, AnAdamsModelIsOpenedAndRunByOneCommand) {
  ScriptFolder folder;
  const Outcome run = folder.shell("lithe model run " + std::string(LITHE_EXAMPLE_DATA) + "/slider_crank.adm --table");
  EXPECT_EQ(run.exit_code, 0) << run.output;
  for (const char* words : {"Model 'slider_crank' (Adams data set)", "PART/4", "HOOKE", "0 freedoms, 2 s",
                            "0 0 -9.80665", "tolerance 1e-05", "the method of INTEGRATOR"})
    EXPECT_TRUE(says(run, words)) << words << "\n" << run.output;
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "results/slider_crank.html"));
  const Outcome sheet =
      folder.shell("lithe model inspect " + std::string(LITHE_TEST_DATA) + "/robots/four_bar.sdf --table");
  EXPECT_EQ(sheet.exit_code, 0) << sheet.output;
  EXPECT_TRUE(says(sheet, "degrees of freedom: 1") && says(sheet, "closes a loop")) << sheet.output;
  // A name that is a path stays within results/.
  folder.write(
      "climb.urdf",
      "<robot name='../../climbed'><link name='a'/><link name='b'><inertial><mass value='1'/><inertia ixx='1' iyy='1' "
      "izz='1'/></inertial></link><joint name='j' type='continuous'><parent link='a'/><child "
      "link='b'/></joint></robot>");
  const Outcome climb = folder.shell("lithe model run climb.urdf --duration 0.1");
  EXPECT_EQ(climb.exit_code, 0) << climb.output;
  EXPECT_TRUE(says(climb, "page: results/_._.._climbed.html")) << climb.output;
  EXPECT_FALSE(std::filesystem::exists(folder.path().parent_path() / "climbed.html"));
  folder.write("cut.adm", "title\nUNITS/FORCE=NEWTON\n");
  const Outcome cut = folder.shell("lithe model inspect cut.adm");
  EXPECT_EQ(cut.exit_code, 1);
  EXPECT_TRUE(says(cut, "cut.adm:2") && says(cut, "without END")) << cut.output;
}

/// A written scene, compiled and run, moves as the model that was read: of MJCF with rotors, dampers and a follower.
TEST(Model, AWrittenSceneRunsAlike) {
  ScriptFolder folder;
  const std::string panda = std::string(LITHE_TEST_DATA) + "/robots/panda.mjcf.xml";
  const Outcome write = folder.shell("lithe model inspect " + panda + " --set joint2=0.4 --write scene.cpp");
  ASSERT_EQ(write.exit_code, 0) << write.output;
  const Outcome run = folder.shell("lithe run scene.cpp");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const Table written = read_csv((folder.path() / "results/panda.csv").string());

  const ModelDescription model = read_model(panda);
  SystemGraph graph{{.gravity = model.gravity}};
  const DrawnModel drawn = draw_model(graph, model, {.positions = {{"joint2", 0.4}}});
  const System system = assemble(graph);
  std::vector<Sensor> sensors;
  for (std::size_t c = 1; c < written.columns.size(); ++c)
    sensors.push_back(coordinate(drawn.coordinate(written.columns[c]), written.columns[c]));
  ASSERT_EQ(sensors.size(), 9U);
  Recorder recorder(sensors);
  Automatic integrator{{.tolerance = {.relative = 1e-6, .absolute = 1e-8}}};
  Simulation simulation(system, integrator);
  simulation.observe(recorder, every(0.02));
  State state = system.initial_state();
  simulation.run(state, 2);
  ASSERT_EQ(recorder.table().row_count(), written.row_count());
  double largest = 0, moved = 0;
  for (int row = 0; row < written.row_count(); ++row)
    for (int c = 1; c <= 9; ++c) {
      largest = std::max(largest, std::abs(written.at(row, c) - recorder.table().at(row, c)));
      moved = std::max(moved, std::abs(written.at(row, c) - written.at(0, c)));
    }
  EXPECT_GT(moved, 0.3);
  EXPECT_LT(largest, 1e-5) << "both are within the tolerance of 1e-6";
  // What acts by functions is refused, with its line.
  const Outcome adams =
      folder.shell("lithe model inspect " + std::string(LITHE_EXAMPLE_DATA) + "/slider_crank.adm --write no.cpp");
  EXPECT_EQ(adams.exit_code, 1);
  EXPECT_TRUE(says(adams, "slider_crank.adm:") && says(adams, "not written as C++")) << adams.output;
}

}  // namespace
}  // namespace lithe::test
