#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/model/joint_coordinate.h"
#include "engine/model/motion_law.h"
#include "engine/model/system_graph.h"
#include "engine/observe/observer.h"
#include "engine/observe/sensors.h"

namespace lithe {

class FmuForce;
class FirstOrderStates;
class Simulation;
struct FmuNumber;

/// A component of another tool whose equations are part of the scene, an FMU for model exchange (FMI 2.0 or 3.0): a
/// controller, a motor, a valve,
///   ż = f(t, z, u),  y = g(t, z, u).
/// Its states z are integrated together with the scene, by the scene's own method. Its inputs u read joint coordinates,
/// their rates and functions of time, its outputs y push joint coordinates (N or N m, positive as the coordinate
/// grows):
///   ModelExchangeFmu drive(graph, "drive", "drive.fmu", {.inputs = {{"angle", hinge.angle()},
///                                                          {"speed", hinge.angle(), ModelExchangeFmu::Reads::rate}},
///                                               .laws = {{"target", ramp(0, 0.5)}},
///                                               .outputs = {{"torque", hinge.angle()}}});
///   System system = assemble(graph);
///   Simulation simulation{system, integrator};
///   drive.join(simulation);
/// State events, time events and events after steps are located and handled by the run, whose events() name them; the
/// states may jump there. The FMU is initialized at the run's first time with the inputs of its first state; the states
/// begin as the FMU gives them with the inputs' start values. Implicit methods have its derivatives: the FMU's own if
/// it gives directional derivatives, else central differences. Where the FMU discards a trial state, the integrator
/// tries a smaller step. Two markers a coordinate and one for three states are at most 256. Up to 8 are one force
/// element; more are several, and implicit methods then have all derivatives but those of directions.
class ModelExchangeFmu final : public Observer {
 public:
  enum class Reads { value, rate };
  struct FromCoordinate {
    std::string variable;  // a continuous input of the FMU; of an array name[i], i from 1, row by row
    JointCoordinate coordinate;
    Reads reads = Reads::value;
  };
  struct FromLaw {
    std::string variable;
    MotionLaw law;  // its value; an Input of the scene too
  };
  struct ToCoordinate {
    std::string variable;  // a continuous output of the FMU
    JointCoordinate coordinate;
  };
  struct Parameters {
    std::vector<FromCoordinate> inputs{};
    std::vector<FromLaw> laws{};
    std::vector<ToCoordinate> outputs{};
    std::vector<std::pair<std::string, double>> values{};  // of parameters and inputs, at the start
  };
  /// Unpacks the FMU, makes an instance and adds its states and its force to the graph, which keeps them, as
  /// "name states" and "name" (and "name part 2" ...). Throws
  /// FileError for a file that is no FMU, is damaged, leads out of its folder, is not for model exchange, or has no
  /// binary for this platform; SceneError for variables that it does not have, of another causality or type or that
  /// are no single numbers, inputs connected twice, more coordinates and states than there is room for, and a name
  /// that is in use; SimulationError where the FMU refuses its values.
  ModelExchangeFmu(SystemGraph& graph, Located name, const std::string& path, Parameters parameters);

  const std::string& name() const;
  /// Looks for the FMU's events in the simulation's runs, and follows its steps. Throws SceneError where it has joined
  /// one before, several islands run, or a simpler scene.
  void join(Simulation& simulation);
  /// Starts anew with the next run: needed before a run that starts earlier than the FMU's last event.
  void reset();

  /// A variable of the FMU at the states that are observed. Throws SceneError for one that does not exist or is no
  /// single number; reading it SimulationError if the FMU gives what is not finite, or at a state before its last
  /// event.
  Sensor sensor(const std::string& variable, Located name = "") const;
  /// What it is and how it is connected, a line a variable.
  std::string describe() const;

  void observe(Snapshot& snapshot) override;
  /// Throws SceneError for an FMU that cannot give its state.
  void history(Archive& archive) override;

 private:
  void read(Snapshot& snapshot) const;
  void change(State& state);

  const Parameters parameters_;
  FmuForce* force_ = nullptr;  // the graph's
  const FirstOrderStates* states_ = nullptr;
  std::optional<Snapshot> at_event_;  // of the simulation joined
};

}  // namespace lithe
