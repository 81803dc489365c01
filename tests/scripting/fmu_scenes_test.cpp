// FMUs of unlike scenes: they satisfy the standard's schemas and its tools, and are the native run bit for bit.
#include <gtest/gtest.h>

#include <filesystem>
#include <thread>

#include "engine/base/error.h"
#include "engine/base/resource.h"
#include "tests/scripting/command.h"
#include "tests/scripting/fmu_importer.h"

namespace lithe::test::fmu_scenes_test {
namespace {

namespace fs = std::filesystem;

struct FmuScene {
  const char *name, *scene, *step, *communication;
  int version;
  const char* plugin = "";  // a resource that it loads
};
void PrintTo(const FmuScene& s, std::ostream* out) { *out << s.name; }

class FmuScenes : public testing::TestWithParam<FmuScene> {};
INSTANTIATE_TEST_SUITE_P(
    Of, FmuScenes,
    testing::Values(
        FmuScene{"squeezer", "examples/studies/andrews_squeezer.cpp", "1e-4", "0.00123", 3},
        FmuScene{"contact", "tests/scripting/scenes/contact.cpp", "1e-3", "0.0123", 3},
        FmuScene{"redundant_loop", "tests/scripting/scenes/four_bar.cpp", "1e-3", "0.0123", 2},
        FmuScene{"plugin_joint_3", "tests/scripting/scenes/plugin_rod.cpp", "1e-3", "0.0123", 3, "massless_rod.so"},
        FmuScene{"plugin_joint_2", "tests/scripting/scenes/plugin_rod.cpp", "1e-3", "0.0123", 2, "massless_rod.so"}),
    [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(FmuScenes, AreTheNativeRunAndPassTheToolsOfTheStandard) {
  const FmuScene& c = GetParam();
  const ScriptFolder scratch;
  if (*c.plugin) fs::copy_file(std::string(LITHE_PLUGIN_DIR "/") + c.plugin, scratch.path() / c.plugin);
  const UnpackedFmu fmu(scratch, c.scene, c.version, *c.plugin ? std::string("--resource ") + c.plugin : "", c.step);
  constexpr int kSteps = 20;
  const auto exact = native_rows(scratch, c.scene, "",
                                 std::string(R"(
  for (int k = 0; k < 20; ++k) {
    simulation.run(state, state.time + )") +
                                     c.communication + R"();
    print(state, Accelerations::solved);
  }
)",
                                 c.step);
  ASSERT_EQ(exact.size(), std::size_t{kSteps});
  EXPECT_NE(exact.front(), exact.back());
  // From here on the FMU's own copy alone is there.
  if (*c.plugin) fs::remove(scratch.path() / c.plugin);
  const FmuLibrary library(fmu.library);
  ImportedInstance one(library, fmu.token(), c.version, false, ImportedInstance::Form::co_simulation,
                       (fmu.folder / "resources/").string());
  ASSERT_TRUE(one.exists()) << one.log.text;
  EXPECT_EQ(one.start(), 0);
  std::vector<unsigned> outputs(exact[0].size());
  const unsigned first = fmu.first_output();
  for (std::size_t i = 0; i < outputs.size(); ++i) outputs[i] = first + static_cast<unsigned>(i);
  const double step = std::strtod(c.communication, nullptr);
  double time = 0;
  for (const std::vector<double>& row : exact) {
    EXPECT_EQ(one.step(time, step), 0) << one.log.text;
    time += step;
    std::vector<double> values;
    EXPECT_EQ(one.get(outputs, values), 0) << one.log.text;
    EXPECT_EQ(values, row) << time;
  }
  if (*c.plugin) {
    ImportedInstance lost(library, fmu.token(), c.version);
    EXPECT_FALSE(lost.exists());
    EXPECT_NE(lost.log.text.find(c.plugin), std::string::npos) << lost.log.text;
  }
  expect_valid_description(scratch, c.version);
  expect_passes_importers(scratch);
}

TEST(FmuResources, LieInTheFolderThatTheImporterNames) {
  EXPECT_EQ(resource("data/./x.modes"), fs::path("data/x.modes"));
  {
    const ResourceFolder folder(ResourceFolder::of_address("file:///data/a%20b%2"));
    EXPECT_EQ(resource("x"), fs::path("/data/a b%2/x"));
    const ResourceFolder none("");
    EXPECT_EQ(resource("x"), fs::path("/data/a b%2/x"));
    std::thread([] { EXPECT_EQ(resource("x"), fs::path("x")) << "another thread's"; }).join();
  }
  EXPECT_EQ(resource("x"), fs::path("x"));
  EXPECT_EQ(ResourceFolder::of_address("file://localhost/data/r"), fs::path("/data/r"));
  EXPECT_EQ(ResourceFolder::of_address("file:/data/r"), fs::path("/data/r"));
  EXPECT_EQ(ResourceFolder::of_address("https://there/r"), fs::path());
  EXPECT_EQ(ResourceFolder::of_address(nullptr), fs::path());
  for (const char* path : {"", "/x", "..", "a/../../x"}) EXPECT_THROW(resource(path), SceneError) << path;
}

TEST(FmuResources, AreRefusedIfNoFmuCanHaveThem) {
  const ScriptFolder folder;
  folder.write("scene.cpp", "#include \"lithe/lithe.h\"\nlithe::StudyScene scene() { return {}; }\n");
  for (const char* path : {"/etc/passwd", "../up", "a/../../up", "missing", "."}) {
    const Outcome made = folder.shell(std::string("lithe fmu scene.cpp --resource ") + path);
    EXPECT_EQ(made.exit_code, 1) << path << made.output;
    EXPECT_NE(made.output.find(path), std::string::npos) << made.output;
  }
  EXPECT_FALSE(fs::exists(folder.path() / "scene.fmu"));
}

}  // namespace
}  // namespace lithe::test::fmu_scenes_test
