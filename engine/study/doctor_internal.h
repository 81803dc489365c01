#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/observe/snapshot.h"
#include "engine/study/doctor.h"

/// The doctor's instruments.
namespace lithe::doctor {

std::string number(double value);                   // three digits
std::string bodies_of(const Connector& connector);  // "'wheel' and ground"

/// M and G of a state, dense; and what they say of ranks.
struct DenseRows {
  MatrixX mass, jacobian;       // all rows
  std::vector<int> kept;        // rows that are not redundant
  VectorX singular_values;      // of those rows of G M^-1/2, each brought to length 1
  VectorX weakest;              // shares of the kept rows in the smallest
  int weakest_row = -1;         // the largest of them
  double conditioning() const;  // smallest over largest; 1 without rows
};
inline constexpr int kMaxDense = 600;  // velocities
DenseRows dense_rows(const System& system, const State& state);

/// What rings or decays fast: an elastic coordinate by itself, or a force element with its stiffest row and the mass
/// that this row moves with all joints in place.
struct Rate {
  std::string name;                                  // "'spring' between 'wheel' and ground"
  double frequency = 0, damping = 0, stiffness = 0;  // rad/s; 1/s; N/m or N m/rad
  double largest() const { return std::max(frequency, damping); }
};
std::vector<Rate> fastest_rates(const System& system, const State& state);  // the fastest first

/// What a force element does to its bodies, all of its markers.
VectorX force_values(Snapshot& now, const ForceElement& force);

/// One run of a method, watched.
struct Watched {
  bool reached = false, too_slow = false;
  std::string why, integrator;                                                     // it ended early
  std::vector<double> times;                                                       // of all steps
  std::vector<State> samples;                                                      // up to 64, evenly among the steps
  std::vector<State> dips;                                                         // at the ends of the shortest steps
  State last, before;                                                              // the last two good states
  double first_energy = 0, largest_energy = 0, largest_kinetic = 0, residual = 0;  // J; units of the rows
  /// Of the multipliers in the last steps, in their own size: 1 if their sign alternates.
  double zigzag = 0;
  std::map<int, long> limiting;  // how often each velocity limited a step
  IntegratorStatistics statistics;
  std::vector<double> watch_at_end;  // the scene's sensors
  double median_step() const;
  bool rejected_often() const { return statistics.rejected > 10 && 20 * statistics.rejected > statistics.steps; }
};
Watched run_watched(const System& system, const std::vector<Sensor>& sensors, const State& start, double duration,
                    Integrator& integrator, const DiagnoseOptions& options);

/// A scene drawn, and assembled.
struct Drawn {
  explicit Drawn(const StudyScene& scene) : graph({.gravity = scene.gravity}), sensors(scene.draw(graph)) {}
  void assemble() { system = std::make_unique<System>(lithe::assemble(graph)); }
  SystemGraph graph;
  std::vector<Sensor> sensors;
  std::unique_ptr<System> system;
};

/// Why a scene does not assemble.
Finding of_refused_scene(Drawn& drawn, const SceneError& error);

/// A run beside one with a finer setting.
struct Case {
  const Drawn& drawn;
  const StudyScene& scene;
  const StudyMethod& method;
  const DiagnoseOptions& options;
  const Watched &run, &finer;
  bool conservative = false;
  bool is_explicit() const { return run.statistics.newton_iterations == 0; }
  /// The multipliers alternate, with smaller steps as well: no aliasing of a motion.
  bool zigzags() const { return !is_explicit() && run.zigzag > 0.1 && finer.zigzag > 0.7 * run.zigzag; }
  double step() const { return method.setting == StudyMethod::Setting::step ? options.setting : run.median_step(); }
  /// Rise of the energy, in the largest kinetic energy.
  double growth(const Watched& of) const;
  /// Largest difference of what is watched at the end, in characteristic lengths; 0 if one of them did not get there.
  double difference(const Watched& a, const Watched& b) const;
  bool degraded() const;
};
double finer_setting(const StudyMethod& method, double setting);
std::string setting_words(const StudyMethod& method, double setting);  // "at h = 0.001 s", "at tolerance 1e-06"
/// Largest |∂g/∂t| of each row at a few times: the rows of drives.
VectorX drive_rates(const System& system);
/// Whether nothing feeds energy in: no drive, no force that works without a potential, in the states given.
bool is_conservative(const System& system, const std::vector<State>& states);
std::vector<Finding> of_run(const Case& c);

// The causes that of_run asks for, each empty or with findings of one kind.
std::vector<Finding> find_no_number(const Case& c);
std::vector<Finding> find_jumps(const Case& c);
std::vector<Finding> find_rank_loss(const Case& c);
std::vector<Finding> find_stiffness(const Case& c);
std::vector<Finding> find_instability(const Case& c);
std::vector<Finding> find_inaccuracy(const Case& c);

}  // namespace lithe::doctor
