#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <set>
#include <stdexcept>
#include <thread>

#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/base/log.h"
#include "engine/run/simulation.h"
#include "engine/study/sweep.h"
#include "engine/study/sweep_internal.h"
#include "integrators/automatic.h"
#include "integrators/generalized_alpha.h"
#include "integrators/ida.h"
#include "joints/revolute_joint.h"
#include "tests/bodies/flexible_models.h"
#include "tests/engine/output/output_scratch_folder.h"

namespace lithe::test::sweep_test {
namespace {

const SweepOptions kQuiet{.progress = Progress::Show::never};
SweepOptions with_threads(int threads) { return {.threads = threads, .progress = Progress::Show::never}; }

/// The bits of two tables, NaN included.
testing::AssertionResult same_bits(const Table& a, const Table& b) {
  if (a.columns != b.columns || a.values.size() != b.values.size())
    return testing::AssertionFailure() << "columns or rows differ";
  if (std::memcmp(a.values.data(), b.values.data(), a.values.size() * sizeof(double)) == 0)
    return testing::AssertionSuccess();
  for (std::size_t i = 0; i < a.values.size(); ++i)
    if (std::memcmp(&a.values[i], &b.values[i], sizeof(double)) != 0)
      return testing::AssertionFailure() << "value " << i << ": " << a.values[i] << " and " << b.values[i];
  return testing::AssertionFailure();
}

const Matrix3 kAlongY = rotation_about({1, 0, 0}, -M_PI / 2);

/// Two rods on hinges, released level, after half a second.
SweepValues double_pendulum(const SweepPoint& point) {
  const double length = point["length"], mass = point["mass"];
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  const Inertia upper_inertia{1e-3, 1.0 / 12, 1.0 / 12};
  auto& upper = graph.add<RigidBody>("upper", {.mass = 1, .inertia = upper_inertia, .position = {0.5, 0, 0}});
  const double across = mass * length * length / 12;
  auto& lower = graph.add<RigidBody>(
      "lower", {.mass = mass, .inertia = {1e-3 * across, across, across}, .position = {1 + length / 2, 0, 0}});
  graph.add<RevoluteJoint>("shoulder",
                           {graph.ground().marker({0, 0, 0}, kAlongY), upper.marker({-0.5, 0, 0}, kAlongY)});
  graph.add<RevoluteJoint>("elbow", {upper.marker({0.5, 0, 0}, kAlongY), lower.marker({-length / 2, 0, 0}, kAlongY)});
  const System system = assemble(graph);
  State state = system.initial_state();
  Automatic integrator{{.tolerance = {.relative = 1e-6, .absolute = 1e-6}}};
  Simulation simulation{system, integrator};
  simulation.run(state, 0.5);
  return {{"x", state.q[7]}, {"z", state.q[9]}};
}

const Table kRods = grid({{"mass", {0.5, 1, 2}}, {"length", {0.5, 0.75, 1, 1.25}}});

TEST(Sweep, ADoublePendulumDoesNotDependOnTheNumberOfThreads) {
  const SweepResult alone = sweep(double_pendulum, kRods, with_threads(1));
  ASSERT_TRUE(alone.failures.empty()) << alone.report();
  EXPECT_EQ(alone.table.columns, (std::vector<std::string>{"mass", "length", "x", "z"}));
  ASSERT_EQ(alone.table.row_count(), 12);
  for (int threads : {2, 3, 8, 0}) {
    const SweepResult together = sweep(double_pendulum, kRods, with_threads(threads));
    EXPECT_TRUE(same_bits(alone.table, together.table)) << threads << " threads";
  }
  // Each point is that scene, not another: computed here once more.
  for (int row : {0, 7, 11}) {
    const SweepValues values = double_pendulum(SweepPoint(kRods, row));
    EXPECT_EQ(alone.table.at(row, 2), values[0].value);
    EXPECT_EQ(alone.table.at(row, 3), values[1].value);
  }
}

TEST(Sweep, AFlexiblePendulumDoesNotDependOnTheNumberOfThreads) {
  // The mesh is read once and shared; each point reduces it and runs it, by two solvers of which one is SUNDIALS'.
  const FiniteElementModel model = pendulum_model("hex8i");
  const auto scene = [&](const SweepPoint& point) -> SweepValues {
    const std::vector<int>& edge = model.node_set("hinge");
    SystemGraph graph{{.gravity = {0, 0, -point["gravity"]}}};
    auto& rod = graph.add<FlexibleBody>(
        "rod", {.basis = make_basis(model, HingeFrame{edge}, static_cast<int>(point["modes"]))});
    graph.add<RevoluteJoint>("hinge", {graph.ground().marker({0, 0.005, 0}, kAlongY), rod.average(edge, kAlongY)});
    const System system = assemble(graph);
    double tip[2];
    for (int i = 0; i < 2; ++i) {
      State state = system.initial_state();
      const auto run = [&](Integrator&& integrator) { Simulation{system, integrator}.run(state, 0.01); };
      if (i == 0)
        run(GeneralizedAlpha{{.step = 5e-4}});
      else
        run(Ida{{.tolerance = {.relative = 1e-4, .absolute = 1e-6}}});
      tip[i] = state.q.norm();
    }
    return {{"alpha", tip[0]}, {"ida", tip[1]}};
  };
  const Table points = grid({{"modes", {2, 4}}, {"gravity", {5, 9.81, 20}}});
  const SweepResult alone = sweep(scene, points, with_threads(1));
  ASSERT_TRUE(alone.failures.empty()) << alone.report();
  for (int threads : {2, 3, 8})
    EXPECT_TRUE(same_bits(alone.table, sweep(scene, points, with_threads(threads)).table)) << threads << " threads";
}

TEST(Sweep, APointThatFailsLeavesTheOthersAlone) {
  const Table points = grid({{"mass", {1, -1, 2}}, {"length", {1, 1.5}}});
  const SweepResult result = sweep(double_pendulum, points, with_threads(3));
  ASSERT_EQ(result.failures.size(), 2u);
  const SweepFailure& failure = result.failures[0];
  EXPECT_EQ(failure.row, 2);
  EXPECT_EQ(result.failures[1].row, 3);
  EXPECT_EQ(failure.point, "point 2 (mass -1, length 1)");
  EXPECT_NE(failure.what.find("mass"), std::string::npos) << failure.what;
  EXPECT_NE(failure.where.find("sweep_test.cpp"), std::string::npos) << failure.where;
  EXPECT_FALSE(failure.fix.empty());
  for (int row = 0; row < 6; ++row)
    EXPECT_EQ(std::isnan(result.table.at(row, 2)), row == 2 || row == 3) << "row " << row;
  EXPECT_EQ(result.report().find("2 of 6 points failed\npoint 2 (mass -1, length 1): "), 0u) << result.report();
}

TEST(Sweep, WhateverAPointThrowsIsNamed) {
  const auto scene = [](const SweepPoint& point) -> SweepValues {
    if (point["x"] == 0) throw std::runtime_error("no such file");
    if (point["x"] == 1) throw 42;
    if (point["x"] == 2) point["y"];
    if (point["x"] == 3) return {{"other", 1}};
    if (point["x"] == 4) return {{"x", 1}};
    return {{"square", point["x"] * point["x"]}};
  };
  const SweepResult result = sweep(scene, grid({{"x", {5, 0, 1, 2, 3, 4, 6}}}), kQuiet);
  ASSERT_EQ(result.failures.size(), 5u) << result.report();
  EXPECT_EQ(result.failures[0].what, "no such file");
  EXPECT_NE(result.failures[1].what.find("no std::exception"), std::string::npos);
  EXPECT_EQ(result.failures[2].what, "the sweep has no parameter 'y'");
  EXPECT_EQ(result.failures[2].fix, "known are x");
  EXPECT_NE(result.failures[3].what.find("other results than point 0 (x 5)"), std::string::npos);
  EXPECT_NE(result.failures[4].what.find("'x'"), std::string::npos);
  EXPECT_EQ(result.table.columns, (std::vector<std::string>{"x", "square"}));
  EXPECT_EQ(result.table.at(0, 1), 25);
  EXPECT_EQ(result.table.at(6, 1), 36);
}

TEST(Sweep, AllPointsMayFail) {
  const SweepResult result = sweep([](const SweepPoint&) -> SweepValues { throw std::runtime_error("never"); },
                                   grid({{"x", evenly_spaced(1, 12, 12)}}), kQuiet);
  EXPECT_EQ(result.failures.size(), 12u);
  EXPECT_EQ(result.table.columns, std::vector<std::string>{"x"});
  EXPECT_EQ(result.table.row_count(), 12);
  EXPECT_NE(result.report().find("and 2 more"), std::string::npos);
}

TEST(Sweep, ThreadsTakeThePointsThatAreLeft) {
  // Point 0 ends once all the others have: only a free thread that takes them one by one gets there.
  constexpr int count = 20;
  std::atomic<int> others = 0;
  const auto scene = [&](const SweepPoint& point) -> SweepValues {
    if (point.row() > 0)
      ++others;
    else
      for (int i = 0; i < 5000 && others < count - 1; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return {{"others", static_cast<double>(point.row() == 0 ? others.load() : 0)}};
  };
  const SweepResult result = sweep(scene, grid({{"x", evenly_spaced(0, 1, count)}}), with_threads(2));
  EXPECT_EQ(result.table.at(0, 1), count - 1);
}

TEST(Sweep, TheBarCountsPoints) {
  testing::internal::CaptureStderr();
  sweep(
      [](const SweepPoint&) -> SweepValues {
        return {{"y", 1}};
      },
      grid({{"x", {1, 2, 3}}}), {.threads = 2, .progress = Progress::Show::always});
  const std::string bar = testing::internal::GetCapturedStderr();
  EXPECT_NE(bar.find("] 1/3  point "), std::string::npos) << bar;
  EXPECT_NE(bar.find("] 3/3  point "), std::string::npos) << bar;
}

TEST(Sweep, AProcessBoundToOneProcessorUsesOne) {
  int free = 0;
  std::thread([&] {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(sched_getcpu(), &one);
    ASSERT_EQ(pthread_setaffinity_np(pthread_self(), sizeof one, &one), 0);
    free = free_processors(1);
  }).join();
  EXPECT_EQ(free, 1);
  EXPECT_GE(free_processors(1), 1);
  EXPECT_GE(free_processors(1000), 1) << "more ranks than processors";
}

TEST(Sweep, ASweepWithinAPointRunsOnItsThread) {
  const auto inner = [](const SweepPoint& point) -> SweepValues { return {{"y", 2 * point["x"]}}; };
  std::atomic<int> elsewhere = 0;
  const auto outer = [&](const SweepPoint& point) -> SweepValues {
    const auto mine = std::this_thread::get_id();
    const SweepResult result = sweep(
        [&](const SweepPoint& at) {
          elsewhere += std::this_thread::get_id() != mine;
          return inner(at);
        },
        grid({{"x", {point["start"], 10}}}), with_threads(4));
    return {{"sum", result.table.at(0, 1) + result.table.at(1, 1)}};
  };
  const SweepResult result = sweep(outer, grid({{"start", {1, 2, 3}}}), with_threads(2));
  EXPECT_EQ(result.table.column("sum"), (std::vector<double>{22, 24, 26}));
  EXPECT_EQ(elsewhere, 0);
}

TEST(Sweep, WritesWhatIsMissingAsEmptyCellsAndSaysWhy) {
  const ScratchFolder folder;
  const auto scene = [](const SweepPoint& point) -> SweepValues {
    if (point["x"] == 2) throw SceneError("too, \"big\"", "scene.cpp:3", "make it\nless");
    return {{"root", std::sqrt(point["x"])}, {"y, m", 0.1}};
  };
  const SweepResult result = sweep(scene, grid({{"x", {4, 2, -1}}}), kQuiet);
  result.write_csv(folder.path("failed.csv"));
  EXPECT_EQ(file_text(folder.path("failed.csv")),
            "x,root,\"y, m\",error\n4,2,0.1,\n2,,,\"too, \"\"big\"\"; at scene.cpp:3; make it less\"\n-1,,0.1,\n");

  const SweepResult sound = sweep(scene, grid({{"x", {4, 9}}}), kQuiet);
  sound.write_csv(folder.path("sound.csv"));
  EXPECT_EQ(file_text(folder.path("sound.csv")), "x,root,\"y, m\"\n4,2,0.1\n9,3,0.1\n");
}

TEST(Sweep, KeepsItsTableWhilePointsAreComputed) {
  const ScratchFolder folder;
  const std::string path = folder.path("kept/table.csv");
  std::string seen;
  const auto scene = [&](const SweepPoint& point) -> SweepValues {
    for (int tries = 0; point.row() == 2 && seen.find("4,2,") == std::string::npos && tries < 1000; ++tries) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      seen = file_text(path);  // of the first point; that of the second may be under way
    }
    while (point.row() == 3 && !std::filesystem::is_regular_file(folder.path("kept"))) {  // it cannot be written now
      std::error_code busy;  // a file is being written there
      std::filesystem::remove_all(folder.path("kept"), busy);
      write_text(folder.path("kept"), "a file where the folder was");
    }
    return {{"root", std::sqrt(point["x"])}};
  };
  const std::string error = "it was not computed; at sweep; run the sweep again: it ended before this point\n";
  const SweepResult result =
      sweep(scene, grid({{"x", {4, 9, 16, 25}}}), {.threads = 1, .progress = Progress::Show::never, .file = path});
  EXPECT_TRUE(seen.starts_with("x,root,error\n4,2,\n9,")) << seen;
  EXPECT_TRUE(seen.ends_with("16,," + error + "25,," + error)) << seen;
  EXPECT_TRUE(result.failures.empty());
  EXPECT_EQ(result.table.values, (std::vector<double>{4, 2, 9, 3, 16, 4, 25, 5}));
  EXPECT_NE(log::last_warning().find("kept/table.csv"), std::string::npos) << log::last_warning();
  const std::string refused = message_of<FileError>([&] {
    sweep(scene, grid({{"x", {4}}}), {.progress = Progress::Show::never, .file = path});
  });
  EXPECT_NE(refused.find("kept/table.csv"), std::string::npos) << refused;
}

TEST(Sweep, RefusesPointsThatAreNone) {
  const auto scene = [](const SweepPoint&) -> SweepValues { return {{"y", 1}}; };
  const auto refusal = [&](const Table& points) {
    return message_of<SceneError>([&] { sweep(scene, points, kQuiet); });
  };
  EXPECT_NE(refusal({}).find("no points"), std::string::npos);
  EXPECT_NE(refusal({{"x"}, {}}).find("no points"), std::string::npos);
  EXPECT_NE(refusal({{"x", "x"}, {1, 2}}).find("'x' appears twice"), std::string::npos);
  EXPECT_NE(refusal({{"x"}, {1, NAN}}).find("'x' is not finite in row 1"), std::string::npos);
  EXPECT_NE(message_of<SceneError>([&] { sweep({}, grid({{"x", {1}}}), kQuiet); }).find("no scene"), std::string::npos);
  EXPECT_NE(message_of<SceneError>([&] {
              sweep(scene, grid({{"x", {1}}}), with_threads(-1));
            }).find("negative"),
            std::string::npos);
}

TEST(SweepParameters, AGridChangesItsLastParameterFastest) {
  const Table points = grid({{"a", {1, 2}}, {"b", {3}}, {"c", {4, 5, 6}}});
  EXPECT_EQ(points.columns, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(points.values, (std::vector<double>{1, 3, 4, 1, 3, 5, 1, 3, 6, 2, 3, 4, 2, 3, 5, 2, 3, 6}));
  EXPECT_THROW(grid({}), SceneError);
  EXPECT_THROW(grid({{"a", {}}}), SceneError);
  EXPECT_THROW(grid({{"a", {1}}, {"a", {2}}}), SceneError);
}

TEST(SweepParameters, ALatinHypercubeMeetsEveryPartOfEachRangeOnce) {
  const int count = 50;
  const std::vector<SweepRange> ranges{{"mass", 2, 3}, {"length", -1, 1}, {"angle"}};
  const Table points = latin_hypercube(ranges, count, 7);
  ASSERT_EQ(points.row_count(), count);
  for (const SweepRange& range : ranges) {
    std::set<int> parts;
    for (const double value : points.column(range.name)) {
      EXPECT_TRUE(range.lower <= value && value < range.upper) << range.name << " " << value;
      parts.insert(static_cast<int>(std::floor(count * (value - range.lower) / (range.upper - range.lower))));
    }
    EXPECT_EQ(parts.size(), static_cast<std::size_t>(count)) << range.name;
    EXPECT_EQ(*parts.begin(), 0);
    EXPECT_EQ(*parts.rbegin(), count - 1);
  }
  // The columns are not the same shuffle: in 50 points a correlation of 0.6 has odds of one in a million.
  const std::vector<double> x = points.column("mass"), y = points.column("length");
  double products = 0;
  for (int i = 0; i < count; ++i) products += (x[i] - 2.5) * y[i];
  EXPECT_LT(std::abs(products / count), 0.6 * 2.0 / 12);
}

TEST(SweepParameters, TheSameSeedGivesTheSamePoints) {
  const std::vector<SweepRange> ranges{{"a"}, {"b", 0, 8}};
  const Table points = latin_hypercube(ranges, 4, 1);
  EXPECT_TRUE(same_bits(points, latin_hypercube(ranges, 4, 1)));
  EXPECT_FALSE(same_bits(points, latin_hypercube(ranges, 4, 2)));
  EXPECT_THROW(latin_hypercube(ranges, 0, 1), SceneError);
  EXPECT_THROW(latin_hypercube({{"a", 1, 1}}, 3, 1), SceneError);
  EXPECT_THROW(latin_hypercube({{"a", 0, INFINITY}}, 3, 1), SceneError);
}

TEST(SweepParameters, EvenlySpacedValuesMeetBothEnds) {
  EXPECT_EQ(evenly_spaced(1, 2, 5), (std::vector<double>{1, 1.25, 1.5, 1.75, 2}));
  EXPECT_EQ(evenly_spaced(0, 0.3, 4).back(), 0.3);
  EXPECT_THROW(evenly_spaced(0, 1, 1), SceneError);
}

}  // namespace
}  // namespace lithe::test::sweep_test
