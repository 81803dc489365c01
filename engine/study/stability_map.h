#pragma once

#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "engine/study/study.h"

namespace lithe {

/// How a method does on a scene.
///   converged   the detector is within its limit
///   inaccurate  the run ends, but the detector is outside its limit
///   unstable    energy or error grows without bound, or the step collapses
///   refused     it stops with a reason: a pass for robustness
enum class StabilityOutcome { converged, inaccurate, unstable, refused };
std::string to_string(StabilityOutcome outcome);
/// The other way round; throws SceneError for a word that is none of them.
StabilityOutcome stability_outcome(std::string_view word);

/// One method on one scene.
struct StabilityCell {
  std::string scene, title, method;  // "S01", "constraint drift", "index 1, no stabilisation"
  StabilityOutcome outcome = StabilityOutcome::converged;
  std::string measure;  // what the figure is, with its unit: "|g| at 100 s, m"
  double value = std::numeric_limits<double>::quiet_NaN();
  double largest_stable_step =
      std::numeric_limits<double>::quiet_NaN();  // s; NaN: there is none, or none was looked for
  std::string why{};                             // what is behind it, in words
  std::string more{};                            // further figures, in words
  std::string expected{};                        // what others found: "inaccurate: 3.6e-3 m, grows as t^2.00"
  std::string column{};                          // of the page: the method over all scenes; empty: the scene's own
};

/// Scenes x methods, as a picture, a table and a file.
class StabilityMap {
 public:
  void add(StabilityCell cell) { cells_.push_back(std::move(cell)); }
  const std::vector<StabilityCell>& cells() const { return cells_; }

  /// {"cells": [{scene, title, method, column, outcome, measure, value, largest_stable_step_s, why, more, expected}]};
  /// what is not finite is null. Throws FileError.
  void write_json(const std::string& path) const;
  /// Markdown: first scenes x outcomes, then a line a cell with its figure.
  std::string table() const;
  void write_table(const std::string& path) const;
  /// A row of fields a scene, coloured by outcome, as path.svg and path.png. Throws SceneError if there is no cell.
  void draw(const std::string& path_without_extension) const;
  /// A page (.html) that needs nothing else: a line a scene, a column a method, a square a cell, which tells its
  /// figures and words when it is chosen. Throws FileError.
  void write_page(const std::string& path) const;

 private:
  std::vector<StabilityCell> cells_;
};

/// Where run(h) turns from true (stable) to false between the steps `low` and `high`, s: bisection in log h to a
/// relative width. 0 if even `low` fails, `high` if nothing does. run may be asked at steps in any order.
double largest_stable_step(const std::function<bool(double step)>& run, double low, double high, double width = 1e-3);

/// What a study of stability tries, and the limits of its detectors.
struct StabilityOptions {
  std::vector<double> tolerances{1e-3, 1e-5, 1e-7};  // of methods made for a tolerance
  std::vector<double> steps{};       // s, of methods with a fixed step; empty: duration over 40, 160, 640, 2560
  double allowed_error = 1e-2;       // against the best run, in the scene's characteristic lengths
  double allowed_residual = 1e-6;    // largest |g|, in the units of the rows
  double allowed_energy_growth = 1;  // beyond the highest energy of the best run, in its largest kinetic energy
  int samples = 40;                  // instants at which all runs are compared
  double time_limit = 20;            // s of CPU a run; what takes longer has a collapsed step
  bool find_largest_step = true;     // of fixed-step methods, for stability alone
};

/// Runs a user's scene by each method over its settings and tells for each how it did: error against the best run (one
/// of the two that agree best among the finest of each method), |g|, growth of energy, collapse of the step, failure.
/// For methods with a fixed step also the largest that is stable, looked for up to the distance of the instants. Throws
/// SceneError for a scene that cannot be drawn, SimulationError if no run reaches the end.
StabilityMap stability_map(const StudyScene& scene, const std::vector<StudyMethod>& methods,
                           const StabilityOptions& options = {});

}  // namespace lithe
