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

}  // namespace
}  // namespace lithe::test
