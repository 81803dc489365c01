#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/assembly/system.h"
#include "engine/motion/integrator.h"
#include "tools/bench/measure.h"

/// Runs by a tolerance: a method by its name, what a run has cost, and its error.
namespace lithe::bench {

/// rk5, rk8 (explicit Runge-Kutta), bdf (Lie-group BDF), radau, alpha (generalized-alpha, error controlled), adams,
/// automatic; the tolerance is relative and absolute alike. Throws std::invalid_argument for another name.
std::unique_ptr<Integrator> make_method(const std::string& name, double tolerance);

/// How a run is made: `--method automatic --tol 1e-6 --repeat 5` on the command line.
struct Setting {
  std::string method = "automatic";
  double tolerance = 1e-6;
  int repeats = 5;  // the cheapest counts
};
Setting read_setting(Arguments& arguments);

struct Run {
  double seconds = 0;  // CPU of this process, without drawing and assembling
  IntegratorStatistics done;
  State end;
  /// Method, tol, steps, cpu_seconds ...
  JsonLine& add_to(JsonLine& line, const Setting& setting) const;
};

/// Simulation{system, integrator}.run(state, end).
Run simulate(const System& system, const Setting& setting, const State& start, double end);

/// The same without a Simulation, so that nothing cuts the steps: `look` is told of the states at `times`, read off the
/// dense output; the time of that counts.
using Look = std::function<void(int row, const State& state)>;
Run follow(const System& system, const Setting& setting, const State& start, const std::vector<double>& times,
           const Look& look);

/// Rows of numbers between blanks; lines that begin with # are comments. Throws std::runtime_error for a file that is
/// not there or holds nothing.
std::vector<std::vector<double>> read_numbers(const std::string& path);

/// Distances of a chain's joint points (outboard ends of its rods) from a reference in the plane y = 0, m.
struct ChainError {
  double tip = 0, joint = 0;  // of the last point; the largest
};
ChainError chain_error(const System& system, const State& state, const std::vector<Marker>& ends,
                       const std::string& reference);

}  // namespace lithe::bench
