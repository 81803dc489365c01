#include <gtest/gtest.h>

#include <sstream>

#include "engine/assembly/system.h"
#include "engine/observe/snapshot.h"
#include "engine/run/simulation.h"
#include "integrators/explicit_runge_kutta.h"
#include "models/compiled/tree_equations_internal.h"
#include "models/draw_model.h"
#include "models/read_model.h"
#include "tests/scripting/command.h"
#include "tests/scripting/compiled_study.h"

// Compiled scenes: the text that the command writes, compiled and run as a user would.
namespace lithe::test::compile_test {
namespace {

bool says(const Outcome& outcome, const std::string& words) { return outcome.output.find(words) != std::string::npos; }

// Without optimisation: the same bits, and Clang compiles the robots in a quarter of the time. (GCC warns of more at
// -O1.)
#ifdef __clang__
#define LITHE_TEST_OPTIMISATION " -O0"
#else
#define LITHE_TEST_OPTIMISATION " -O1"
#endif
const std::string kCompiler =
    LITHE_CXX " -std=c++17" LITHE_TEST_OPTIMISATION " -march=native -ffp-contract=off -Wall -Wextra -Werror ";

std::string study() {
  return "#include \"" LITHE_SOURCE_DIR
         "/tests/scripting/compiled_study.h\"\nlithe::StudyScene scene() { return lithe::test::compiled_study(); }\n";
}

/// Random states, accelerations there, and whether lanes that hold a state each give its bits.
constexpr const char* kCheck = R"(
#include <cstdio>
#include <cstring>
template <class Scene, int N>
bool same(const double (*states)[128], const double (*found)[128]) {
  using lithe_compiled::Pack;
  Pack<N> q[Scene::kPositions], v[Scene::kVelocities], u[Scene::kInputs], a[Scene::kVelocities];
  for (int k = 0; k < N; ++k) {
    const double* x = states[k];
    for (auto& p : q) p.set(k, *x++);
    for (auto& p : v) p.set(k, *x++);
    for (auto& p : u) p.set(k, *x++);
  }
  Scene::accelerations(q, v, u, a);
  bool all = true;
  for (int k = 0; k < N; ++k)
    for (int i = 0; i < Scene::kVelocities; ++i) {
      const double lane = a[i][k];
      all = all && std::memcmp(&lane, &found[k][i], sizeof lane) == 0;
    }
  return all;
}
template <class Scene>
int check() {
  constexpr int n = Scene::kPositions, m = Scene::kVelocities, l = Scene::kInputs;
  static double states[8][128], found[8][128];
  unsigned long long seed = 7;
  for (int k = 0; k < 8; ++k) {
    for (int i = 0; i < n + m + l; ++i) {
      seed = seed * 6364136223846793005ull + 1442695040888963407ull;
      states[k][i] = 4 * (static_cast<double>(seed >> 11) / 9007199254740992.0 - 0.5);
    }
    for (const auto& e : Scene::kQuaternions) {
      double* q = states[k] + e[0];
      const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
      for (int i = 0; i < 4; ++i) q[i] /= length;
    }
    Scene::accelerations(states[k], states[k] + n, states[k] + n + m, found[k]);
    for (int i = 0; i < n + m + l; ++i) std::printf("%.17g ", states[k][i]);
    for (int i = 0; i < m; ++i) std::printf("%.17g ", found[k][i]);
    std::printf("\n");
  }
  if (same<Scene, 4>(states, found) && same<Scene, 8>(states, found)) return 0;
  std::printf("lanes differ\n");
  return 1;
}
)";

/// Largest relative difference of printed accelerations from those of the tree, calculated here.
void expect_accelerations(const std::string& text, const CompiledTree& tree) {
  std::istringstream lines(text);
  int states = 0;
  for (std::string line; std::getline(lines, line); ++states) {
    std::istringstream numbers(line);
    const auto read = [&numbers](int count) {
      std::vector<double> all(static_cast<std::size_t>(count));
      for (double& x : all) numbers >> x;
      return all;
    };
    const auto q = read(tree.position_count()), v = read(tree.velocity_count()), u = read(tree.input_count()),
               found = read(tree.velocity_count());
    ASSERT_TRUE(numbers) << line;
    const auto expected = CompiledEquations<double>(tree).accelerations(q, v, u);
    double error = 0, largest = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      error = std::max(error, std::abs(found[i] - expected[i]));
      largest = std::max(largest, std::abs(expected[i]));
    }
    EXPECT_GT(largest, 1);
    EXPECT_LT(error, 1e-12 * largest);
  }
  EXPECT_EQ(states, 8);
}

/// The tree itself equals the engine to round-off: tests/models/compiled_test.cpp.
TEST(Compile, RobotsAsTextAccelerateAsTheirTreesAndInLanesToTheBit) {
  ScriptFolder folder;
  const std::string robots = std::string(LITHE_TEST_DATA) + "/robots/";
  for (const auto& [file, free] : {std::pair{"iiwa.urdf", false}, {"hyq.urdf", true}}) {
    const std::string name = std::string(file).substr(0, std::string(file).find('.'));
    const Outcome compiled = folder.shell("lithe compile " + robots + file + (free ? " --free" : "") +
                                          " -o out && grep -c 'for (' out/" + name + ".h");
    ASSERT_EQ(compiled.exit_code, 0) << compiled.output;
    folder.write("check_" + name + ".cpp",
                 "#include \"out/" + name + ".h\"\n" + kCheck + "int main() { return check<" + name + ">(); }\n");
    const Outcome found = folder.shell(kCompiler + "check_" + name + ".cpp -o check && ./check");
    ASSERT_EQ(found.exit_code, 0) << found.output;
    const ModelDescription model = read_model(robots + file);
    SystemGraph graph{{.gravity = model.gravity}};
    draw_model(graph, model, {.floating = free});
    expect_accelerations(found.output, CompiledTree::of(assemble(graph)));
  }
}

/// Angle and displacement at the end of `lithe compile`'s program, by steps of `step`.
std::vector<double> compiled_end(const ScriptFolder& folder, const std::string& step) {
  const Outcome motion = folder.shell("./arm motion 1 " + step + " | tail -1");
  std::istringstream line(motion.output);
  std::vector<double> row;
  for (std::string cell; std::getline(line, cell, ',');) row.push_back(std::stod(cell));
  EXPECT_EQ(row.size(), 7u) << motion.output;  // time, pin, quaternion, slide
  return {row.at(1), row.at(6)};
}

/// 37 starts, one of which blows up and some of which meet an event, alone and in lanes: the same bits.
void expect_same_sweeps(const ScriptFolder& folder) {
  folder.write("sweep.cpp", R"(#include "arm.h"
#include <cstdio>
#include <cstring>
using Points = std::vector<lithe_compiled::SweepPoint<arm>>;
template <class S>
Points swept() {
  Points points(37);
  int k = 0;
  for (auto& p : points) {
    p.q = arm::kStartPositions, p.v = arm::kStartVelocities, p.u = arm::kStartInputs;
    p.v[0] = 0.1 * k, p.u[arm::kVelocities + 1] = 40 + k;
    if (k++ == 5) p.v[0] = 1e200;
  }
  lithe_compiled::sweep<arm, S>(points, 1e-3, 400, [](const S* q, const S*) { return S(1.6) - q[0]; });
  return points;
}
int main() {
  const Points alone = swept<double>();
  int ends[3] = {0, 0, 0};
  for (const auto& p : alone) ++ends[static_cast<int>(p.end)];
  for (const Points& other : {swept<lithe_compiled::Pack<4>>(), swept<lithe_compiled::Pack<8>>()})
    for (std::size_t k = 0; k < alone.size(); ++k)
      if (std::memcmp(&alone[k].q, &other[k].q, sizeof other[k].q) || alone[k].steps != other[k].steps ||
          std::memcmp(&alone[k].v, &other[k].v, sizeof other[k].v) || alone[k].end != other[k].end)
        std::printf("point %zu differs\n", k);
  std::printf("reached %d, event %d, not finite %d, lost after %ld\n", ends[0], ends[1], ends[2], alone[5].steps);
}
)");
  const Outcome swept = folder.shell(kCompiler + "sweep.cpp -o sweep && ./sweep");
  EXPECT_EQ(swept.exit_code, 0) << swept.output;
  EXPECT_FALSE(says(swept, "differs")) << swept.output;
  int reached = 0, event = 0, lost = 0;
  ASSERT_EQ(std::sscanf(swept.output.c_str(), "reached %d, event %d, not finite %d", &reached, &event, &lost), 3)
      << swept.output;
  EXPECT_EQ(reached + event + lost, 37);
  EXPECT_GT(reached, 3);
  EXPECT_GT(event, 3);
  EXPECT_EQ(lost, 1);
}

TEST(Compile, AScenesStepsConvergeToItsMotionInTheEngineWithTheirOrder) {
  ScriptFolder folder;
  folder.write("scene.cpp", study());
  const Outcome compiled = folder.shell("lithe compile scene.cpp --name arm");
  ASSERT_EQ(compiled.exit_code, 0) << compiled.output;
  const Outcome built = folder.shell(kCompiler + "arm.cpp -o arm && ./arm histogram 2000 && ./arm throughput 100");
  ASSERT_EQ(built.exit_code, 0) << built.output;
  EXPECT_TRUE(says(built, "2000 steps of 0.001 s by Runge-Kutta 4") && says(built, "longest")) << built.output;
  EXPECT_TRUE(says(built, "times_by_8_lanes")) << built.output;
  EXPECT_EQ(folder.shell("./arm histogram -5").exit_code, 1);

  SystemGraph graph;
  const std::vector<Sensor> sensors = compiled_study().draw(graph);
  const System system = assemble(graph);
  ExplicitRungeKutta integrator(
      {.method = ExplicitRungeKutta::Method::dormand_prince8, .tolerance = {.relative = 1e-12, .absolute = 1e-12}});
  Simulation simulation(system, integrator);
  State state = system.initial_state();
  simulation.run(state, 1);
  Snapshot now(system, state);
  const auto error = [&](const std::string& step) {
    const std::vector<double> end = compiled_end(folder, step);
    return std::hypot(end[0] - sensors[0].value(now), end[1] - sensors[1].value(now));
  };
  const double coarse = error("1e-2"), fine = error("5e-3");
  EXPECT_LT(error("1e-3"), 1e-9);
  EXPECT_GT(coarse / fine, 12);
  EXPECT_LT(coarse / fine, 20);
  const double rough = error("2e-3 euler"), less_rough = error("1e-3 euler");
  EXPECT_LT(less_rough, 0.02);
  EXPECT_NEAR(rough / less_rough, 2, 0.3);
  expect_same_sweeps(folder);
}

TEST(Compile, WhatCannotBeCompiledIsRefusedByName) {
  ScriptFolder folder;
  const std::string robots = std::string(LITHE_TEST_DATA) + "/robots/";
  const Outcome loop = folder.shell("lithe compile " + robots + "four_bar.sdf");
  EXPECT_EQ(loop.exit_code, 1);
  EXPECT_TRUE(says(loop, "cannot be compiled: it closes a loop")) << loop.output;
  const Outcome coupled = folder.shell("lithe compile " + robots + "panda.urdf");
  EXPECT_EQ(coupled.exit_code, 1);
  EXPECT_TRUE(says(coupled, "_mimic' cannot be compiled: it is no lower pair")) << coupled.output;
  const Outcome name = folder.shell("lithe compile " + robots + "iiwa.urdf --name 7th");
  EXPECT_EQ(name.exit_code, 1);
  EXPECT_TRUE(says(name, "'7th' is no name of C++")) << name.output;
}

}  // namespace
}  // namespace lithe::test::compile_test
