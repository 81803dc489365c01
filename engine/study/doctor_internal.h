#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/assembly/evaluator.h"
#include "engine/assembly/reached_state.h"
#include "engine/base/number_text.h"
#include "engine/observe/snapshot.h"
#include "engine/study/doctor.h"

/// The doctor's instruments.
namespace lithe::doctor {

inline std::string number(double value) { return three_digits(value); }
std::string bodies_of(const Connector& connector);  // "'wheel' and ground"

/// What the rows of G M^-1/2 that are not redundant, each brought to length 1, say of ranks at a state; M with the
/// inertia of each body over its mass. Sparse: its cost grows with the scene as that of its factors does.
struct RowRanks {
  std::vector<int> kept;             // the rows, numbers in lambda
  double smallest = 1, largest = 1;  // singular values
  VectorX weakest;                   // shares of the kept rows in the smallest
  int weakest_row = -1;              // the largest of them; -1: no rows, or not finite
  double conditioning() const { return smallest / largest; }
};
RowRanks row_ranks(const System& system, const State& state);

/// Adds Jᵀ W of one marker to a force on the velocities.
void add_wrench(const Layout& layout, const Marker& marker, const MarkerKinematics& k, const Wrench& w, VectorX& force);
/// Evaluated at a state, M and G factorised.
std::unique_ptr<Evaluator> factorized(const System& system, const State& state);

/// What rings or decays fast: an elastic coordinate by itself, or a force element with its stiffest row and the mass
/// that this row moves with all joints in place.
struct Rate {
  std::string name;                                  // "'spring' between 'wheel' and ground"
  const ForceElement* force = nullptr;               // null: an elastic coordinate
  double frequency = 0, damping = 0, stiffness = 0;  // rad/s; 1/s; N/m or N m/rad
  bool pulls = false;                                // one row, along the line between two markers
  double largest() const { return std::max(frequency, damping); }
};
std::vector<Rate> fastest_rates(const System& system, const State& state);  // the fastest first

/// What a force element does to its bodies, all of its markers.
VectorX force_values(Snapshot& now, const ForceElement& force);

/// One run of a method, watched.
struct Watched {
  bool reached = false, too_slow = false;
  std::string why, integrator;                                       // it ended early
  std::vector<double> times;                                         // of all steps
  std::vector<State> samples;                                        // up to 64, evenly among the steps
  std::vector<State> dips;                                           // at the ends of the shortest steps
  State last, before;                                                // the last two good states
  double first_energy = 0, largest_energy = 0, largest_kinetic = 0;  // J
  double residual = 0, residual_time = 0;  // largest |g|, redundant rows too, in their units; s
  int residual_row = -1;
  /// An angle that moved by more than half a turn between two steps.
  struct LostTurns {
    JointCoordinate angle;
    std::string name;  // of the connector that measures it
    long turns = 0;
    double time = 0, step = 0, rate = 0;  // of the first: s, s, rad/s
  };
  std::map<int, LostTurns> lost_turns;  // by the place in State::quarter_turns
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

std::string quoted(const std::string& name);
/// How far bodies are from each other, and markers from the frames of their bodies, m.
double reach_of(const System& system, const State& start);
/// Of a body with a frame.
struct BodyInertia {
  const Layout::BodySlice* slice;
  double mass;
  Vector3 principal;  // ascending
  double gyration() const { return std::sqrt(principal[2] / mass); }
  /// Of the box with that mass and inertia; at most 1.13 times that of the densest stuff in the body.
  double density() const;
};
std::vector<BodyInertia> inertias(const System& system, const State& start);

// What look_over() looks at.
void look_at_rank(const System& system, const State& start, std::vector<Finding>& out);
void look_for_locked_modes(const System& system, const State& start, std::vector<Finding>& out);
void look_at_elements(const System& system, const State& start, double length, std::vector<Finding>& out);

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
/// g or ġ of a state, all rows.
VectorX rows_at(const System& system, double time, const State& state, Level level);
/// Largest |∂g/∂t| of each row at a few times: the rows of drives.
VectorX drive_rates(const System& system);
/// Whether nothing feeds energy in: no drive, no force that works without a potential, in the states given.
bool is_conservative(const System& system, const std::vector<State>& states);
/// What went wrong with a run that failed or degraded.
std::vector<Finding> of_run(const Case& c);
/// What is wrong with the motion of a run, however well it went.
std::vector<Finding> of_motion(const Case& c);

// The causes that of_run asks for, each empty or with findings of one kind.
std::vector<Finding> find_no_number(const Case& c);
std::vector<Finding> find_jumps(const Case& c);
std::vector<Finding> find_rank_loss(const Case& c);
std::vector<Finding> find_stiffness(const Case& c);
std::vector<Finding> find_instability(const Case& c);
std::vector<Finding> find_inaccuracy(const Case& c);

}  // namespace lithe::doctor
