// stability_map() of stability_map.h: a user's scene by several methods.
#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/study/stability_map.h"
#include "engine/study/study_run.h"

namespace lithe {
namespace {

constexpr int kDetectors = 3;           // columns after the user's: total energy, kinetic energy, |g|
constexpr double kShortestStep = 1e-9;  // of the duration, on average: a step shorter than that has collapsed
constexpr double kSearchWidth = 0.02;   // of the largest stable step

/// A run at one setting, with the figures of the detectors.
struct Trial {
  const StudyMethod* method;
  double setting;
  bool finest;  // of its method
  StudyRun run;
  bool reached() const { return run.outcome == StudyRun::Outcome::reached; }
};

struct Figures {
  double highest_energy = -INFINITY, largest_kinetic = 0, residual = 0;
};

/// The user's sensors come first, then those of the detectors.
StudyScene with_detectors(const StudyScene& scene) {
  StudyScene watched = scene;
  if (scene.draw)
    watched.draw = [draw = scene.draw](SystemGraph& graph) {
      std::vector<Sensor> sensors = draw(graph);
      if (sensors.empty()) return sensors;  // refused by StudySystem
      sensors.push_back(total_energy("stability: total energy"));
      sensors.push_back(kinetic_energy("stability: kinetic energy"));
      sensors.push_back(constraint_residual("stability: residual"));
      return sensors;
    };
  return watched;
}

Figures figures_of(const Table& samples) {
  const int energy = static_cast<int>(samples.columns.size()) - kDetectors;
  Figures f;
  for (int row = 0; row < samples.row_count(); ++row) {
    f.highest_energy = std::max(f.highest_energy, samples.at(row, energy));
    f.largest_kinetic = std::max(f.largest_kinetic, samples.at(row, energy + 1));
    f.residual = std::max(f.residual, samples.at(row, energy + 2));
  }
  return f;
}

/// Largest over the instants that both have, of the user's sensors alone; in characteristic lengths.
double difference(const StudySystem& study, const Table& a, const Table& b) {
  double largest = 0;
  for (int row = 0; row < std::min(a.row_count(), b.row_count()); ++row) {
    int column = 1;
    for (std::size_t s = 0; s + kDetectors < study.sensors().size(); ++s) {
      double squares = 0;
      for (std::size_t i = 0; i < study.sensors()[s].columns().size(); ++i, ++column)
        squares += std::pow(a.at(row, column) - b.at(row, column), 2);
      largest = std::max(largest, std::sqrt(squares));
    }
  }
  return largest / study.scene().characteristic_length;
}

/// Among the finest runs of the methods, one of the two that agree best; the finest of all if there is but one.
const Trial& find_best(const StudySystem& study, const std::vector<Trial>& trials) {
  const Trial* best = nullptr;
  double smallest = INFINITY;
  for (const Trial& a : trials) {
    if (!a.finest || !a.reached()) continue;
    if (!best) best = &a;
    for (const Trial& b : trials) {
      if (&a == &b || !b.finest || !b.reached()) continue;
      const double apart = difference(study, a.run.samples, b.run.samples);
      if (apart < smallest) smallest = apart, best = &a;
    }
  }
  for (const Trial& a : trials)
    if (!best && a.reached()) best = &a;
  if (!best)
    throw SimulationError("no method reaches the end of '" + study.scene().name +
                              "'; the first says: " + (trials.empty() ? "there is no method" : trials[0].run.why),
                          "stability_map", "give methods, tolerances or steps of which one can run the scene");
  return *best;
}

class Judge {
 public:
  Judge(const StudySystem& study, const StabilityOptions& options, const Trial& best)
      : study_(study), options_(options), best_(best), figures_(figures_of(best.run.samples)) {}

  /// Energy beyond the highest of the best run, in that run's largest kinetic energy.
  double energy_growth(const Trial& trial) const {
    const double scale = std::max(figures_.largest_kinetic, 1e-300);
    return trial.run.samples.row_count() == 0
               ? 0
               : (figures_of(trial.run.samples).highest_energy - figures_.highest_energy) / scale;
  }
  bool grows(const Trial& trial) const { return energy_growth(trial) > options_.allowed_energy_growth; }

  StabilityCell cell(const Trial& trial) const {
    const StudyRun& run = trial.run;
    StabilityCell cell{.scene = study_.scene().name,
                       .method = trial.method->name + ", " + setting_text(trial.method->setting, trial.setting),
                       .column = trial.method->name};
    const auto say = [&](StabilityOutcome outcome, const std::string& measure, double value, const std::string& why) {
      cell.outcome = outcome, cell.measure = measure, cell.value = value, cell.why = why;
      return cell;
    };
    const double mean_step = study_.scene().duration / static_cast<double>(std::max(1L, run.statistics.steps));
    const std::string reached = run.why.empty() ? "the run ends" : run.why;
    if (grows(trial))
      return say(StabilityOutcome::unstable, "energy beyond the best run's, of its kinetic energy",
                 energy_growth(trial), reached + ": energy grows without a source");
    if (run.outcome == StudyRun::Outcome::too_slow || mean_step < kShortestStep * study_.scene().duration)
      return say(StabilityOutcome::unstable, "mean step, s", mean_step, reached + ": the step collapses");
    if (!trial.reached()) {
      if (run.statistics.newton_failures > 0)
        return say(StabilityOutcome::refused, "Newton failures", static_cast<double>(run.statistics.newton_failures),
                   reached);
      return say(StabilityOutcome::refused, "steps taken", static_cast<double>(run.statistics.steps), reached);
    }
    const double residual = figures_of(run.samples).residual;
    const double error = &trial == &best_ ? 0 : difference(study_, run.samples, best_.run.samples);
    cell.more = "|g| " + short_number(residual) + ", error " + short_number(error) + ", " +
                std::to_string(run.statistics.steps) + " steps, " + std::to_string(run.statistics.newton_failures) +
                " Newton failures";
    if (residual > options_.allowed_residual)
      return say(StabilityOutcome::inaccurate, "largest |g|", residual, "it drifts off the constraints");
    if (error > options_.allowed_error)
      return say(StabilityOutcome::inaccurate, "error against the best run, characteristic lengths", error,
                 "too coarse for this motion");
    return say(StabilityOutcome::converged, "error against the best run, characteristic lengths", error, "");
  }

 private:
  const StudySystem& study_;
  const StabilityOptions& options_;
  const Trial& best_;
  Figures figures_;
};

}  // namespace

StabilityMap stability_map(const StudyScene& scene, const std::vector<StudyMethod>& methods,
                           const StabilityOptions& options) {
  if (options.samples < 1)
    throw SceneError("samples is " + std::to_string(options.samples), "StabilityOptions",
                     "compare at one instant or more");
  const StudySystem study(with_detectors(scene));
  std::vector<double> times, steps = options.steps;
  for (int i = 1; i <= options.samples; ++i) times.push_back(scene.duration * i / options.samples);
  if (steps.empty())
    for (double count = 40; count < 5000; count *= 4) steps.push_back(scene.duration / count);

  // 1. Every method at every setting, from coarse to fine.
  std::vector<Trial> trials;
  for (const StudyMethod& method : methods) {
    std::vector<double> settings = method.setting == StudyMethod::Setting::step ? steps : options.tolerances;
    std::ranges::sort(settings, std::greater());
    for (const double setting : settings)
      trials.push_back(
          {&method, setting, setting == settings.back(), run_study(study, method, setting, times, options.time_limit)});
  }

  // 2. Judged against the best of them.
  const Judge judge(study, options, find_best(study, trials));
  StabilityMap map;
  for (const Trial& trial : trials) {
    StabilityCell cell = judge.cell(trial);
    if (trial.finest && trial.method->setting == StudyMethod::Setting::step && options.find_largest_step &&
        cell.outcome != StabilityOutcome::unstable && cell.outcome != StabilityOutcome::refused) {
      const auto stable = [&](double step) {
        const Trial at{trial.method, step, false, run_study(study, *trial.method, step, times, options.time_limit)};
        return at.reached() && !judge.grows(at);
      };
      cell.largest_stable_step = largest_stable_step(
          stable, trial.setting, std::max(trial.setting, scene.duration / options.samples), kSearchWidth);
    }
    map.add(std::move(cell));
  }
  return map;
}

}  // namespace lithe
