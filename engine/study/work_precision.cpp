#include "engine/study/work_precision.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "engine/base/checks.h"
#include "engine/base/number_text.h"
#include "engine/output/csv.h"

namespace lithe {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRepeatFor = 3;        // s: what takes longer is timed well enough by one run
constexpr double kReferenceLimit = 10;  // times the limit of a run

/// What all runs are measured against, and by.
struct Measure {
  std::vector<double> times;
  Table samples{};  // of the reference
  const WorkPrecisionOptions& options;
};

/// A line of the chart: one method on one system.
struct Line {
  std::string name;
  const StudySystem* study;
  const StudyMethod* method;
  std::vector<double> settings;
};

void check(const WorkPrecisionOptions& options) {
  require::at("WorkPrecisionOptions", [&] {
    require::positive(options.reference_tolerance, "reference_tolerance");
    require::positive(options.samples, "samples");
    require::positive(options.repeats, "repeats");
    require::positive(options.time_limit, "time_limit");
    for (double step : options.steps) require::positive(step, "steps");
  });
}

void check_settings(const std::vector<double>& settings) {
  require::at("work_precision", [&] {
    for (double setting : settings) require::positive(setting, "tolerances");
  });
}

std::vector<double> sample_times(double duration, int count) {
  std::vector<double> times;
  for (int i = 1; i < count; ++i) times.push_back(duration * i / count);
  times.push_back(duration);
  return times;
}

std::vector<double> fixed_steps(const WorkPrecisionOptions& options, double duration) {
  std::vector<double> steps = options.steps;
  if (steps.empty())
    for (int k = 2; k <= 9; ++k) steps.push_back(duration / 20 / (1 << k));
  return steps;
}

std::string run_name(const Line& line, double setting) { return line.name + " " + short_number(setting); }

/// The least time of some runs, which are alike in all else.
WorkPoint measure(const Line& line, double setting, const Measure& by) {
  WorkPoint point{.method = line.name, .kind = line.method->setting, .setting = setting};
  double spent = 0;
  for (int i = 0; i < by.options.repeats && (i == 0 || spent < kRepeatFor); ++i) {
    const StudyRun run =
        run_study(*line.study, *line.method, setting, by.times, by.options.time_limit, Sampling::dense);
    point.outcome = run.outcome;
    point.why = run.why;
    point.statistics = run.statistics;
    point.cpu = i == 0 ? run.cpu : std::min(point.cpu, run.cpu);
    if (run.outcome != StudyRun::Outcome::reached) break;
    point.error = largest_difference(*line.study, run.samples, by.samples);
    spent += run.cpu;
  }
  return point;
}

/// All points, line by line; run from the loosest setting of every line on, so that the time left is soon known.
std::vector<WorkPoint> measure(const std::vector<Line>& lines, const Measure& by, Progress& progress) {
  std::vector<std::vector<WorkPoint>> points(lines.size());
  std::vector<bool> too_slow(lines.size(), false);
  std::size_t most = 0;
  for (const Line& line : lines) most = std::max(most, line.settings.size());
  for (std::size_t k = 0; k < most; ++k) {
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const Line& line = lines[i];
      if (k >= line.settings.size()) continue;
      if (too_slow[i]) {
        progress.skip(static_cast<int>(i), 1);
        points[i].push_back({.method = line.name,
                             .kind = line.method->setting,
                             .setting = line.settings[k],
                             .outcome = StudyRun::Outcome::too_slow,
                             .why = "not tried: a looser setting took too long"});
        continue;
      }
      progress.begin(static_cast<int>(i), run_name(line, line.settings[k]));
      points[i].push_back(measure(line, line.settings[k], by));
      progress.end();
      too_slow[i] = points[i].back().outcome == StudyRun::Outcome::too_slow;
    }
  }
  std::vector<WorkPoint> all;
  for (auto& of_line : points) std::move(of_line.begin(), of_line.end(), std::back_inserter(all));
  return all;
}

/// Two reference runs; says in `result` what they are worth.
Table run_references(const StudySystem& study, const std::vector<double>& times, const WorkPrecisionOptions& options,
                     int first_line, Progress& progress, WorkPrecision& result) {
  std::vector<StudyRun> runs;
  std::vector<std::string> names;
  for (int i = 0; i < 2; ++i) {
    const StudyMethod& method = options.references[i];
    const double setting = options.reference_tolerance;
    names.push_back(method.name + ", " + setting_text(method.setting, setting));
    progress.begin(first_line + i, "reference: " + method.name);
    runs.push_back(run_study(study, method, setting, times, kReferenceLimit * options.time_limit));
    progress.end();
  }
  const auto reached = [&](int i) { return runs[i].outcome == StudyRun::Outcome::reached; };
  if (reached(0) && reached(1)) {
    result.reference_agreement = largest_difference(study, runs[0].samples, runs[1].samples);
    result.reference = names[0] + "; " + names[1] + " differs from it by " + short_number(result.reference_agreement);
    return runs[0].samples;
  }
  const int other = reached(0) ? 1 : 0;
  if (!reached(0) && !reached(1))
    throw SimulationError("no reference reaches the end of '" + study.scene().name + "': " + names[0] + ": " +
                              runs[0].why + "; " + names[1] + ": " + runs[1].why,
                          "work_precision", "loosen reference_tolerance, or give other methods as references");
  result.reference_agreement = kInfinity;
  result.reference =
      names[1 - other] + "; unproven, since " + names[other] + " does not reach the end (" + runs[other].why + ")";
  return runs[1 - other].samples;
}

void check_references(const WorkPrecisionOptions& options) {
  if (options.references.size() == 2) return;
  throw SceneError(
      "a reference needs two methods, of different kind, and got " + std::to_string(options.references.size()),
      "WorkPrecisionOptions::references", "give reference_methods() of integrators/catalogue.h, or two of your own");
}

std::vector<int> run_counts(const std::vector<Line>& lines, int references) {
  std::vector<int> counts;
  for (const Line& line : lines) counts.push_back(static_cast<int>(line.settings.size()));
  counts.insert(counts.end(), references, 1);
  return counts;
}

/// The rows of a given table within the duration, with the columns that are watched.
Table given_samples(const Table& given, const StudySystem& study) {
  Table samples;
  samples.columns = study.columns();
  samples.columns.insert(samples.columns.begin(), "t");
  std::vector<std::vector<double>> columns;
  for (const std::string& name : samples.columns) columns.push_back(given.column(name));
  std::vector<double> row(columns.size());
  for (int i = 0; i < given.row_count(); ++i) {
    for (std::size_t k = 0; k < columns.size(); ++k) row[k] = columns[k][i];
    if (row[0] > 0 && row[0] <= study.scene().duration * (1 + 1e-12)) samples.add_row(row);
  }
  if (samples.row_count() == 0)
    throw SceneError("the reference has no row within the duration", "model_precision, '" + study.scene().name + "'",
                     "give samples with times in column t between 0 and the duration");
  return samples;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

}  // namespace

WorkPrecision work_precision(const StudyScene& scene, const std::vector<StudyMethod>& methods,
                             const std::vector<double>& tolerances, const WorkPrecisionOptions& options) {
  check(options);
  check_settings(tolerances);
  check_references(options);
  const StudySystem study(scene);
  std::vector<Line> lines;
  for (const StudyMethod& method : methods)
    lines.push_back({method.name, &study, &method,
                     method.setting == StudyMethod::Setting::step ? fixed_steps(options, scene.duration) : tolerances});

  Progress progress(run_counts(lines, 2), options.repeats * options.time_limit, options.progress);
  WorkPrecision result{
      .scene = scene.name, .duration = scene.duration, .characteristic_length = scene.characteristic_length};
  Measure by{.times = sample_times(scene.duration, options.samples), .options = options};
  by.samples = run_references(study, by.times, options, static_cast<int>(lines.size()), progress, result);
  result.points = measure(lines, by, progress);
  return result;
}

WorkPrecision model_precision(const std::string& name, const std::vector<StudyScene>& models,
                              const ModelReference& reference, const StudyMethod& method,
                              const std::vector<double>& settings, const WorkPrecisionOptions& options) {
  check(options);
  check_settings(settings);
  const auto* finest = std::get_if<StudyScene>(&reference);
  if (finest) check_references(options);
  if (models.empty())
    throw SceneError("there are no models to compare", "model_precision '" + name + "'", "give one scene a fidelity");

  std::vector<std::unique_ptr<StudySystem>> studies;
  std::vector<Line> lines;
  for (const StudyScene& model : models) {
    studies.push_back(std::make_unique<StudySystem>(model));
    lines.push_back({model.name, studies.back().get(), &method, settings});
    if (studies.back()->columns() != studies.front()->columns() || model.duration != models.front().duration)
      throw SceneError("'" + model.name + "' does not watch what '" + models.front().name + "' does",
                       "model_precision '" + name + "'", "give all models sensors of the same names and one duration");
  }
  const StudyScene& first = models.front();
  WorkPrecision result{.scene = name, .duration = first.duration, .characteristic_length = first.characteristic_length};
  Progress progress(run_counts(lines, finest ? 2 : 0), options.repeats * options.time_limit, options.progress);
  Measure by{.times = sample_times(first.duration, options.samples), .options = options};
  if (finest) {
    const StudySystem exact(*finest);
    by.samples = run_references(exact, by.times, options, static_cast<int>(lines.size()), progress, result);
    result.reference = "'" + finest->name + "' by " + result.reference;
  } else {
    by.samples = given_samples(std::get<Table>(reference), *studies.front());
    by.times = by.samples.column("t");
    result.reference = "given, " + std::to_string(by.samples.row_count()) + " instants";
  }
  result.points = measure(lines, by, progress);
  return result;
}

std::vector<StudyMethod> select_methods(const std::vector<StudyMethod>& methods,
                                        const std::vector<std::string>& parts) {
  if (parts.empty()) return methods;
  std::vector<char> wanted(methods.size(), 0);
  for (const std::string& part : parts) {
    bool found = false;
    for (std::size_t i = 0; i < methods.size(); ++i)
      if (lower(methods[i].name).find(lower(part)) != std::string::npos) wanted[i] = found = true;
    if (found) continue;
    std::string known;
    for (const StudyMethod& method : methods) known += (known.empty() ? "" : "; ") + method.name;
    throw SceneError("there is no method '" + part + "'", "select_methods", "known are: " + known);
  }
  std::vector<StudyMethod> chosen;
  for (std::size_t i = 0; i < methods.size(); ++i)
    if (wanted[i]) chosen.push_back(methods[i]);
  return chosen;
}

std::vector<ChartLine> read_work_points(const std::string& path) {
  const Table table = read_csv(path);
  const std::vector<double> errors = table.column("error");
  std::vector<ChartLine> lines;
  for (const std::string& name : table.columns) {
    if (name == "error") continue;
    ChartLine line{.title = name, .x = {}, .y = {}, .style = LineStyle::points};
    const std::vector<double> costs = table.column(name);
    for (std::size_t i = 0; i < costs.size(); ++i)
      if (!std::isnan(costs[i])) line.x.push_back(errors[i]), line.y.push_back(costs[i]);
    if (!line.x.empty()) lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace lithe
