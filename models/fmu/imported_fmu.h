#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/model/input.h"
#include "engine/observe/observer.h"
#include "engine/observe/sensors.h"

namespace lithe {

class FmuFile;
class FmuLibrary;
class Simulation;
struct FmuNumber;

/// A component of another tool, an FMU for co-simulation (FMI 2.0 or 3.0), that runs beside a scene: a controller, an
/// actuator, a motion. Its inputs are sensors of the scene, its outputs go to Inputs of the scene, which motors, loads
/// and drives take:
///   ImportedFmu servo("servo.fmu", {.interval = 1e-3, .inputs = {{"angle", joint_value(hinge.angle())}},
///                                   .outputs = {{"torque", &torque}}, .values = {{"gain", 40}}});
///   servo.join(simulation);
///   simulation.run(state, 5);
/// At each communication point t the scene is at t first; then the FMU reads the sensors there, moves from the point
/// before to t with these values, and its outputs hold from t on. Outputs to linear or smooth inputs reach their value
/// one interval later, so that drives do not jump. A run that starts anew starts the FMU anew.
/// Checkpoints hold its state, if it can give it: a resumed run has the same bits. Not for several simulations at once.
class ImportedFmu final : public Observer {
 public:
  struct FromSensor {
    std::string variable;  // an input of the FMU
    Sensor sensor;
    int column = 0;  // of the sensor
  };
  struct ToInput {
    std::string variable;  // an output of the FMU
    Input* input;
  };
  struct Parameters {
    double interval = 0;  // s, between communication points; 0: the FMU's own default
    std::vector<FromSensor> inputs{};
    std::vector<ToInput> outputs{};
    std::vector<std::pair<std::string, double>> values{};  // of parameters and inputs, at the start
    std::string name{};                                    // for messages; empty: the model's
  };
  /// Unpacks the FMU and makes an instance. Throws FileError for a file that is no FMU, is damaged, leads out of its
  /// folder, or has no binary for this platform; SceneError for variables that it does not have, of another causality
  /// or that are no single numbers (of an array, name[i] is one: i from 1, row by row), inputs and outputs connected
  /// twice, and where no interval is known.
  ImportedFmu(const std::string& path, Parameters parameters);
  ~ImportedFmu() override;

  const std::string& name() const;
  double interval() const { return parameters_.interval; }
  /// Adds it to the simulation's observers, at its interval.
  void join(Simulation& simulation);

  /// A variable's value as it is now; before a run, its start value. Throws SceneError for one that does not exist or
  /// is no single number; SimulationError if the FMU fails, or gives what is not finite.
  double value(const std::string& variable) const;
  /// The same as a sensor: between communication points it stays.
  Sensor sensor(const std::string& variable, Located name = "") const;
  /// What it is and how it is connected, a line a variable.
  std::string describe() const;

  /// Throws SimulationError, with the time, where the FMU gives an error or a value that is not finite; the simulation
  /// ends there with its state kept.
  void observe(Snapshot& snapshot) override;
  /// Throws SceneError for an FMU that cannot give its state.
  void history(Archive& archive) override;

 private:
  double value(const std::string& name, const FmuNumber& asked) const;
  void make_instance();
  void begin(Snapshot& snapshot);
  void read_sensors(Snapshot& snapshot);
  void hand_over(double time, bool first);

  Parameters parameters_;
  const std::unique_ptr<FmuFile> file_;
  std::unique_ptr<FmuLibrary> library_;  // null before the first state, and after a failure
  std::vector<FmuNumber> inputs_, outputs_;
  bool fresh_ = false;  // the instance has not been initialized
  bool begun_ = false;  // it is in a run
  double time_ = 0;     // of the last communication point, s
  double clock_ = 0;    // the same as the FMU counts it, step by step
};

}  // namespace lithe
