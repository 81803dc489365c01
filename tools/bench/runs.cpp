#include "tools/bench/runs.h"

#include <fstream>
#include <sstream>
#include <stdexcept>

#include "engine/assembly/evaluated.h"
#include "engine/assembly/evaluator.h"
#include "engine/run/simulation.h"
#include "integrators/adams.h"
#include "integrators/automatic.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "integrators/lie_bdf.h"
#include "integrators/radau.h"
#include "tools/bench/measure.h"

namespace lithe::bench {
namespace {

template <class Once>
Run cheapest(int repeats, Once&& once) {
  Run best = once();
  for (int i = 1; i < repeats; ++i) {
    Run again = once();
    if (again.seconds < best.seconds) best = std::move(again);
  }
  return best;
}

}  // namespace

std::unique_ptr<Integrator> make_method(const std::string& name, double tolerance) {
  const Tolerance both{.relative = tolerance, .absolute = tolerance};
  if (name == "automatic") return std::make_unique<Automatic>(Automatic::Parameters{.tolerance = both});
  if (name == "rk5") return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{.tolerance = both});
  if (name == "rk8")
    return std::make_unique<ExplicitRungeKutta>(
        ExplicitRungeKutta::Parameters{.method = ExplicitRungeKutta::Method::dormand_prince8, .tolerance = both});
  if (name == "adams") return std::make_unique<Adams>(Adams::Parameters{.tolerance = both});
  if (name == "bdf") return std::make_unique<LieBdf>(LieBdf::Parameters{.tolerance = both});
  if (name == "radau") return std::make_unique<Radau>(Radau::Parameters{.tolerance = both});
  if (name == "alpha") return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.tolerance = both});
  throw std::invalid_argument("no method '" + name + "'; known are adams, alpha, automatic, bdf, radau, rk5, rk8");
}

Setting read_setting(Arguments& arguments) {
  return {.method = arguments.text("method", "automatic"),
          .tolerance = arguments.number("tol", 1e-6),
          .repeats = arguments.integer("repeat", 5)};
}

JsonLine& Run::add_to(JsonLine& line, const Setting& setting) const {
  return line.add("method", setting.method)
      .add("tol", setting.tolerance)
      .add("steps", done.steps)
      .add("rejected", done.rejected)
      .add("evaluations", done.evaluations)
      .add("factorizations", done.factorizations)
      .add("cpu_seconds", seconds);
}

Run simulate(const System& system, const Setting& setting, const State& start, double end) {
  return cheapest(setting.repeats, [&] {
    const auto integrator = make_method(setting.method, setting.tolerance);
    Simulation simulation{system, *integrator};
    Run run{.end = start};
    const double started = cpu_seconds();
    simulation.run(run.end, end);
    run.seconds = cpu_seconds() - started;
    run.done = simulation.statistics();
    return run;
  });
}

Run follow(const System& system, const Setting& setting, const State& start, const std::vector<double>& times,
           const Look& look) {
  return cheapest(setting.repeats, [&] {
    const auto integrator = make_method(setting.method, setting.tolerance);
    Evaluator equations(system);
    Run run{.end = start};
    State &state = run.end, before = state, between = state;
    const double started = cpu_seconds();
    integrator->start(equations, state);
    size_t row = 0;
    while (row < times.size()) {
      before = state;
      const StepResult result = integrator->step(equations, state, times.back());
      if (!result.ok()) throw std::runtime_error(result.why);
      for (; row < times.size() && times[row] <= state.time; ++row) {
        integrator->interpolate(system.layout(), before, state, times[row], between);
        look(static_cast<int>(row), between);
      }
    }
    run.seconds = cpu_seconds() - started;
    run.done = integrator->statistics();
    return run;
  });
}

std::vector<std::vector<double>> read_numbers(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::vector<double> row;
    for (double value; words >> value;) row.push_back(value);
    rows.push_back(std::move(row));
  }
  if (rows.empty()) throw std::runtime_error("no numbers in " + path);
  return rows;
}

ChainError chain_error(const System& system, const State& state, const std::vector<Marker>& ends,
                       const std::string& reference) {
  const auto points = read_numbers(reference);
  if (points.size() != ends.size()) throw std::runtime_error(reference + " is of a chain of another length");
  Evaluator evaluator(system);
  evaluator.evaluate(state.time, state.q, state.v, Level::position);
  ChainError error;
  for (size_t i = 0; i < ends.size(); ++i) {
    const Vector3 there(points[i].at(0), 0, points[i].at(1));
    error.tip = (marker_kinematics(evaluator, ends[i], Level::position).p - there).norm();
    error.joint = std::max(error.joint, error.tip);
  }
  return error;
}

}  // namespace lithe::bench
