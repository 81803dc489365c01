#include <gtest/gtest.h>

#include <filesystem>

#include "tests/scripting/command.h"

namespace lithe::test::chart_test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene = R"(#include "lithe/lithe.h"
lithe::StudyScene scene() {
  return {.name = "swing", .duration = 0.5, .draw = [](lithe::SystemGraph& graph) -> std::vector<lithe::Sensor> {
            auto& bob = graph.add<lithe::RigidBody>("bob", {.mass = 1, .position = {1, 0, 0}});
            graph.add<lithe::SphericalJoint>("pin", {graph.ground().marker(), bob.marker({-1, 0, 0})});
            return {lithe::position(bob.marker(), "bob")};
          }};
}
)";

testing::AssertionResult says(const Outcome& outcome, const std::string& words) {
  if (outcome.output.find(words) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "'" << words << "' is not in (exit code " << outcome.exit_code << "):\n"
                                     << outcome.output;
}

TEST(Chart, OfAUsersSceneIsOneCommand) {
  const ScriptFolder folder;
  folder.write("my scenes/swing.cpp", std::string(kScene) + "int main() { return 7; }  // for lithe run\n");
  const Outcome drawn =
      folder.shell("lithe chart 'my scenes/swing.cpp' --tolerances 1e-3,1e-5 --methods runge,ida --out pictures");
  EXPECT_EQ(drawn.exit_code, 0);
  EXPECT_TRUE(says(drawn, "swing, 0.5 s; errors in units of 1\n"));
  EXPECT_TRUE(says(drawn, "SUNDIALS IDA"));
  EXPECT_TRUE(says(drawn, "for 1e-2: "));
  EXPECT_FALSE(says(drawn, "generalized-alpha"));
  EXPECT_FALSE(says(drawn, "left 0:")) << "no progress bar where there is no terminal";
  for (const char* file : {"swing.svg", "swing.png", "swing.csv", "swing.txt"})
    EXPECT_TRUE(fs::exists(folder.path() / "pictures" / file)) << file;

  // Other options need no compiler.
  const Outcome again = folder.shell("lithe chart 'my scenes/swing.cpp' --methods runge --tolerances 1e-2 --progress");
  EXPECT_EQ(again.exit_code, 0) << again.output;
  EXPECT_TRUE(says(again, "left 0:"));
  EXPECT_TRUE(fs::exists(folder.path() / "results/charts/swing.svg"));
  EXPECT_EQ(folder.program_count(), 1);
}

TEST(Chart, MistakesAreTold) {
  const ScriptFolder folder;
  EXPECT_TRUE(says(folder.shell("lithe chart nothing"), "error: there is no scene file 'nothing'"));
  folder.write("empty.cpp", "int main() {}\n");
  const Outcome empty = folder.shell("lithe chart empty.cpp");
  EXPECT_EQ(empty.exit_code, 2);
  EXPECT_TRUE(says(empty, "error: the scene has nothing to chart.\n  fix:  write  lithe::StudyScene scene() { ... }"));

  folder.write("swing.cpp", kScene);
  const Outcome method = folder.shell("lithe chart swing.cpp --methods magic");
  EXPECT_EQ(method.exit_code, 1);
  EXPECT_TRUE(says(method, "error: there is no method 'magic'"));
  EXPECT_TRUE(says(folder.shell("lithe chart swing.cpp --tolerances tight"), "'tight' is not a number"));
}

}  // namespace
}  // namespace lithe::test::chart_test
