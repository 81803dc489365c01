#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "engine/assembly/system.h"
#include "engine/motion/make_integrator.h"
#include "engine/observe/sensors.h"
#include "engine/run/simulation.h"
#include "engine/study/study.h"

namespace lithe {

/// What a functional mock-up unit is made of: a scene, whose inputs become its inputs and parameters and whose sensors
/// become its outputs, and the integrator that moves it in co-simulation.
struct FmuModel {
  StudyScene scene;
  MakeIntegrator integrator;
  std::string token;  // that importers give to show which FMU they mean
};

/// A variable as importers see it; its place in the list is its value reference.
struct FmuVariable {
  enum class Role { time, input, parameter, output };
  std::string name, unit, description;
  Role role = Role::time;
  double start = 0;  // of inputs and parameters, as their bounds
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
  bool held = false;  // between communication points
};

/// One instance of an FMU for co-simulation: a drawing, a simulation and a state of its own, nothing shared. The C
/// functions of FMI 2.0 and 3.0 (engine/fmu/fmi2_border.h, fmi3_border.h) are made of it. A step is, bit for bit,
/// Simulation::run() to the end of the step with inputs set as below; save() and load() are a checkpoint.
///   held inputs and parameters   input.reset(t, value) at the communication point t
///   linear, smooth inputs        reach the value at the end of the step: input.reset(t, present), input.set(t + h,
///   value)
/// Not for several threads at once; several instances may each have one.
class FmuInstance {
 public:
  /// Draws the scene and assembles it. Throws SceneError as these do, and where a name would be used twice.
  explicit FmuInstance(const FmuModel& model);
  ~FmuInstance();

  const std::vector<FmuVariable>& variables() const { return variables_; }
  double time() const { return state_.time; }

  /// As after construction.
  void reset();
  /// The time to start at, with the values that inputs have then.
  void begin(double start);
  /// Throws SceneError for a reference that does not exist; SimulationError for a value that is not finite.
  double get(unsigned reference);
  /// Throws SceneError for what is no input or parameter, and for a value that it must not have.
  void set(unsigned reference, double value);
  /// From the communication point `current` by `size`. Throws SceneError for a size that is not positive and another
  /// point than the one reached, SimulationError where the run fails; the state is then the last good one.
  void step(double current, double size);

  /// All that later steps depend on, and a number of the caller's.
  std::vector<unsigned char> save(int mode);
  /// Into any instance of the same FMU, in another process too; returns the number. Throws FileError for bytes that are
  /// damaged or of something else; the instance is then as reset() leaves it.
  int load(const unsigned char* bytes, std::size_t size);
  /// Throws FileError for bytes that load() would refuse unread.
  static void check_saved(const unsigned char* bytes, std::size_t size);

 private:
  int input_of(unsigned reference) const;
  void apply_inputs(double time);
  Snapshot& look();

  const FmuModel& model_;
  SystemGraph graph_;
  std::vector<Sensor> sensors_;
  std::unique_ptr<const System> system_;
  std::unique_ptr<Integrator> integrator_;
  std::unique_ptr<Simulation> simulation_;
  std::unique_ptr<Snapshot> snapshot_;
  std::vector<FmuVariable> variables_;
  std::vector<std::pair<int, int>> outputs_;  // sensor, column

  State state_;
  bool started_ = false;     // steps have been made
  bool inputs_set_ = false;  // since the last step
  bool evaluated_ = false;
  double start_ = 0;
  std::vector<double> given_;  // of each input, by the importer
};

/// Variables, scene and version as JSON, from which `lithe fmu` writes a description.
std::string fmu_facts(const FmuModel& model);

}  // namespace lithe
