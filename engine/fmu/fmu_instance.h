#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/assembly/system.h"
#include "engine/fmu/fmu_equations.h"
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

/// One instance of an FMU: a drawing and a state of its own, nothing shared. The C functions of FMI 2.0 and 3.0
/// (engine/fmu/fmi2_border.h, fmi3_border.h) are made of it.
/// In co-simulation it has a simulation. A step is, bit for bit, Simulation::run() to the end of the step with inputs
/// set as below; save() and load() are a checkpoint.
///   held inputs and parameters   input.reset(t, value) at the communication point t
///   linear, smooth inputs        reach the value at the end of the step: input.reset(t, present), input.set(t + h,
///   value)
/// Within a step, where Intermediate is told of t, held inputs are set by input.set(t, value), and linear ones bend:
///   input.reset(t, present), input.set(end of the step, value)
/// In model exchange it has equations (FmuEquations), and an input is what has been set last. What is asked depends on
/// the time, states and inputs set, and on the last completed step, not on what was asked before.
/// Not for several threads at once; several instances may each have one.
class FmuInstance {
 public:
  enum class Form { co_simulation, model_exchange };
  /// Told after each step of the integrator within a communication step, where inputs may be set; returns whether to
  /// end that one here.
  using Intermediate = std::function<bool(double time)>;
  /// Draws the scene and assembles it. Throws SceneError as these do, where a name would be used twice, and for model
  /// exchange of a scene that has no such form.
  explicit FmuInstance(const FmuModel& model, Form form = Form::co_simulation, Intermediate intermediate = {});
  ~FmuInstance();

  Form form() const { return form_; }
  const std::vector<FmuVariable>& variables() const { return variables_; }
  /// Throws SceneError for a reference that does not exist.
  const FmuVariable& variable(unsigned reference) const;
  /// Why there is no model exchange; empty: there is.
  const std::string& refusal() const { return refusal_; }
  /// In Intermediate that of the step told of, which get() answers for.
  double time() const;

  /// As after construction.
  void reset();
  /// The time to start at, with the values that inputs have then, and the relative tolerance with which an importer
  /// integrates (0: not known). Throws SceneError for what is not finite.
  void begin(double start, double tolerance = 0);
  /// Throws SceneError for a reference that does not exist; SimulationError for a value that is not finite.
  double get(unsigned reference);
  /// Jumping, linear and smooth inputs have the value now, as before the first step, at events and in model exchange,
  /// instead of at the end of the next step. Throws SceneError for what is no input or parameter, for a value that it
  /// must not have, and in Intermediate for a smooth input, which would have to start from rest there.
  void set(unsigned reference, double value, bool jumps = true);

  /// From the communication point `current` by `size`, or to where Intermediate ends it. Throws SceneError for a size
  /// that is not positive and another point than the one reached, SimulationError where the run fails; the state is
  /// then the last good one. Returns whether it has ended early.
  bool step(double current, double size);

  // ---- model exchange ----
  const FmuEquations& equations() const { return *equations_; }
  /// Throws SceneError for a time that is not finite.
  void set_time(double time);
  /// Throws SimulationError for what is not finite; the states are then those before.
  void set_states(std::span<const double> x);
  const VectorX& states() const { return x_; }
  /// Both throw SimulationError where the equations have no solution.
  const VectorX& derivatives();
  void indicators(std::span<double> values);
  /// A step has led here: whether it has drifted off the constraints, so that update() is to be called.
  bool complete_step();
  /// At an event: moves what has drifted back onto the constraints, and takes note on which side of each kink the state
  /// is. Whether states have changed. Throws SimulationError where constraints cannot be met.
  bool update();
  /// Σ ∂unknown/∂known · seed over the knowns, for each unknown; states and inputs are known, all else can be unknown.
  /// Central differences of fourth order: relative errors of some 1e-9 where the scene is smooth. Throws SceneError for
  /// other variables, SimulationError as derivatives().
  void directional_derivative(std::span<const unsigned> unknowns, std::span<const unsigned> knowns,
                              std::span<const double> seed, std::span<double> sensitivity);
  /// Σ seed · ∂unknown/∂known over the unknowns, for each known.
  void adjoint_derivative(std::span<const unsigned> unknowns, std::span<const unsigned> knowns,
                          std::span<const double> seed, std::span<double> sensitivity);

  /// All that later steps depend on, and a number of the caller's.
  std::vector<unsigned char> save(int mode);
  /// Into any instance of the same FMU and form, in another process too; returns the number. Throws FileError for bytes
  /// that are damaged or no state, SceneError for those of another FMU or form; the instance is then as reset() leaves
  /// it.
  int load(const unsigned char* bytes, std::size_t size);
  /// Throws FileError for bytes that load() would refuse unread.
  static void check_saved(const unsigned char* bytes, std::size_t size);

 private:
  /// Every step of the simulation, as Intermediate wants it.
  class Steps;
  void apply_inputs(double time);
  void set_within_step(Input& input, double value);
  Snapshot& look();
  void history(Archive& archive);

  const FmuModel& model_;
  const Form form_;
  SystemGraph graph_;
  std::vector<Sensor> sensors_;
  std::unique_ptr<const System> system_;
  std::string refusal_;
  std::unique_ptr<const FmuEquations> equations_;  // null: refused
  std::unique_ptr<Integrator> integrator_;         // null, as the simulation: model exchange
  std::unique_ptr<Simulation> simulation_;
  std::unique_ptr<Snapshot> snapshot_;
  std::unique_ptr<Steps> steps_;  // null: nobody asks
  Snapshot* seen_ = nullptr;      // while Intermediate is told
  std::vector<FmuVariable> variables_;
  std::vector<std::pair<int, int>> outputs_;  // sensor, column

  State state_;
  bool started_ = false;     // steps have been made
  bool inputs_set_ = false;  // since the last step, in Intermediate since the last one told of
  bool evaluated_ = false;   // the snapshot is of the state
  double start_ = 0, tolerance_ = 0;
  double end_ = 0;   // of the communication step
  double told_ = 0;  // the last time that Intermediate need not be told: of the communication point, of a step
  std::vector<double> given_;  // of each input, by the importer
  VectorX x_;                  // states as given: quaternions of any norm
  VectorX rates_;              // of the snapshot; empty: not asked for
  std::vector<int> sides_;     // of kinks, at the last event
};

/// Variables, scene and version as JSON, from which `lithe fmu` writes a description.
std::string fmu_facts(const FmuModel& model);

}  // namespace lithe
