#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/coupled_markers.h"
#include "engine/model/force_element.h"
#include "engine/observe/sensors.h"
#include "joints/control/control_diagram.h"

namespace lithe {

class Simulation;
class SystemGraph;

/// A control diagram in a scene: evaluates its signals, drives its states and pushes its coordinates,
///   ż = f(t, z, x, ẋ),   F_i = u_i(t, z, x, ẋ)
/// The derivatives of all signals are exact but those of functions. The coordinates, and the states three in one, are
/// markers of it. One element has room for one coordinate and up to 18 states, two and 12, three and 6, four and none;
/// add_control() draws larger diagrams as several, each of which reads all markers and acts on a part of them by rows.
class ControlForce final : public ForceElement, public CoupledMarkers {
 public:
  struct Parameters {
    const ControlDiagram& diagram;  // copied
    int part = -1;                  // of a large diagram, from 0: add_control() gives it; -1: all of a small one
  };
  /// Throws SceneError for an algebraic loop, signals that are not closed, states without derivative, more coordinates,
  /// states and signals than there is room for, and a large diagram without a part.
  explicit ControlForce(Parameters parameters);

  /// Of the diagram: 1 if one element has room for it. The first of several has the sensors and joins the run.
  int part_count() const;
  bool is_whole() const { return part_ < 0; }
  bool is_first() const { return part_ <= 0; }

  int marker_count() const override { return 2 * coordinates_.count() + points_; }
  int row_count() const override { return outputs_.count + (part_ < 0 ? 0 : states_.count); }
  std::vector<MeasuredAngle> angles() const override { return coordinates_.angles(); }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;

  /// A signal as the states that are observed have it.
  Sensor sensor(ControlSignal signal, Located name, const std::string& unit = "") const;
  /// Switches relays at events of the simulation, which its events() name, and ends steps at the corners of limits,
  /// dead bands and tables. `state`, that of the start, gets its relays as its signals say. A diagram with relays needs
  /// it: without, a relay that has to switch is a SimulationError. Throws SceneError as Simulation::on(), and where
  /// relays set one another off without end.
  void join(Simulation& simulation, State& state);

 private:
  friend class LinearControl;
  friend class WideControl;
  static constexpr int kMostInputs = 4 * kMostMarkers;  // values and rates of coordinates, states
  struct Point {
    double z[3 * kMostMarkers], x[kMostMarkers];
    ControlProgram::Signals signals;
  };
  struct Range {
    int first = 0, count = 0;
  };
  void read(double time, std::span<const MarkerView> markers, const AngleMemory& memory, Point& at) const;
  void measure(std::span<const MarkerView> markers, const AngleMemory& memory, double* z, double* x) const;
  void read(Snapshot& now, Point& at) const;
  /// `own`: of each output, its slopes by value and rate of its own coordinate, which become a row; the rest is a load.
  void act(std::span<const MarkerView> markers, const double* rates, const double* efforts, const double* own,
           ForceRows& rows) const;
  /// What this part does, all of it by rows.
  void act(const Point& at, std::span<const MarkerView> markers, ForceRows& rows) const;
  /// Switches a relay (null: none) on or off, then what has to switch after it.
  void settle(const System& system, State& state, const ControlProgram::Relay* relay, bool on) const;

  ControlProgram program_;
  const CoordinateSet coordinates_;
  const int points_, part_;
  Range outputs_, states_;  // on which it acts
  bool joined_ = false;
};

/// Adds a diagram of any size, as one element or as several, "<name> part 2" and so on; returns the first. A sensor of
/// its power or of the force on a marker is of that part alone. Up to 128 coordinates, less one for six states.
ControlForce& add_control(SystemGraph& graph, const Located& name, const ControlDiagram& diagram,
                          const FirstOrderStates& states);

template <>
std::unique_ptr<ForceBatch> make_force_batch<ControlForce>();

}  // namespace lithe
