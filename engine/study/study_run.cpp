#include "engine/study/study_run.h"

#include <cmath>
#include <ctime>

#include "engine/assembly/evaluator.h"
#include "engine/base/number_text.h"
#include "engine/observe/snapshot.h"

namespace lithe {
namespace {

constexpr int kStepsBetweenLooks = 16;  // at the clock: a system call, dearer than a small scene's step

std::string at_time(double time) { return "t = " + short_number(time) + " s: "; }

/// One run on its way: steps on the clock, looks beside it.
class Runner {
 public:
  Runner(const StudySystem& study, Integrator& integrator, StudyRun& run)
      : study_(study),
        integrator_(integrator),
        run_(run),
        equations_(study.system()),
        snapshot_(study.system()),
        state_(study.system().initial_state()),
        row_(run.samples.columns.size()) {}

  void go(const std::vector<double>& times, double time_limit, Sampling sampling) {
    double begun = thread_seconds();
    const auto pause = [&] { run_.cpu += thread_seconds() - begun; };
    integrator_.start(equations_, state_);
    std::size_t next = 0;
    for (long i = 1; next < times.size(); ++i) {
      from_ = state_;
      const StepResult result =
          integrator_.step(equations_, state_, sampling == Sampling::stops ? times[next] : times.back());
      if (!result.ok() || !(state_.time > from_.time)) {
        run_.why = at_time(from_.time) + (result.ok() ? "a step did not move time" : result.why);
        return pause();
      }
      if (i % kStepsBetweenLooks == 0 && run_.cpu + thread_seconds() - begun > time_limit) {
        run_.outcome = StudyRun::Outcome::too_slow;
        run_.why = "stopped at t = " + short_number(state_.time) + " s after " + duration_text(time_limit) + " of CPU";
        return pause();
      }
      if (state_.time < times[next]) continue;
      pause();
      for (; next < times.size() && times[next] <= state_.time; ++next)
        if (!look(times[next])) return;
      begun = thread_seconds();
    }
    run_.outcome = StudyRun::Outcome::reached;
  }

 private:
  /// Reads the sensors at a time within the last step; false, with the reason, for a value that is not finite.
  bool look(double time) {
    if (time < state_.time) {
      integrator_.interpolate(study_.system().layout(), from_, state_, time, within_);
      snapshot_.evaluate(within_);
    } else {
      snapshot_.evaluate(state_);
    }
    row_[0] = time;
    std::size_t at = 1;
    for (const Sensor& sensor : study_.sensors()) {
      sensor.evaluate(snapshot_, std::span<double>(row_).subspan(at, sensor.columns().size()));
      at += sensor.columns().size();
    }
    for (std::size_t i = 0; i < row_.size(); ++i)
      if (!std::isfinite(row_[i])) {
        run_.why = at_time(time) + "'" + run_.samples.columns[i] + "' is not finite";
        return false;
      }
    run_.samples.add_row(row_);
    return true;
  }

  const StudySystem& study_;
  Integrator& integrator_;
  StudyRun& run_;
  Evaluator equations_;
  Snapshot snapshot_;
  State state_, from_, within_;
  std::vector<double> row_;
};

}  // namespace

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

StudySystem::StudySystem(const StudyScene& scene) : scene_(scene), graph_({.gravity = scene.gravity}) {
  const auto refuse = [&](const std::string& what, const std::string& fix) {
    throw SceneError("the study '" + scene.name + "' " + what, "StudyScene '" + scene.name + "'", fix);
  };
  if (!scene.draw) refuse("draws nothing", "let draw(graph) add bodies and joints, and return what is watched");
  if (!(scene.duration > 0)) refuse("has no duration", "set duration, in seconds");
  if (!(scene.characteristic_length > 0))
    refuse("has no characteristic length", "set characteristic_length: the unit that errors are measured in");
  sensors_ = scene.draw(graph_);
  if (sensors_.empty())
    refuse("watches nothing", "return sensors from draw(graph): positions of markers, coordinates, energies");
  system_ = std::make_unique<const System>(assemble(graph_));
}

std::vector<std::string> StudySystem::columns() const {
  std::vector<std::string> names;
  for (const Sensor& sensor : sensors_) names.insert(names.end(), sensor.columns().begin(), sensor.columns().end());
  return names;
}

StudyRun run_study(const StudySystem& study, const StudyMethod& method, double setting,
                   const std::vector<double>& times, double time_limit, Sampling sampling) {
  StudyRun run;
  run.samples.columns = study.columns();
  run.samples.columns.insert(run.samples.columns.begin(), "t");
  try {
    const auto integrator = method.make(setting);
    Runner(study, *integrator, run).go(times, time_limit, sampling);
    run.statistics = integrator->statistics();
  } catch (const Error& error) {  // a start that is not possible, a setting that the method refuses: the run's result
    run.outcome = StudyRun::Outcome::failed;
    run.why = error.problem();
  }
  return run;
}

double largest_difference(const StudySystem& study, const Table& a, const Table& b) {
  double largest = 0;
  for (int row = 0; row < a.row_count(); ++row) {
    int column = 1;
    for (const Sensor& sensor : study.sensors()) {
      double squares = 0;
      for (std::size_t i = 0; i < sensor.columns().size(); ++i, ++column)
        squares += std::pow(a.at(row, column) - b.at(row, column), 2);
      largest = std::max(largest, std::sqrt(squares));
    }
  }
  return largest / study.scene().characteristic_length;
}

std::string duration_text(double seconds) {
  const struct {
    double size;
    const char* name;
  } units[] = {{1, " s"}, {1e-3, " ms"}, {1e-6, " µs"}};
  for (const auto& unit : units)
    if (seconds >= 0.9995 * unit.size) return short_number(seconds / unit.size) + unit.name;
  return short_number(seconds / 1e-9) + " ns";
}

std::string setting_text(StudyMethod::Setting kind, double setting) {
  return kind == StudyMethod::Setting::step ? "h = " + duration_text(setting) : "tolerance " + short_number(setting);
}

}  // namespace lithe
