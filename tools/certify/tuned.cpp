// tuned OUT.json [SCENE...]: what a patient user would choose. For every scene and target, the cheapest of all models
// (rigid; the first n modes; linear, stiffened, quadratic) and integrator settings whose true error meets the target in
// every watched quantity. Reduction is done before and counts on no side.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "integrators/automatic.h"
#include "integrators/generalized_alpha.h"
#include "tools/certify/scenes.h"

using namespace lithe;
using namespace lithe::certify;

namespace {

constexpr double kTargets[] = {0.1, 0.01, 0.001};
constexpr double kTight = 1e-6;  // tolerance at which models are compared
constexpr double kTooDear = 60;  // s of CPU for one run: nobody would choose it
constexpr int kModeCounts[] = {1, 2, 3, 5, 8, 12, FlexibleBody::kAll};
const char* const kDeflections[] = {"linear", "stiffened", "quadratic"};

struct Model {
  Deflection deflection = Deflection::linear;
  int modes = 0;
  auto operator<=>(const Model&) const = default;
};

/// Automatic at a tolerance, or generalized-alpha at a fixed step (s).
struct Setting {
  Model model;
  bool fixed_step = false;
  double value = 0;
  auto operator<=>(const Setting&) const = default;
};

struct Outcome {
  double error = std::numeric_limits<double>::infinity();  // of the worst watched quantity, part of its change
  double cpu = std::numeric_limits<double>::infinity();    // s
  std::vector<double> errors{};                            // of each
};

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
  Outcome run_once(const Setting& setting) {
    parts_.mode_count = setting.model.modes;
    parts_.deflection = setting.model.deflection;
    Outcome outcome;
    try {
      std::unique_ptr<Integrator> integrator;
      if (setting.fixed_step)
        integrator = std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = setting.value});
      else
        integrator =
            std::make_unique<Automatic>(Automatic::Parameters{.tolerance = {setting.value, 0.01 * setting.value}});
      const Sampled sampled = run(scene_, parts_, *integrator);
      outcome.cpu = sampled.cpu;
      outcome.errors = deviations(sampled.watched, sampled.table, reference_);
      outcome.error = *std::max_element(outcome.errors.begin(), outcome.errors.end());
    } catch (const Error&) {  // a model that breaks down, a step too long: not what one would choose
    }
    return outcome;
  }

  Scene scene_;
  Table reference_;
  ElasticParts parts_{ElasticParts::Kind::modes};
  std::map<Setting, Outcome> outcomes_;
};

std::vector<Model> models_of(const Scene& scene) {
  std::vector<Model> models = {{}};
  for (Deflection deflection : {Deflection::linear, Deflection::stiffened, Deflection::quadratic})
    for (int modes : kModeCounts)
      if (deflection == Deflection::linear || !scene.linear_reference) models.push_back({deflection, modes});
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

nlohmann::json described(const Setting& setting, const Outcome& outcome) {
  nlohmann::json j;
  j["model"] = setting.model.modes == 0 ? "rigid" : kDeflections[static_cast<int>(setting.model.deflection)];
  if (setting.model.modes == FlexibleBody::kAll)
    j["modes"] = "all";
  else
    j["modes"] = setting.model.modes;
  j["integrator"] = setting.fixed_step ? "generalized-alpha" : "automatic";
  j[setting.fixed_step ? "step" : "tolerance"] = setting.value;
  j["error"] = outcome.error;
  j["cpu"] = outcome.cpu;
  return j;
}

nlohmann::json tuned(const Scene& scene) {
  Bench bench(scene);
  nlohmann::json result;
  // What each model is good for, whatever the time steps.
  std::vector<Model> models;
  for (const Model& model : models_of(scene)) {
    const Setting tight{model, false, kTight};
    const Outcome& outcome = bench.outcome(tight);
    nlohmann::json row = described(tight, outcome);
    row["errors"] = outcome.errors;
    result["models"].push_back(row);
    if (outcome.cpu < kTooDear) models.push_back(model);
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
    nlohmann::json& cell = result["targets"][percent];
    if (cheapest) cell = described(*cheapest, bench.outcome(*cheapest));
    if (by_tolerance) cell["by_tolerance"] = described(*by_tolerance, bench.outcome(*by_tolerance));
    std::printf("%-28s %5s %%  %s\n", scene.name.c_str(), percent, cell.dump().c_str());
    std::fflush(stdout);
  }
  return result;
}

}  // namespace

int main(int count, char** arguments) try {
  if (count < 2) {
    std::printf("usage: tuned OUT.json [SCENE...]\n");
    return 2;
  }
  std::vector<Scene> chosen;
  for (int i = 2; i < count; ++i) chosen.push_back(find_scene(arguments[i]));
  nlohmann::json all;
  for (const Scene& scene : count > 2 ? chosen : scenes()) {
    all[scene.name] = tuned(scene);
    std::ofstream(arguments[1]) << all.dump(1) << '\n';  // after each: the whole takes minutes
  }
  return 0;
} catch (const Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
