#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "tests/architecture/include_rules.h"

namespace lithe::test::architecture_test {
namespace {

namespace fs = std::filesystem;

/// A small source tree of our own, gone afterwards.
class PlantedTree : public testing::Test {
 protected:
  PlantedTree() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    root_ = fs::path(LITHE_BINARY_DIR) / "tests" / "planted_trees" / test->name();
    fs::remove_all(root_);
    fs::create_directories(root_);
  }
  ~PlantedTree() override { fs::remove_all(root_); }

  void plant(const std::string& path, const std::string& text) {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }

  /// Plants one file with `line` as its third line and says whether exactly that line is named.
  testing::AssertionResult is_caught(const std::string& path, const std::string& line) {
    const auto found = violations_of(path, line);
    if (found.empty()) return testing::AssertionFailure() << path << ": " << line << " was not found";
    if (found.size() > 1 || found[0].file != path || found[0].line != 3 || found[0].reason.empty())
      return testing::AssertionFailure() << "named instead: " << to_string(found[0]);
    return testing::AssertionSuccess();
  }
  testing::AssertionResult is_allowed(const std::string& path, const std::string& line) {
    const auto found = violations_of(path, line);
    if (!found.empty()) return testing::AssertionFailure() << to_string(found[0]);
    return testing::AssertionSuccess();
  }

  fs::path root_;

 private:
  std::vector<Violation> violations_of(const std::string& path, const std::string& line) {
    plant(path, "#pragma once\n\n" + line + "\n");
    const auto found = find_violations(root_);
    fs::remove(root_ / path);
    return found;
  }
};

TEST(Architecture, EveryIncludeFollowsTheArrowsOfTheHouse) {
  EXPECT_GE(count_sources(LITHE_SOURCE_DIR), 10) << "the sources were not found";
  for (const Violation& violation : find_violations(LITHE_SOURCE_DIR)) ADD_FAILURE() << to_string(violation);
}

TEST_F(PlantedTree, ArrowsBetweenFoldersAreKept) {
  EXPECT_TRUE(is_allowed("engine/model/a.cpp", "#include \"engine/model/body.h\""));
  EXPECT_TRUE(is_allowed("bodies/flexible/a.cpp", "#include \"bodies/rigid_body.h\""));
  EXPECT_TRUE(is_allowed("joints/a.h", "#include \"engine/model/constraint.h\""));
  EXPECT_TRUE(is_allowed("examples/01_a.cpp", "#include \"lithe/lithe.h\""));
  EXPECT_TRUE(is_allowed("examples/02_a.cpp", "#include \"examples/support/study.h\""));
  EXPECT_TRUE(is_caught("bodies/a.cpp", "#include \"examples/support/study.h\""));
  EXPECT_TRUE(is_allowed("plugins/rod/rod.cpp", "#include \"engine/plugin.h\""));
  EXPECT_TRUE(is_allowed("plugins/rod/rod.cpp", "#include \"plugins/rod/rod.h\""));
  EXPECT_TRUE(is_allowed("plugins/rod/rod.cpp", "#include <Eigen/LU>"));

  EXPECT_TRUE(is_caught("engine/model/a.cpp", "#include \"bodies/rigid_body.h\""));
  EXPECT_TRUE(is_caught("bodies/a.h", "#include \"joints/revolute_joint.h\""));
  EXPECT_TRUE(is_caught("joints/a.h", "  #  include \"bodies/rigid_body.h\"  // only for a moment"));
  EXPECT_TRUE(is_caught("integrators/a.cpp", "#include \"joints/revolute_joint.h\""));
  EXPECT_TRUE(is_caught("joints/a.cpp", "#include \"plugins/rod/rod.h\""));
  EXPECT_TRUE(is_caught("examples/02_a.cpp", "#include \"examples/common.h\""));
  EXPECT_TRUE(is_caught("engine/model/a.cpp", "#include \"tests/support/checks.h\""));
  EXPECT_TRUE(is_caught("plugins/rod/rod.cpp", "#include \"engine/model/constraint.h\""));
  EXPECT_TRUE(is_caught("plugins/rod/rod.cpp", "#include \"plugins/cam/cam.h\""));
  EXPECT_TRUE(is_caught("plugins/rod/rod.cpp", "#include <boost/graph/adjacency_list.hpp>"));
  EXPECT_TRUE(is_caught("engine/output/a.cpp", "#include \"../body.h\""));
  EXPECT_TRUE(is_caught("engine/model/a.cpp", "#include \"body.h\""));
  EXPECT_TRUE(is_caught("engine/model/a.cpp", "#include LITHE_CONFIGURATION"));
}

TEST_F(PlantedTree, RoomsOfTheEngineKnowThoseBeforeThem) {
  EXPECT_TRUE(is_allowed("engine/run/a.cpp", "#include \"engine/model/body.h\""));
  EXPECT_TRUE(is_allowed("engine/model/a.h", "#include \"engine/model/body.h\""));
  EXPECT_TRUE(is_allowed("engine/plugin.h", "#include \"engine/plugin/body_to_c.h\""));
  EXPECT_TRUE(is_allowed("engine/plugin/a.cpp", "#include \"engine/plugin_abi.h\""));

  EXPECT_TRUE(is_caught("engine/model/a.h", "#include \"engine/run/simulation.h\""));
  EXPECT_TRUE(is_caught("engine/factor/a.cpp", "#include \"engine/model/body.h\""));
  EXPECT_TRUE(is_caught("engine/study/a.cpp", "#include \"engine/plugin.h\""));
  plant("engine/a.cpp", "");
  EXPECT_EQ(find_violations(root_).size(), 1u) << "engine/a.cpp is in no room";
}

TEST(Architecture, EveryRoomSaysOnAScreenWhatItIs) {
  const std::filesystem::path engine = std::filesystem::path(LITHE_SOURCE_DIR) / "engine";
  std::set<std::string> folders;
  for (const auto& entry : std::filesystem::directory_iterator(engine))
    if (entry.is_directory()) folders.insert(entry.path().filename().string());
  const auto all = rooms();
  EXPECT_EQ(folders, std::set<std::string>(all.begin(), all.end()));
  for (const std::string& room : all) {
    std::ifstream page(engine / room / "README.md");
    int lines = 0;
    for (std::string line; std::getline(page, line);) ++lines;
    EXPECT_GE(lines, 5) << room;
    EXPECT_LE(lines, 60) << room;
  }
}

TEST_F(PlantedTree, EachPackageHasOneHome) {
  EXPECT_TRUE(is_allowed("engine/factor/graph_topology.cpp", "#include <boost/graph/adjacency_list.hpp>"));
  EXPECT_TRUE(is_allowed("engine/base/log.cpp", "#include <spdlog/spdlog.h>"));
  EXPECT_TRUE(is_allowed("integrators/ida.cpp", "#include <ida/ida.h>"));
  EXPECT_TRUE(is_allowed("integrators/ida.cpp", "#include <nvector/nvector_serial.h>"));
  EXPECT_TRUE(is_allowed("engine/analysis/static_equations.cpp", "#include <sunlinsol/sunlinsol_klu.h>"));
  EXPECT_TRUE(is_allowed("joints/contact/bullet_contact.cpp", "#include <btBulletCollisionCommon.h>"));
  EXPECT_TRUE(is_allowed("bodies/flexible/reduction.cpp", "#include <Spectra/SymGEigsShiftSolver.h>"));
  EXPECT_TRUE(is_allowed("bodies/flexible/reduction.cpp", "#include <Eigen/CholmodSupport>"));
  EXPECT_TRUE(is_allowed("joints/a.cpp", "#include <nlohmann/json.hpp>"));
  EXPECT_TRUE(is_allowed("engine/plugin/plugin_loader.cpp", "#include <dlfcn.h>"));
  EXPECT_TRUE(is_allowed("integrators/a.cpp", "#include <Eigen/SparseLU>"));

  EXPECT_TRUE(is_caught("engine/model/layout.cpp", "#include <boost/graph/adjacency_list.hpp>"));
  EXPECT_TRUE(is_caught("engine/assembly/system.cpp", "#include <fmt/format.h>"));
  EXPECT_TRUE(is_caught("integrators/radau.cpp", "#include <ida/ida.h>"));
  EXPECT_TRUE(is_caught("engine/analysis/equilibrium.cpp", "#include <sunlinsol/sunlinsol_klu.h>"));
  EXPECT_TRUE(is_caught("integrators/radau.cpp", "#include <sunmatrix/sunmatrix_sparse.h>"));
  EXPECT_TRUE(is_caught("joints/revolute_joint.cpp", "#include <LinearMath/btVector3.h>"));
  EXPECT_TRUE(is_caught("joints/a.cpp", "#include <Spectra/SymGEigsShiftSolver.h>"));
  EXPECT_TRUE(is_caught("engine/model/a.cpp", "#include <Eigen/CholmodSupport>"));
  EXPECT_TRUE(is_caught("engine/output/hdf5_file.cpp", "#include <zlib.h>"));
  EXPECT_TRUE(is_caught("engine/model/a.cpp", "#include <absl/strings/str_cat.h>"));
  EXPECT_TRUE(is_caught("engine/output/csv.cpp", "FILE* pipe = popen(command.c_str(), \"w\");"));
  EXPECT_TRUE(is_caught("examples/01_a.cpp", "std::system(command);"));
  EXPECT_TRUE(is_caught("examples/01_a.cpp", "run(\"gnuplot chart.gp\");"));
  EXPECT_TRUE(is_caught("engine/output/vtu.cpp", "#include <spawn.h>"));
  EXPECT_TRUE(is_allowed("engine/run/simulation.cpp", "return simulation.system();"));
  EXPECT_TRUE(is_allowed("engine/output/chart.cpp", "if (posix_spawnp(&child, \"gnuplot\", actions) != 0) return;"));
}

TEST_F(PlantedTree, OneHomeIsOneFile) {
  plant("engine/factor/graph_topology.cpp", "#include <boost/graph/adjacency_list.hpp>\n");
  EXPECT_TRUE(find_violations(root_).empty());
  EXPECT_TRUE(is_caught("engine/factor/graph_topology_2.cpp", "#include <boost/graph/connected_components.hpp>"));
}

TEST_F(PlantedTree, PublicHeadersShowEigenAndTheStandardLibraryOnly) {
  EXPECT_TRUE(is_allowed("engine/model/a.h", "#include <Eigen/Core>"));
  EXPECT_TRUE(is_allowed("engine/model/a.h", "#include <string_view>"));
  EXPECT_TRUE(is_allowed("engine/plugin_abi.h", "#include <stdint.h>"));
  EXPECT_TRUE(is_allowed("joints/contact/shape_internal.h", "#include <btBulletCollisionCommon.h>"));

  EXPECT_TRUE(is_caught("joints/contact/bullet_contact.h", "#include <btBulletCollisionCommon.h>"));
  EXPECT_TRUE(is_caught("engine/model/a.h", "#include <nlohmann/json.hpp>"));
  EXPECT_TRUE(is_caught("engine/model/a.h", "#include <dlfcn.h>"));
  EXPECT_TRUE(is_caught("joints/contact/contact.h", "#include \"joints/contact/shape_internal.h\""));
}

TEST_F(PlantedTree, AHeaderIsReadOnce) {
  plant("engine/model/a.h", "#include <string>\n");
  ASSERT_EQ(find_violations(root_).size(), 1u);
  EXPECT_EQ(find_violations(root_)[0].file, "engine/model/a.h");
}

TEST_F(PlantedTree, AnIncludeInACommentIsNone) {
  plant("engine/model/a.cpp", "/*\n#include \"bodies/rigid_body.h\"\n*/\n// #include <boost/graph/graph_traits.hpp>\n");
  EXPECT_TRUE(find_violations(root_).empty());
}

}  // namespace
}  // namespace lithe::test::architecture_test
