#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/assembly/system.h"
#include "engine/output/table.h"
#include "engine/study/study.h"

namespace lithe {

/// A scene of a study, drawn and assembled once. Its runs share it, since a System does not change; each has an
/// integrator and a state of its own.
class StudySystem {
 public:
  /// Throws SceneError: nothing to draw, nothing watched, a duration or characteristic length that is not positive, and
  /// whatever drawing and assembling throw.
  explicit StudySystem(const StudyScene& scene);
  StudySystem(const StudySystem&) = delete;
  StudySystem& operator=(const StudySystem&) = delete;

  const StudyScene& scene() const { return scene_; }
  const System& system() const { return *system_; }
  const std::vector<Sensor>& sensors() const { return sensors_; }
  std::vector<std::string> columns() const;  // of all sensors

 private:
  StudyScene scene_;
  SystemGraph graph_;
  std::vector<Sensor> sensors_;
  std::unique_ptr<const System> system_;
};

/// What one run of a method came to.
struct StudyRun {
  enum class Outcome { reached, failed, too_slow } outcome = Outcome::failed;
  std::string why;  // it did not reach the end; empty if it did
  Table samples;    // "t", then the columns of the sensors, at the instants asked for; as far as it came
  double cpu = 0;   // s of this thread: start and steps, not the looking
  IntegratorStatistics statistics{};
};

/// How a run gets its samples: by dense output within steps of the method's own length, where the method is at its
/// best; or by steps that end at every instant.
enum class Sampling { dense, stops };

/// Runs from t = 0 to the last of `times` (rising, the first > 0) and reads the sensors at each. A run that takes more
/// than `time_limit` seconds of CPU is stopped. `why` says what stopped it; nothing is thrown.
StudyRun run_study(const StudySystem& study, const StudyMethod& method, double setting,
                   const std::vector<double>& times, double time_limit, Sampling sampling = Sampling::stops);

/// Largest difference of two sets of samples over instants and sensors, in units of the scene's characteristic length:
/// of a sensor with several columns the Euclidean norm, so that it does not depend on the axes.
double largest_difference(const StudySystem& study, const Table& a, const Table& b);

/// CPU time of this thread, s.
double thread_seconds();
/// "tolerance 1e-5", "h = 2 ms".
std::string setting_text(StudyMethod::Setting kind, double setting);
/// "0.8 ms", "12 µs": a time in the unit that suits it, three digits.
std::string duration_text(double seconds);

}  // namespace lithe
