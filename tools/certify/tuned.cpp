// tuned FILE.json [SCENE...]: what a patient user would choose. For every scene and target, the cheapest of all models
// (rigid; the first n modes; linear, stiffened, quadratic) and integrator settings whose true error meets the target in
// every watched quantity; beams also exact, of several numbers of elements. Reduction is done before and counts on no
// side. Scenes that are in the file already are left out, unless they are named.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "engine/base/error.h"
#include "tools/certify/setting.h"

using namespace lithe;
using namespace lithe::certify;

namespace {

constexpr double kTargets[] = {0.1, 0.01, 0.001};
constexpr double kTight = 1e-5;  // tolerance at which models are compared
constexpr double kTooDear = 60;  // s of CPU for one run: nobody would choose it
constexpr int kModeCounts[] = {1, 2, 3, 5, 8, 12, FlexibleBody::kAll};

/// One scene; runs are made once and remembered.
class Bench {
 public:
  explicit Bench(Scene scene) : scene_(std::move(scene)), reference_(reference_of(scene_)) {}

  const Scene& scene() const { return scene_; }
  const Outcome& outcome(const Setting& setting) {
    const auto [at, is_new] = outcomes_.try_emplace(setting);
    if (is_new) at->second = run_once(setting);
    return at->second;
  }
  /// Least of three.
  const Outcome& measured(const Setting& setting) {
    outcome(setting);
    Outcome& known = outcomes_[setting];
    for (int i = 0; i < 2; ++i) known.cpu = std::min(known.cpu, run_once(setting).cpu);
    return known;
  }

 private:
  Outcome run_once(const Setting& setting) { return run_setting(scene_, parts_, setting, reference_); }

  Scene scene_;
  Table reference_;
  ElasticParts parts_{ElasticParts::Kind::modes};
  std::map<Setting, Outcome> outcomes_;
};

std::vector<Model> models_of(const Scene& scene) {
  std::vector<Model> models = {{}};
  if (scene.beam_elements > 0) {
    for (int elements : {4, 8, 16, 32, 64}) models.push_back({Deflection::exact, 0, elements});
    for (Deflection deflection : {Deflection::linear, Deflection::stiffened})
      for (int modes : {1, 2, 3, 5, 8, 12}) models.push_back({deflection, modes});
    return models;
  }
  for (Deflection deflection : {Deflection::linear, Deflection::stiffened, Deflection::quadratic})
    for (int modes : kModeCounts)
      if ((deflection == Deflection::linear || !scene.linear_reference) && (!scene.is_long || modes != 2))
        models.push_back({deflection, modes});
  return models;
}

/// From the loosest setting on; finds the cheapest of a model that meets the target, and what it costs.
void try_settings(Bench& bench, const Model& model, double target, std::vector<Setting>& good, double (&best)[2]) {
  const double interval = bench.scene().duration / bench.scene().samples;
  for (const bool fixed_step : {false, true}) {
    int met = 0;
    for (int k = 0; k < (fixed_step ? 8 : 6); ++k) {
      const Setting setting{model, fixed_step, fixed_step ? interval / (1 << k) : std::pow(10.0, -2 - k)};
      const Outcome& outcome = bench.outcome(setting);
      if (outcome.error <= target) {
        good.push_back(setting);
        best[fixed_step] = std::min(best[fixed_step], outcome.cpu);
        ++met;
      }
      // A finer setting may be cheaper by chance of the steps; the second after that hardly.
      if (met > 0 && (fixed_step || outcome.error > target || met == 2)) break;
      if (std::isfinite(outcome.cpu) && outcome.cpu > 2 * best[fixed_step]) break;
    }
  }
}

/// With its error and what it cost when it was found.
nlohmann::json measured(const Setting& setting, const Outcome& outcome) {
  nlohmann::json j = described(setting);
  j["error"] = outcome.error, j["cpu"] = outcome.cpu;
  return j;
}

nlohmann::json tuned(const Scene& scene) {
  Bench bench(scene);
  nlohmann::json result;
  // What each model is good for, whatever the time steps.
  std::vector<Model> models;
  for (const Model& model : models_of(scene)) {
    const Setting tight{model, false, kTight};
    if (bench.outcome(tight).cpu < kTooDear) models.push_back(model);
  }
  const auto tight = [&](const Model& model) -> const Outcome& { return bench.outcome({model, false, kTight}); };
  std::sort(models.begin(), models.end(), [&](auto& a, auto& b) { return tight(a).cpu < tight(b).cpu; });
  for (const double target : kTargets) {
    std::vector<Setting> good;
    constexpr double kNone = std::numeric_limits<double>::infinity();
    double best[2] = {kNone, kNone};  // by tolerance, by fixed step
    for (const Model& model : models)
      if (tight(model).error <= target) try_settings(bench, model, target, good, best);
    std::sort(good.begin(), good.end(), [&](auto& a, auto& b) { return bench.outcome(a).cpu < bench.outcome(b).cpu; });
    // The cheapest few are measured with care.
    const Setting *cheapest = nullptr, *by_tolerance = nullptr;
    int of_kind[2] = {0, 0};
    for (const Setting& setting : good) {
      if (++of_kind[setting.fixed_step] > 3) continue;
      const double cpu = bench.measured(setting).cpu;
      if (!cheapest || cpu < bench.outcome(*cheapest).cpu) cheapest = &setting;
      if (!setting.fixed_step && (!by_tolerance || cpu < bench.outcome(*by_tolerance).cpu)) by_tolerance = &setting;
    }
    char percent[16];
    std::snprintf(percent, sizeof percent, "%g", 100 * target);
    nlohmann::json& cell = result[percent];
    if (cheapest) cell = measured(*cheapest, bench.outcome(*cheapest));
    if (by_tolerance) cell["by_tolerance"] = measured(*by_tolerance, bench.outcome(*by_tolerance));
    std::printf("%-28s %5s %%  %s\n", scene.name.c_str(), percent, cell.dump().c_str());
    std::fflush(stdout);
  }
  return result;
}

}  // namespace

int main(int count, char** arguments) try {
  if (count < 2) {
    std::printf("usage: tuned FILE.json [SCENE...]: scenes that are named, else those that are not in the file\n");
    return 2;
  }
  std::vector<Scene> chosen;
  for (int i = 2; i < count; ++i) chosen.push_back(find_scene(arguments[i]));
  nlohmann::json all = nlohmann::json::object();
  if (std::ifstream known(arguments[1]); known) all = nlohmann::json::parse(known);
  for (const Scene& scene : count > 2 ? chosen : scenes()) {
    if (count == 2 && all.contains(scene.name)) continue;
    all[scene.name] = tuned(scene);
    std::ofstream(arguments[1]) << all.dump(1) << '\n';  // after each: the whole takes minutes
  }
  return 0;
} catch (const Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
