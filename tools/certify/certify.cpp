// certify RESULTS [--seen] [--once] [SCENE...]: solve() held against what is known. For every scene and target, what it
// states, what is so, and what it costs beside the best run by hand (tuned.cpp found it, here it is run again). --seen:
// only the half that factors are set on; --once: no repeats. Writes RESULTS/summary.json,
// certify_table.md and the charts certify and certify_cost. Returns 0 if what is promised is kept, 1 if not, 2 if it
// could not be told.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/base/error.h"
#include "engine/study/model_error.h"
#include "integrators/solve.h"
#include "tools/bench/measure.h"
#include "tools/certify/report.h"
#include "tools/certify/scenes.h"
#include "tools/certify/setting.h"

using namespace lithe;
using namespace lithe::certify;

namespace {

constexpr double kTargets[] = {10, 1, 0.1};  // %
constexpr int kRepeats = 3;                  // the least counts, as for the runs by hand

nlohmann::json read_json(const std::string& path) {
  std::ifstream in(path);
  nlohmann::json json = nlohmann::json::parse(in, nullptr, false);
  if (json.is_discarded()) throw FileError("it is missing or no JSON", path, "tools/certify.sh writes it");
  return json;
}

/// What by_hand.json knows to be the cheapest, run here and now: costs are compared on one machine in one state.
class ByHand {
 public:
  ByHand(const Scene& scene, const nlohmann::json& found, double target) : scene_(scene) {
    char key[16];
    std::snprintf(key, sizeof key, "%g", target);
    const auto at = nlohmann::json::json_pointer("/" + scene.name + "/" + key);
    if (!found.contains(at) || !found[at].contains("modes")) return;
    best_ = read_setting(found[at]);
    tuned_.model = text(*best_);
    if (found[at].contains("by_tolerance")) by_tolerance_ = read_setting(found[at]["by_tolerance"]);
  }
  void run(const Table& reference) {
    if (best_) measure(*best_, reference, tuned_.cost);
    if (!by_tolerance_) return;
    if (*by_tolerance_ == *best_)
      tuned_.by_tolerance = tuned_.cost;
    else
      measure(*by_tolerance_, reference, tuned_.by_tolerance);
  }
  const HandTuned& tuned() const { return tuned_; }

 private:
  void measure(const Setting& setting, const Table& reference, double& cost) {
    cost = std::fmin(cost, run_setting(scene_, parts_, setting, reference).cpu);  // fmin: unknown at first
  }

  const Scene& scene_;
  ElasticParts parts_{ElasticParts::Kind::modes};
  std::optional<Setting> best_, by_tolerance_;
  HandTuned tuned_;
};

struct Answer {
  Solution solution;
  double cost = 0;  // s of CPU, all within solve()
};

Answer solve_once(const Scene& scene, ElasticParts& parts, double target) {
  SystemGraph graph{{.gravity = scene.gravity}};
  std::vector<Want> wants;
  for (const Sensor& sensor : scene.draw(graph, parts)) wants.push_back(want(sensor, percent(target)));
  const double begun = bench::cpu_seconds();  // drawing reduces bodies: it counts on no side
  Solution solution =
      solve(graph, scene.duration, wants,
            {.samples = scene.samples, .scene = scene.name, .small_deflection = scene.linear_reference});
  return {std::move(solution), bench::cpu_seconds() - begun};
}

/// Samples that end early, or are not finite, would hide errors.
void require_comparable(const Table& samples, const Table& reference) {
  const auto finite = [](double value) { return std::isfinite(value); };
  if (samples.row_count() == reference.row_count() && samples.columns.size() == reference.columns.size() &&
      std::all_of(samples.values.begin(), samples.values.end(), finite))
    return;
  throw SimulationError("the answer has not the reference's samples, or some that are not finite", "tools/certify",
                        "run the scene by itself: diagnose() tells why it fails");
}

std::vector<CertifiedCase> cases_of(const Scene& scene, ElasticParts& parts, double target, ByHand by_hand,
                                    double reference_error, int repeats) {
  SystemGraph graph{{.gravity = scene.gravity}};
  const std::vector<Sensor> watched = scene.draw(graph, parts);
  CertifiedRun run{.scene = scene.name, .seen = scene.seen, .is_long = scene.is_long, .target = target / 100};
  const Table reference = reference_of(scene);
  std::vector<CertifiedCase> cases(watched.size());
  try {
    by_hand.run(reference);
    Answer best = solve_once(scene, parts, target);
    for (int repeat = 1; repeat < repeats; ++repeat) {
      by_hand.run(reference);
      Answer again = solve_once(scene, parts, target);
      if (again.cost < best.cost) best = std::move(again);
    }
    const Certificate& sheet = best.solution.certificate;
    run.model = sheet.chosen >= 0 ? sheet.trials[sheet.chosen].model : "";
    run.integrator = sheet.integrator, run.tolerance = sheet.tolerance;
    run.cost = best.cost, run.answer_cost = sheet.answer_cost, run.costs = sheet.costs;
    require_comparable(best.solution.samples, reference);
    const std::vector<double> errors = deviations(watched, best.solution.samples, reference);
    const std::vector<double> changes = sample_changes(watched, reference);
    for (std::size_t i = 0; i < watched.size(); ++i) {
      const CertifiedQuantity& q = sheet.quantities[i];
      cases[i].stated = q.error.total() / changes[i];
      cases[i].parts = {q.error.truncation / changes[i], q.error.deflection / changes[i], q.error.time / changes[i],
                        q.error.solver / changes[i], q.error.mesh / changes[i]};
      cases[i].error = errors[i];
      cases[i].met = q.met();
    }
  } catch (const Error& error) {  // no answer: its cases are not covered
    run.failure = error.what();
  }
  run.tuned = by_hand.tuned();
  for (std::size_t i = 0; i < watched.size(); ++i) {
    cases[i].run = run, cases[i].quantity = watched[i].name(), cases[i].reference_error = reference_error;
    const CertifiedCase& c = cases[i];
    std::printf("%-26s %-14s %4g %%  stated %8.4f %%  true %8.4f %%  %-4s %6.2f  %6.1f ms, %5.2f x by hand  %s%s\n",
                run.scene.c_str(), c.quantity.c_str(), target, 100 * c.stated, 100 * c.error,
                c.covered() ? "ok" : "MISS", c.overestimate(), 1e3 * run.cost, run.cost_ratio(),
                run.failure.empty() ? run.model.c_str() : run.failure.c_str(), c.met ? "" : " (not met)");
  }
  std::fflush(stdout);
  return cases;
}

}  // namespace

int main(int count, char** arguments) try {
  if (count < 2) {
    std::fprintf(stderr, "usage: certify RESULTS [--seen] [--once] [SCENE...]\n");
    return 2;
  }
  const std::string results = arguments[1];
  const nlohmann::json by_hand = read_json(LITHE_SOURCE_DIR "/tools/certify/references/by_hand.json");
  const nlohmann::json references = read_json(LITHE_SOURCE_DIR "/tools/certify/references/references.json");
  std::vector<Scene> chosen;
  bool seen_alone = false;
  int repeats = kRepeats;
  for (int i = 2; i < count; ++i) {
    const std::string word = arguments[i];
    if (word == "--seen")
      seen_alone = true;
    else if (word == "--once")
      repeats = 1;
    else
      chosen.push_back(find_scene(word));
  }
  if (chosen.empty()) chosen = scenes();
  if (seen_alone) std::erase_if(chosen, [](const Scene& scene) { return !scene.seen; });

  std::vector<CertifiedCase> cases;
  for (const Scene& scene : chosen) {
    ElasticParts parts(ElasticParts::Kind::modes);
    const double reference_error =
        references.contains(scene.name) ? references[scene.name].at("error").get<double>() : 0;
    for (const double target : kTargets)
      for (CertifiedCase& c : cases_of(scene, parts, target, ByHand(scene, by_hand, target), reference_error, repeats))
        cases.push_back(std::move(c));
  }
  write_charts(cases, results);
  write_table(cases, results + "/certify_table.md");
  write_json(cases, results + "/summary.json");  // last: where it is, all is
  std::printf("\n%s", text(cases).c_str());
  return summarize(seen_alone ? cases : of_half(cases, false)).keeps_promise() ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
