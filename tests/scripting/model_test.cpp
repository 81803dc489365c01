#include <gtest/gtest.h>

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

}  // namespace
}  // namespace lithe::test
