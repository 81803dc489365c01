#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "bodies/rigid_body.h"
#include "engine/page/run.h"
#include "engine/run/simulation.h"
#include "tests/scripting/command.h"

namespace lithe::test::run_test {
namespace {

namespace fs = std::filesystem;

testing::AssertionResult says(const Outcome& outcome, const std::string& words) {
  if (outcome.output.find(words) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "'" << words << "' is not in (exit code " << outcome.exit_code << "):\n"
                                     << outcome.output;
}

TEST(Run, ASceneOfFortyLinesIsCompiledOnceAndTakesItsOwnArguments) {
  const ScriptFolder folder;
  const std::string scene = pendulum_scene();
  ASSERT_EQ(std::count(scene.begin(), scene.end(), '\n'), 40);
  folder.write("scene.cpp", scene);
  const Outcome first = folder.shell("lithe run scene.cpp");
  EXPECT_TRUE(says(first, "rows 11\n"));
  EXPECT_EQ(first.exit_code, 0);
  EXPECT_TRUE(fs::exists(folder.path() / "tip.csv")) << "the scene runs where the user stands";
  EXPECT_EQ(folder.program_count(), 1);

  // Neither the same file nor a copy of today's date is compiled again: a compiler that fails would show it.
  EXPECT_TRUE(says(folder.shell("touch scene.cpp; lithe run scene.cpp 0.2"), "rows 21\n"));
  EXPECT_EQ(folder.program_count(), 1);
  EXPECT_TRUE(says(folder.shell("mkdir sub; cd sub; lithe run ../scene.cpp 0.3"), "rows 31\n"));
  EXPECT_EQ(folder.program_count(), 1);
}

TEST(Run, AChangedSceneOrHeaderIsCompiledAgainAndArgumentsReachTheScene) {
  const ScriptFolder folder;
  folder.write("scene.cpp", R"(#include <cstdio>
#include "part of it.h"
int main(int argc, char** argv) {
  std::printf("value %d\n", kValue);
  for (int i = 1; i < argc; ++i) std::printf("[%s]", argv[i]);
  return kValue;
}
)");
  folder.write("part of it.h", "inline constexpr int kValue = 3;\n");
  const Outcome first = folder.shell("lithe run scene.cpp --help -x 'two words'");
  EXPECT_TRUE(says(first, "value 3\n[--help][-x][two words]"));
  EXPECT_EQ(first.exit_code, 3) << "the scene's exit code is the command's";

  folder.write("part of it.h", "inline constexpr int kValue = 4;\n");
  EXPECT_EQ(folder.shell("lithe run scene.cpp").exit_code, 4);
  folder.write("scene.cpp", "#include \"part of it.h\"\nint main() { return kValue + 1; }\n");
  EXPECT_EQ(folder.shell("lithe run scene.cpp").exit_code, 5);
  EXPECT_EQ(folder.program_count(), 3);
}

TEST(Run, ScenesRunAtOnceDoNotDisturbEachOther) {
  const ScriptFolder folder;
  folder.write("scene.cpp", "#include <cstdio>\nint main() { std::printf(\"done\\n\"); }\n");
  const Outcome all = folder.shell("for i in 1 2 3 4 5; do lithe run scene.cpp & done; wait");
  EXPECT_EQ(all.output, "done\ndone\ndone\ndone\ndone\n");
  EXPECT_EQ(folder.program_count(), 1);
}

struct Mistake {
  std::string line;                // of the second joint
  std::vector<std::string> words;  // the message has them
};

TEST(Mistakes, InTheCallOfAJointAreToldInItsTerms) {
  const Mistake mistakes[] = {
      {R"(graph.add<DistanceJoint>("elbow", {upper.marker(), lower.marker()}, {.lenght = 1});)",
       {"error: DistanceJoint::Parameters has no field 'lenght'; its fields are: length, length_law",
        "did you mean 'length'?"}},
      {R"(graph.add<SpringDamper>("elbow", {upper.marker(), lower.marker()}, {.damping = 1, .stiffness = 2});)",
       {"error: field 'stiffness' of SpringDamper::Parameters comes too late", "stiffness, damping"}},
      {R"(graph.add<DistanceJoint>("elbow", {upper.marker(), lower.marker()}, {.length = "long"});)",
       {"error: a value does not fit its field of DistanceJoint::Parameters",
        "std::optional<double> length{}  // L, m; none: as drawn"}},
      {R"(graph.add<RevoluteJoint>("elbow");)",
       {"error: RevoluteJoint '\"elbow\"' has no markers: it needs 2", "graph.add<RevoluteJoint>(\"name\", {A, B}"}},
      {R"(graph.add<RevolutJoint>("elbow", {ground, lower.marker()});)",
       {"error: there is no type 'RevolutJoint'", "did you mean 'RevoluteJoint'?"}},
      {R"(graph.add<RevoluteJoint>("elbow", {upper, lower});)",
       {"error: the arguments do not fit RevoluteJoint", "2 markers, made by body.marker(...)"}},
  };
  const ScriptFolder folder;
  for (const Mistake& mistake : mistakes) {
    folder.write("scene.cpp", pendulum_scene(mistake.line));
    const Outcome outcome = folder.shell("lithe run scene.cpp");
    EXPECT_EQ(outcome.exit_code, 2) << mistake.line;
    EXPECT_TRUE(says(outcome, "  at:   scene.cpp:" + std::to_string(kElbowLine) + ":"));
    EXPECT_TRUE(says(outcome, mistake.line)) << "the line itself is shown";
    for (const std::string& words : mistake.words) EXPECT_TRUE(says(outcome, words));
    EXPECT_FALSE(says(outcome, "engine/")) << "no header of ours, no template, is shown";
    EXPECT_LT(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 15) << outcome.output;
  }
}

TEST(Mistakes, OutsideOfJointsAreToldToo) {
  const ScriptFolder folder;
  std::string scene = pendulum_scene();
  const auto replace = [&](const std::string& what, const std::string& by) {
    scene.replace(scene.find(what), what.size(), by);
  };
  replace(".mass = 1", ".mas = 1");
  replace("{.step =", "{.stepp =");
  replace("position(tip", "position(tipp");
  folder.write("scene.cpp", scene);
  const Outcome outcome = folder.shell("lithe run scene.cpp");
  EXPECT_TRUE(says(outcome, "RigidBody::Parameters has no field 'mas'; its fields are: mass, inertia, position"));
  EXPECT_TRUE(says(outcome, "GeneralizedAlpha::Parameters has no field 'stepp'"));
  EXPECT_TRUE(says(outcome, "'tipp' is not declared; did you mean 'tip'?"));

  folder.write("scene.cpp", "#include \"lithe/lithe.h\"\nSystemGraph graph;\n");
  EXPECT_TRUE(says(folder.shell("lithe run scene.cpp"), "using namespace lithe;"));
  folder.write("scene.cpp", "int helper() { return 1; }\n");
  EXPECT_TRUE(says(folder.shell("lithe run scene.cpp"), "the scene has no main()"));
}

TEST(Mistakes, ThatOnlyTheGraphSeesEndTheSceneWithWhatWhereAndFix) {
  const ScriptFolder folder;
  folder.write("scene.cpp",
               pendulum_scene(R"(graph.add<RevoluteJoint>("elbow", {upper.marker({0.5, 0, 0}, along_y)});)"));
  const Outcome missing = folder.shell("lithe run scene.cpp");
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_TRUE(says(missing, "error: 'elbow': needs 2 markers and got 1\n  at:   scene.cpp:20\n  fix:  "));
  EXPECT_FALSE(says(missing, "terminate"));

  folder.write("other.cpp", "#include <stdexcept>\nint main() { throw std::runtime_error(\"of the user\"); }\n");
  const Outcome other = folder.shell("lithe run other.cpp");
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_TRUE(says(other, "did not catch it: of the user"));
}

TEST(Mistakes, OfTheMachineAreClear) {
  const ScriptFolder folder;
  EXPECT_TRUE(says(folder.shell("lithe run nothing.cpp"), "error: there is no scene file 'nothing.cpp'"));
  folder.write("scene.cpp", "int main() {}\n");
  EXPECT_TRUE(
      says(folder.shell("CXX=no_such_compiler lithe run scene.cpp"), "there is no compiler 'no_such_compiler'"));
  folder.write("file", "");
  const Outcome cache = folder.shell("XDG_CACHE_HOME=$PWD/file lithe run scene.cpp");
  EXPECT_TRUE(says(cache, "error: the cache cannot be written"));
  EXPECT_TRUE(says(cache, "XDG_CACHE_HOME"));
  EXPECT_EQ(cache.exit_code, 1);
}

TEST(New, AProjectRunsAtOnceAndBuildsAgainstTheInstalledPackage) {
  const ScriptFolder folder;
  const std::string cmake = "'" LITHE_CMAKE "'";
  const Outcome installed = folder.shell(cmake + " --install '" LITHE_BINARY_DIR "' --prefix first && mv first prefix");
  ASSERT_EQ(installed.exit_code, 0) << installed.output;

  // The command of the moved installation knows its place.
  const std::string lithe = folder.path().string() + "/prefix/bin/lithe";
  EXPECT_TRUE(says(folder.shell(lithe + " new 'my scene'"), "scene.cpp, CMakeLists.txt, README.md"));
  const Outcome again = folder.shell(lithe + " new 'my scene'");
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_TRUE(says(again, "is there already"));
  for (const char* file : {"scene.cpp", "CMakeLists.txt", "README.md"})
    EXPECT_EQ(folder.shell("grep -c @ 'my scene/" + std::string(file) + "'").output, "0\n") << "all places are filled";

  const std::string flags =
      " -D CMAKE_BUILD_TYPE=" LITHE_BUILD_TYPE " -D CMAKE_CXX_COMPILER=" LITHE_CXX
      " -D CMAKE_CXX_FLAGS='" LITHE_CXX_FLAGS "' -D CMAKE_EXE_LINKER_FLAGS='" LITHE_LINK_FLAGS "'";
  const Outcome built = folder.shell("cd 'my scene' && " + cmake + " -S . -B build" + flags + " && " + cmake +
                                     " --build build && build/my_scene 0.5");
  EXPECT_EQ(built.exit_code, 0);
  EXPECT_TRUE(says(built, "0.5 s, energy changed by"));
  const Outcome run = folder.shell(lithe + " run 'my scene/scene.cpp' 0.25");
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_TRUE(says(run, "0.25 s, energy changed by"));
}

/// A ball that flies, recorded into a file.
void write_flight(const std::string& path, const std::string& name) {
  SystemGraph graph;
  auto& ball = graph.add<RigidBody>("ball", {.velocity = {1, 0, 2}});
  const System system = assemble(graph);
  lithe::Run run{system, {position(ball.marker(), "ball")}, {.name = name}};
  run.stream(path);
  State state = system.initial_state();
  Snapshot now(system);
  for (int i = 0; i < 5; ++i) {
    state.time = state.q[0] = 0.1 * i;
    now.evaluate(state);
    run.observe(now);
  }
}

TEST(View, MakesOnePageOfRunFilesAndRefusesWhatIsNone) {
  const ScriptFolder folder;
  write_flight(folder.path() / "a.h5", "flight");
  write_flight(folder.path() / "b.h5", "flight");
  const Outcome one = folder.shell("lithe view a.h5");
  EXPECT_TRUE(says(one, "flight: 5 states\npage: a.html"));
  EXPECT_EQ(one.exit_code, 0);
  EXPECT_GT(fs::file_size(folder.path() / "a.html"), 1000u);

  // Two of one name bear those of their files.
  const Outcome two = folder.shell("lithe view a.h5 b.h5 -o pages/both.html --title 'Two flights'");
  EXPECT_TRUE(says(two, "b: 5 states\npage: pages/both.html"));
  EXPECT_TRUE(fs::exists(folder.path() / "pages/both.html"));

  folder.write("notes.txt", "no run");
  const Outcome none = folder.shell("lithe view notes.txt");
  EXPECT_TRUE(says(none, "this is not an HDF5 file, or it is cut short."));
  EXPECT_TRUE(says(none, "notes.txt"));
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_TRUE(says(folder.shell("lithe view nothing.h5"), "there is no such file."));
  EXPECT_NE(folder.shell("lithe view").exit_code, 0);
}

}  // namespace
}  // namespace lithe::test::run_test
