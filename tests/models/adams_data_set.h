#pragma once

#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/run/simulation.h"
#include "models/draw_model.h"
#include "models/read_model.h"
#include "tests/models/scratch_folder.h"
#include "tests/support/methods.h"

/// Adams data sets as text, drawn.
namespace lithe::test::adams_test {

inline const char* const kHead =
    "title\n"
    "UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND\n"
    "PART/1, GROUND\nMARKER/1, PART=1\n";
/// A body of 2 kg, its centre (marker 20) at (0.3, 0.1, -0.2), turned; marker 21 off it, marker 11 on ground.
inline const char* const kBody =
    "PART/2, MASS=2, CM=20, IP=0.03,0.04,0.05, QG=0.3,0.1,-0.2, REULER=20D,30D,-10D\n"
    ", VX=0.3, VY=-0.2, VZ=0.1, WX=0.4, WY=0.5, WZ=-0.3\n"
    "MARKER/20, PART=2\nMARKER/21, PART=2, QP=0.05,-0.1,0.15, REULER=5D,-8D,12D\n"
    "MARKER/11, PART=1, QP=0.1,0.2,0.05, REULER=-10D,15D,6D\n";

/// A model from its text, drawn; sensors of its outputs at its start.
struct Scene {
  ScratchFolder folder;
  ModelDescription model;
  SystemGraph graph;
  DrawnModel drawn;

  explicit Scene(const std::string& statements)
      : model(read_model(folder.write("m.adm", kHead + statements + "END\n"))),
        graph({.gravity = model.gravity}),
        drawn(draw_model(graph, model)) {}

  const Sensor& output(const std::string& name) const {
    for (const Sensor& sensor : drawn.outputs())
      if (sensor.name() == name) return sensor;
    throw SceneError("no output " + name, "", "");
  }
  double start(const std::string& name, int column = 0) {
    const System system = assemble(graph);
    const State state = system.initial_state();
    Snapshot now(system, state);
    return output(name).value(now, column);
  }
  /// REQUEST/1 after a run.
  std::vector<double> after(double end) {
    const System system = assemble(graph);
    const Method method = runge_kutta8(1e-10);
    Simulation simulation(system, *method);
    State state = system.initial_state();
    simulation.run(state, end);
    Snapshot now(system, state);
    const Sensor& request = output("REQUEST/1");
    std::vector<double> values;
    for (int i = 0; i < static_cast<int>(request.columns().size()); ++i) values.push_back(request.value(now, i));
    return values;
  }
  /// Accelerations of PART/2 at the start: p̈, ω̇.
  Vector6 acceleration() {
    const System system = assemble(graph);
    const State state = system.initial_state();
    Snapshot now(system, state);
    return now.acceleration(drawn.adams_marker(20));
  }
};

inline double value(const std::string& function, const std::string& more = "") {
  return Scene(kBody + more + "VARIABLE/1, FUNCTION=" + function + "\n").start("VARIABLE/1");
}

}  // namespace lithe::test::adams_test
