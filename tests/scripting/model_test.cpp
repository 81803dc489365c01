#include <gtest/gtest.h>

#include <map>

#include "engine/observe/recorder.h"
#include "engine/output/csv.h"
#include "engine/run/simulation.h"
#include "integrators/automatic.h"
#include "models/draw_model.h"
#include "models/read_model.h"
#include "tests/scripting/command.h"

namespace lithe::test::model_test {
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

/// A model's written scene, compiled and run, moves as the model that was read: all columns of its table, which are
/// coordinates of joints.
void expect_runs_alike(const ScriptFolder& folder, const std::string& path,
                       const std::map<std::string, double>& positions, std::size_t columns) {
  std::string set;
  for (const auto& [joint, value] : positions) set += " --set " + joint + "=" + std::to_string(value);
  const Outcome write = folder.shell("lithe model inspect " + path + set + " --write scene.cpp");
  ASSERT_EQ(write.exit_code, 0) << write.output;
  const Outcome run = folder.shell("lithe run scene.cpp");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const ModelDescription model = read_model(path);
  const Table written = read_csv((folder.path() / "results" / (model.name + ".csv")).string());

  SystemGraph graph{{.gravity = model.gravity}};
  const DrawnModel drawn = draw_model(graph, model, {.positions = positions});
  const System system = assemble(graph);
  std::vector<Sensor> sensors;
  for (std::size_t c = 1; c < written.columns.size(); ++c)
    sensors.push_back(coordinate(drawn.coordinate(written.columns[c]), written.columns[c]));
  ASSERT_EQ(sensors.size(), columns);
  Recorder recorder(sensors);
  const double tolerance = model.tolerance.value_or(1e-6), duration = model.duration.value_or(2);
  Automatic integrator{{.tolerance = {.relative = tolerance, .absolute = 0.01 * tolerance}}};
  Simulation simulation(system, integrator);
  simulation.observe(recorder, every(model.every.value_or(0.01 * duration)));
  State state = system.initial_state();
  simulation.run(state, duration);
  ASSERT_EQ(recorder.table().row_count(), written.row_count());
  double largest = 0, moved = 0;
  for (int row = 0; row < written.row_count(); ++row)
    for (int c = 1; c <= static_cast<int>(columns); ++c) {
      largest = std::max(largest, std::abs(written.at(row, c) - recorder.table().at(row, c)));
      moved = std::max(moved, std::abs(written.at(row, c) - written.at(0, c)));
    }
  EXPECT_GT(moved, 0.3);
  EXPECT_LT(largest, 10 * tolerance) << "both are within the tolerance";
}

/// Of MJCF with rotors, dampers and a follower.
TEST(Model, AWrittenSceneRunsAlike) {
  expect_runs_alike(ScriptFolder{}, std::string(LITHE_TEST_DATA) + "/robots/panda.mjcf.xml", {{"joint2", 0.4}}, 9);
}

/// Of Adams, with a motion, loads, a bushing and a constraint by functions, in millimetres.
TEST(Model, AWrittenAdamsSceneRunsAlike) {
  const ScriptFolder folder;
  folder.write("machine.adm", R"(machine
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/10, PART=1
MARKER/11, PART=1, QP=0,300,0
MARKER/12, PART=1, QP=0,0,500
MARKER/13, PART=1, QP=0,700,0
PART/2, MASS=2, CM=20, IP=2E4,2E4,2E4
MARKER/20, PART=2, QP=100,0,0
MARKER/21, PART=2
PART/3, MASS=1, CM=30, IP=1E4,2E4,1E4
MARKER/30, PART=3, QP=100,300,0
MARKER/31, PART=3, QP=0,300,0
PART/4, MASS=3, CM=40, IP=1E4,1E4,1E4
MARKER/40, PART=4, QP=0,0,500
PART/5, MASS=1, CM=50, IP=1E4,1E4,1E4
MARKER/50, PART=5, QP=0,700,0
JOINT/1, REVOLUTE, I=21, J=10
JOINT/2, REVOLUTE, I=31, J=11
JOINT/5, TRANSLATIONAL, I=50, J=13
MOTION/1, JOINT=1, FUNCTION=STEP(TIME, 0, 0, 0.5, 40D) - 0.1*SIN(-3*TIME)**2
SFORCE/1, I=30, J=20, TRANSLATIONAL, FUNCTION=VARVAL(1)*(300 - DM(30,20)) - 0.05*VR(30,20)
VARIABLE/1, FUNCTION=IF(TIME-0.2: 0.02, 0.03, 0.05/2*2)
SFORCE/2, I=31, J=11, ROTATIONAL, FUNCTION=-(200*AZ(31,11) + 20*WZ(31,11,11))
BUSHING/1, I=40, J=12, K=2,3,4, C=0.01,0.01,0.01, KT=5E4,5E4,5E4, CT=500,500,500
GFORCE/1, I=40, JFLOAT=14, RM=12, FX=2*SIN(5*TIME), FZ=MAX(0, 10-DZ(40,12,12)), TY=300*TIME
MARKER/14, PART=1, FLOATING
GCON/1, FUNCTION=DZ(50,13,13) - 20*AZ(31,11)
ACCGRAV/JGRAV=-9806.65
SIMULATE/TRANSIENT, END=1, STEPS=50
INTEGRATOR/ERROR=1E-7
END
)");
  expect_runs_alike(folder, (folder.path() / "machine.adm").string(), {}, 3);
  // Its text says what acts.
  const Outcome text = folder.shell("cat scene.cpp");
  for (const char* words :
       {"AdamsModel::Motion{.i = 21, .j = 10, .rotation = true", "-0.05*VR(30, 20, 0)",
        "AdamsModel::Load::Kind::components", "adams.add(\"GCON/1\"", "IF(TIME-0.2: 0.02, 0.03, 0.05/2*2)"})
    EXPECT_TRUE(says(text, words)) << words << "\n" << text.output;
  // A curve has no text: refused, with its line.
  folder.write(
      "curve.adm",
      "curve\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND\nPART/1, GROUND\nMARKER/10, PART=1\n"
      "PART/2, MASS=1, CM=20, IP=1,1,1\nMARKER/20, PART=2\nJOINT/1, REVOLUTE, I=20, J=10\n"
      "SPLINE/1, X=0,1,2,3, Y=0,1,4,9\nMOTION/1, JOINT=1, FUNCTION=AKISPL(TIME, 0, 1)\nEND\n");
  const Outcome curve = folder.shell("lithe model inspect curve.adm --write no.cpp");
  EXPECT_EQ(curve.exit_code, 1);
  EXPECT_TRUE(says(curve, "curve.adm:9") && says(curve, "not written as C++") && says(curve, "SPLINE")) << curve.output;
}

}  // namespace
}  // namespace lithe::test::model_test
