#pragma once

#include <string>
#include <variant>
#include <vector>

#include "engine/output/chart.h"
#include "engine/output/table.h"
#include "engine/study/progress.h"
#include "engine/study/study.h"
#include "engine/study/study_run.h"

namespace lithe {

struct WorkPrecisionOptions {
  /// The solution that errors are measured against: the first, at reference_tolerance; the second, a method of another
  /// kind at the same tolerance, proves it.
  std::vector<StudyMethod> references{};
  double reference_tolerance = 1e-11;
  std::vector<double> steps{};  // s, of methods with a fixed step; empty: duration / 20 / 4, 8, ... 512
  int samples = 20;        // instants at which the watched quantities are compared, evenly spaced; 1: the end alone
  int repeats = 3;         // CPU time is the least of so many runs; of fewer once they have taken three seconds
  double time_limit = 60;  // s of CPU a run, ten times that for references; longer ones are stopped, and told
  Progress::Show progress = Progress::Show::on_terminal;
};

/// One point of the chart: a method (or a model) at one setting.
struct WorkPoint {
  std::string method;  // its line in the chart
  StudyMethod::Setting kind = StudyMethod::Setting::tolerance;
  double setting = 0;  // a number, or seconds
  StudyRun::Outcome outcome = StudyRun::Outcome::reached;
  std::string why{};  // of what did not reach the end
  double error = 0;  // largest over instants and watched quantities, in characteristic lengths; of what reached the end
  double cpu = 0;    // s a run
  IntegratorStatistics statistics{};
};

/// The cheapest point within an error: `point` is its place among the points.
struct Recommendation {
  double error;
  int point;
};

/// Accuracy and cost of methods on one scene, or of models by one method.
struct WorkPrecision {
  std::string scene{};
  double duration = 1, characteristic_length = 1;
  std::string reference{};         // in words
  double reference_agreement = 0;  // of the two reference runs, as errors are measured; infinite if one of them failed
  std::vector<WorkPoint> points{};

  /// The reference tells an error apart from its own down to ten times that disagreement.
  double floor() const { return 10 * reference_agreement; }
  bool is_below_floor(const WorkPoint& point) const;
  bool reference_good() const;  // no point is below that

  /// For each decade of error from 1e-2 to the smallest one reached. Left out are points below the floor, and lucky
  /// ones: those whose error the same line passes again with a tighter setting.
  std::vector<Recommendation> recommendations() const;
  /// All points, what the reference is worth, and the recommendations, to be printed in a fixed-width font.
  std::string table() const;
  /// CPU time a simulated second over error, logarithmic; `more`: lines of others, such as peers.
  Chart chart(const std::vector<ChartLine>& more = {}) const;

  void write_csv(const std::string& path) const;
  void write_chart(const std::string& path_without_extension, const std::vector<ChartLine>& more = {}) const;
};

/// Runs each method over the tolerances (or over options.steps) and measures error and cost against a reference that is
/// validated by a second method. Between steps the methods are read by their dense output, whose error is theirs. Runs
/// that fail or take too long are points too, with their reason; where a method is too slow, its tighter settings are
/// not tried.
///   The runs are serial, since they are timed. Throws SceneError for a scene that cannot be drawn, settings that are
///   not positive, fewer than two references; SimulationError if no reference reaches the end.
WorkPrecision work_precision(const StudyScene& scene, const std::vector<StudyMethod>& methods,
                             const std::vector<double>& tolerances, const WorkPrecisionOptions& options);

/// What models are compared with: the finest of them, run by options.references; or samples from elsewhere (another
/// code, a measurement): column "t" and the columns of the sensors, compared at each of its instants within the
/// duration, and taken for exact.
using ModelReference = std::variant<StudyScene, Table>;

/// The same over the fidelity of the model (rigid, so many modes, nodal): each is a line of the chart, run by one
/// method over `settings`. Where a line comes to a stand is the error of its model. All scenes must watch quantities of
/// the same names.
WorkPrecision model_precision(const std::string& name, const std::vector<StudyScene>& models,
                              const ModelReference& reference, const StudyMethod& method,
                              const std::vector<double>& settings, const WorkPrecisionOptions& options);

/// Those of `methods` whose names contain one of `parts`, letters of either case; all of them if `parts` is empty.
/// Throws SceneError, naming the known, for a part that none contains.
std::vector<StudyMethod> select_methods(const std::vector<StudyMethod>& methods, const std::vector<std::string>& parts);

/// Points of others for a chart, one line a column: a CSV with "error" and, named after each, its CPU seconds a
/// simulated second, or nan. Throws FileError.
std::vector<ChartLine> read_work_points(const std::string& path);

}  // namespace lithe
