// The stability laboratory's quick cells against the published table, and our scenes against ours (own.json): a
// method that must fail has to be seen to fail,
// with the published figure; one that must not has to pass; and ours pass wherever any method does.
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "tools/stability/lab.h"
#include "tools/stability/refuted_cells.h"

namespace lithe::lab {

/// How a test's parameter is shown.
void PrintTo(const Scene& scene, std::ostream* out) { *out << scene.id; }

namespace {

struct Expected {
  std::map<std::string, StabilityOutcome> outcomes;  // by method
  bool passed_by_any() const {
    for (const auto& [method, outcome] : outcomes)
      if (outcome == Outcome::converged) return true;
    return false;
  }
};

const std::map<std::string, Expected>& expected() {
  static const auto all = [] {
    std::map<std::string, Expected> scenes;
    for (const char* name : {"expected.json", "own.json"}) {
      std::ifstream file(std::string(LITHE_TEST_DATA "/stability/") + name);
      const nlohmann::json table = nlohmann::json::parse(file);
      for (const auto& scene : table.at("scenes"))
        for (const auto& method : scene.at("methods"))
          scenes[scene.at("id")].outcomes[method.at("method")] =
              stability_outcome(method.at("outcome").get<std::string>());
    }
    return scenes;
  }();
  return all;
}

std::optional<StabilityOutcome> find_outcome(const std::string& scene, const std::string& method) {
  const auto at = expected().find(scene);
  if (at == expected().end()) return std::nullopt;
  const auto outcome = at->second.outcomes.find(method);
  return outcome == at->second.outcomes.end() ? std::nullopt : std::optional(outcome->second);
}

std::string describe(const Finding& finding) {
  std::string text = finding.why;
  for (const Figure& f : finding.figures) text += "\n  " + f.what + ": " + std::to_string(f.value);
  return text;
}

class StabilityLaboratory : public testing::TestWithParam<Scene> {};

TEST_P(StabilityLaboratory, EveryMethodDoesAsPublished) {
  const Scene& scene = GetParam();
  const auto published = expected().find(scene.id);
  const bool any_passes = published != expected().end() && published->second.passed_by_any();
  for (const Cell& cell : scene.cells) {
    if (cell.cost == Cost::slow) continue;
    const Finding finding = run(cell);
    SCOPED_TRACE(scene.id + ", " + cell.method + ": " + describe(finding));
    const auto outcome = find_outcome(scene.id, cell.method);
    if (cell.role == Role::published) {
      EXPECT_TRUE(outcome) << "the published table has no such scene or method";
    }
    if (outcome && kRefutedCells.contains({scene.id, cell.method})) {
      EXPECT_NE(to_string(finding.outcome), to_string(*outcome)) << "as published after all: take it from the list";
    } else if (outcome) {
      EXPECT_EQ(to_string(finding.outcome), to_string(*outcome));
    }
    if (cell.role == Role::ours && any_passes) {
      EXPECT_EQ(to_string(finding.outcome), "converged");
    }
    for (const Figure& figure : finding.figures)
      EXPECT_TRUE(agrees(figure)) << figure.what << ": " << figure.value << ", published " << figure.published;
  }
}

TEST(StabilityLaboratoryTable, HasEveryPublishedMethodOfItsScenes) {
  for (const Scene& scene : scenes()) {
    const auto published = expected().find(scene.id);
    if (published == expected().end()) continue;
    std::set<std::string> run_here;
    for (const Cell& cell : scene.cells) run_here.insert(cell.method);
    for (const auto& [method, outcome] : published->second.outcomes)
      EXPECT_TRUE(run_here.contains(method)) << scene.id << ": '" << method << "' is not run";
  }
}

TEST(StabilityLaboratoryFigures, AgreeInTheDigitsThatAreAskedFor) {
  EXPECT_TRUE(agrees({"", 3.598e-3, 3.6e-3, 2}));
  EXPECT_FALSE(agrees({"", 3.4e-3, 3.6e-3, 2}));
  EXPECT_FALSE(agrees({"", -3.6e-3, 3.6e-3, 2}));
  EXPECT_TRUE(agrees({"", 8e-2, 6e-2, 0}));
  EXPECT_FALSE(agrees({"", 8, 6e-2, 0}));
  EXPECT_FALSE(agrees({"", NAN, 6e-2, 0}));
  EXPECT_TRUE(agrees({"", 7, NAN}));
}

INSTANTIATE_TEST_SUITE_P(Scenes, StabilityLaboratory, testing::ValuesIn(scenes()),
                         [](const auto& of) { return of.param.id; });

}  // namespace
}  // namespace lithe::lab
