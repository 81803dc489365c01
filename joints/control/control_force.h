#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/force_element.h"
#include "engine/observe/sensors.h"
#include "joints/control/control_diagram.h"

namespace lithe {

class Simulation;

/// A control diagram in a scene: evaluates its signals, drives its states and pushes its coordinates,
///   ż = f(t, z, x, ẋ),   F_i = u_i(t, z, x, ẋ)
/// The derivatives of all signals are exact but those of functions. The coordinates, and the states three in one, are
/// markers of it, at most 8: one coordinate and up to 18 states, two and 12, three and 6, four and none; split what has
/// more, and read states of one diagram in another as rates of coordinates (ControlDiagram::push).
class ControlForce final : public ForceElement {
 public:
  struct Parameters {
    const ControlDiagram& diagram;  // copied
  };
  /// Throws SceneError for an algebraic loop, signals that are not closed, states without derivative, and more
  /// coordinates, states and signals than there is room for.
  explicit ControlForce(Parameters parameters);

  int marker_count() const override { return 2 * coordinates_.count() + points_; }
  int row_count() const override { return static_cast<int>(program_.outputs.size()); }
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
  struct Point {
    double z[3 * kMaxMarkers], x[2 * kMaxMarkers];
    ControlProgram::Signals signals;
  };
  void read(double time, std::span<const MarkerView> markers, const AngleMemory& memory, Point& at) const;
  void measure(std::span<const MarkerView> markers, const AngleMemory& memory, double* z, double* x) const;
  void read(Snapshot& now, Point& at) const;
  /// `own`: of each output, its slopes by value and rate of its own coordinate, which become a row; the rest is a load.
  void act(std::span<const MarkerView> markers, const double* rates, const double* efforts, const double* own,
           ForceRows& rows) const;
  /// Switches a relay (null: none) on or off, then what has to switch after it.
  void settle(const System& system, State& state, const ControlProgram::Relay* relay, bool on) const;

  ControlProgram program_;
  const CoordinateSet coordinates_;
  const int points_;
  bool joined_ = false;
};

template <>
std::unique_ptr<ForceBatch> make_force_batch<ControlForce>();

}  // namespace lithe
