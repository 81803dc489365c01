// The user's call: stability_map() on scenes of known behaviour, and what it writes.
#include "engine/study/stability_map.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bodies/rigid_body.h"
#include "engine/base/error.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "joints/distance_joint.h"
#include "joints/forces/spring_damper.h"
#include "tools/stability/methods/explicit_index1.h"

namespace lithe::test::stability_map_test {
namespace {

constexpr double kOmega = 200;  // rad/s, of the mass on its spring

/// 1 kg on a spring along z, pulled out by 0.1 m.
StudyScene oscillator() {
  return {.name = "oscillator",
          .duration = 1,
          .gravity = {0, 0, 0},
          .characteristic_length = 0.1,
          .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
            auto& mass = graph.add<RigidBody>("mass", {.position = {0, 0, 1.1}});
            graph.add<SpringDamper>("spring", {graph.ground().marker(), mass.marker()},
                                    {.stiffness = kOmega * kOmega, .natural_length = 1});
            return {height(mass.marker(), "height")};
          }};
}

StudyScene pendulum() {
  return {.name = "pendulum", .duration = 2, .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
            auto& mass = graph.add<RigidBody>("mass", {.position = {1, 0, 0}});
            graph.add<DistanceJoint>("rod", {graph.ground().marker(), mass.marker()});
            return {position(mass.marker(), "bob")};
          }};
}

StudyMethod rk4() {
  return {"RK4, index 1", StudyMethod::Setting::step, [](double step) {
            return std::make_unique<lab::ExplicitIndex1>(lab::ExplicitIndex1::Parameters{.step = step});
          }};
}
StudyMethod alpha() {
  return {"generalized-alpha", StudyMethod::Setting::step,
          [](double step) { return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = step}); }};
}
StudyMethod runge_kutta() {
  return {"Runge-Kutta", StudyMethod::Setting::tolerance, [](double tolerance) {
            return std::make_unique<ExplicitRungeKutta>(
                ExplicitRungeKutta::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
          }};
}

const StabilityCell& find(const StabilityMap& map, const std::string& start) {
  for (const StabilityCell& cell : map.cells())
    if (cell.method.starts_with(start)) return cell;
  throw std::runtime_error("no cell " + start);
}

TEST(StabilityMap, TellsTheLargestStableStepOfRungeKuttaOnASpring) {
  const StabilityMap map = stability_map(oscillator(), {rk4(), alpha(), runge_kutta()},
                                         {.tolerances = {1e-6, 1e-9}, .steps = {0.02, 2e-3, 5e-4}});
  // |R(ih ω)| <= 1 for h ω <= 2 √2; a little beyond, energy grows too slowly to be seen in one second.
  const StabilityCell& fine = find(map, "RK4, index 1, h = 500 µs");
  EXPECT_EQ(to_string(fine.outcome), "converged") << fine.more;
  EXPECT_GT(fine.largest_stable_step, 2.80 / kOmega);
  EXPECT_LT(fine.largest_stable_step, 2.97 / kOmega);
  EXPECT_EQ(to_string(find(map, "RK4, index 1, h = 20 ms").outcome), "unstable");
  // The implicit method is stable at any step, but too coarse there.
  const StabilityCell& coarse = find(map, "generalized-alpha, h = 20 ms");
  EXPECT_EQ(to_string(coarse.outcome), "inaccurate") << coarse.more;
  EXPECT_GT(coarse.value, 0.1);
  EXPECT_EQ(to_string(find(map, "Runge-Kutta, tolerance 1e-6").outcome), "converged");
}

TEST(StabilityMap, SeesTheDriftOfIndexOne) {
  const StabilityMap map =
      stability_map(pendulum(), {rk4(), runge_kutta()},
                    {.tolerances = {1e-8}, .steps = {0.02}, .allowed_residual = 1e-7, .find_largest_step = false});
  const StabilityCell& drift = find(map, "RK4");
  EXPECT_EQ(to_string(drift.outcome), "inaccurate");
  EXPECT_EQ(drift.measure, "largest |g|");
  EXPECT_GT(drift.value, 1e-7);
  EXPECT_LT(drift.value, 1e-3);
  EXPECT_EQ(to_string(find(map, "Runge-Kutta").outcome), "converged");
}

TEST(StabilityMap, CallsAMethodThatRefusesRefused) {
  const StudyMethod refusing{"refusing", StudyMethod::Setting::tolerance, [](double) -> std::unique_ptr<Integrator> {
                               throw SceneError("not for pendulums", "here", "take another");
                             }};
  const StabilityMap map = stability_map(pendulum(), {refusing, runge_kutta()}, {.tolerances = {1e-6}});
  const StabilityCell& cell = find(map, "refusing");
  EXPECT_EQ(to_string(cell.outcome), "refused");
  EXPECT_NE(cell.why.find("not for pendulums"), std::string::npos);
  EXPECT_THROW(stability_map(pendulum(), {refusing}, {.tolerances = {1e-6}}), SimulationError);
}

TEST(StabilityMap, IsWrittenAsJsonTableAndPicture) {
  StabilityMap map;
  map.add({.scene = "S01",
           .title = "drift",
           .method = "index 1",
           .outcome = StabilityOutcome::inaccurate,
           .measure = "|g|, m",
           .value = 3.6e-3});
  map.add({.scene = "S01",
           .title = "drift",
           .method = "projected",
           .measure = "|g|, m",
           .value = 1e-16,
           .largest_stable_step = 0.25});
  const std::string folder = std::string(LITHE_BINARY_DIR) + "/tests/stability_map";
  map.write_json(folder + "/summary.json");
  map.write_table(folder + "/table.md");
  map.draw(folder + "/map");

  std::ifstream file(folder + "/summary.json");
  const nlohmann::json cells = nlohmann::json::parse(file).at("cells");
  ASSERT_EQ(cells.size(), 2u);
  EXPECT_EQ(cells[0].at("scene"), "S01");
  EXPECT_EQ(cells[0].at("method"), "index 1");
  EXPECT_EQ(cells[0].at("outcome"), "inaccurate");
  EXPECT_EQ(cells[0].at("measure"), "|g|, m");
  EXPECT_EQ(cells[0].at("value"), 3.6e-3);
  EXPECT_TRUE(cells[0].at("largest_stable_step_s").is_null());
  EXPECT_EQ(cells[1].at("largest_stable_step_s"), 0.25);
  EXPECT_NE(map.table().find("| S01 drift | projected | index 1 | - | - |"), std::string::npos) << map.table();
  EXPECT_GT(std::filesystem::file_size(folder + "/map.svg"), 1000u);
  EXPECT_GT(std::filesystem::file_size(folder + "/map.png"), 1000u);
  EXPECT_THROW(StabilityMap{}.draw(folder + "/none"), SceneError);
}

TEST(StabilityMap, IsAPageThatHoldsItsDataWhateverTheWords) {
  StabilityMap map;
  map.add({.scene = "S01", .title = "drift", .method = "own", .value = 3.6e-3, .why = "</script> & \"quoted\""});
  map.add({.scene = "S01", .title = "drift", .method = "RATTLE, h = 1 s", .column = "RATTLE"});
  const std::string path = std::string(LITHE_BINARY_DIR) + "/tests/stability_map/map.html";
  map.write_page(path);
  std::stringstream page;
  page << std::ifstream(path).rdbuf();
  const std::string text = page.str(), begin = R"(id="cells">)", end = "</script>";
  const std::size_t from = text.find(begin) + begin.size();
  const nlohmann::json cells = nlohmann::json::parse(text.substr(from, text.find(end, from) - from));
  ASSERT_EQ(cells.size(), 2u);
  EXPECT_EQ(cells[0].at("why"), "</script> & \"quoted\"");
  EXPECT_EQ(cells[0].at("column"), "");
  EXPECT_TRUE(cells[1].at("value").is_null());
  EXPECT_EQ(cells[1].at("column"), "RATTLE");
}

TEST(StabilityMap, LargestStableStepIsFoundByBisection) {
  int asked = 0;
  const auto below = [&](double h) { return ++asked, h <= 0.0123; };
  EXPECT_NEAR(largest_stable_step(below, 1e-6, 1, 1e-4), 0.0123, 1.3e-6);
  EXPECT_LT(asked, 25);
  EXPECT_EQ(largest_stable_step(below, 0.1, 1), 0);
  EXPECT_EQ(largest_stable_step(below, 1e-3, 1e-2), 1e-2);
}

TEST(StabilityMap, OutcomesAreNamedAsInThePublishedTable) {
  for (const char* word : {"converged", "inaccurate", "unstable", "refused"})
    EXPECT_EQ(to_string(stability_outcome(word)), word);
  EXPECT_THROW(stability_outcome("fine"), SceneError);
}

}  // namespace
}  // namespace lithe::test::stability_map_test
