#include "joints/control/control_force.h"

#include <algorithm>

#include "engine/assembly/linearized_batch.h"
#include "engine/base/number_text.h"
#include "engine/model/marker_motions.h"
#include "engine/run/simulation.h"
#include "joints/forces/coordinate_effort.h"

namespace lithe {

ControlForce::ControlForce(Parameters parameters)
    : program_(parameters.diagram.program()),
      coordinates_(program_.coordinates),
      points_(FirstOrderStates::points_for(static_cast<int>(program_.states.size()))) {
  program_.sort();
  if (marker_count() > kMaxMarkers)
    throw SceneError(std::to_string(coordinates_.count()) + " coordinates and " +
                         std::to_string(program_.states.size()) + " states are more than there is room for",
                     "", "draw several diagrams: one coordinate and up to 18 states, two and 12, three and 6");
}

void ControlForce::measure(std::span<const MarkerView> markers, const AngleMemory& memory, double* z, double* x) const {
  for (int i = 0; i < coordinates_.count(); ++i) {
    const MeasuredCoordinate c = coordinates_.measure(i, markers, memory);
    x[2 * i] = c.value, x[2 * i + 1] = c.rate;
  }
  const auto at = markers.subspan(2 * static_cast<std::size_t>(coordinates_.count()));
  for (std::size_t i = 0; i < program_.states.size(); ++i) z[i] = at[i / 3].v[static_cast<int>(i % 3)];
}

void ControlForce::read(double time, std::span<const MarkerView> markers, const AngleMemory& memory, Point& at) const {
  measure(markers, memory, at.z, at.x);
  program_.evaluate(time, at.z, at.x, at.signals);
}

void ControlForce::act(std::span<const MarkerView> markers, const double* rates, const double* efforts,
                       const double* own, ForceRows& rows) const {
  for (std::size_t i = 0; i < program_.states.size(); ++i)
    rows.add_load(markers[2 * static_cast<std::size_t>(coordinates_.count()) + i / 3],
                  force(rates[i] * Vector3::Unit(static_cast<int>(i % 3))));
  for (std::size_t k = 0; k < program_.outputs.size(); ++k)
    push_coordinate(coordinates_, program_.outputs[k].coordinate, {efforts[k], own[2 * k], own[2 * k + 1]}, markers,
                    rows);
}

void ControlForce::evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const {
  Point at;
  read(time, markers, rows, at);
  if (!joined_ && time > 0)
    for (const ControlProgram::Relay& relay : program_.relays)
      if (program_.is_due(relay, at.signals))
        throw SimulationError("relay '" + program_.nodes[relay.node].name + "' has to switch at " + time_text(time) +
                                  ", and no simulation looks for that.",
                              "", "call join(simulation, state) of this element before the run.");
  double rates[3 * kMaxMarkers], efforts[kMaxMarkers], own[2 * kMaxMarkers], slopes[5 * kMaxMarkers];
  for (std::size_t i = 0; i < program_.states.size(); ++i) rates[i] = at.signals.value[program_.states[i].rate];
  for (std::size_t k = 0; k < program_.outputs.size(); ++k) {
    const auto& [coordinate, node] = program_.outputs[k];
    efforts[k] = at.signals.value[node];
    program_.differentiate(at.signals, node, slopes);
    own[2 * k] = slopes[2 * coordinate], own[2 * k + 1] = slopes[2 * coordinate + 1];
  }
  act(markers, rates, efforts, own, rows);
}

// ---- Newton's matrix ----

/// The element with its signals made linear at one state: differences over it are exact, and do not evaluate blocks.
class LinearControl final : public ForceElement {
 public:
  LinearControl(const ControlForce& control, double time, std::span<const MarkerView> markers,
                const AngleMemory& memory)
      : control_(control) {
    const ControlProgram& program = control.program_;
    ControlForce::Point at;
    control.read(time, markers, memory, at);
    states_ = static_cast<int>(program.states.size()), in_ = 2 * control.coordinates_.count();
    std::copy_n(at.x, in_, inputs_);
    std::copy_n(at.z, states_, inputs_ + in_);
    for (const ControlProgram::State& state : program.states) add(program, at, state.rate);
    for (std::size_t k = 0; k < program.outputs.size(); ++k) {
      const auto& [coordinate, node] = program.outputs[k];
      const double* slopes = add(program, at, node);
      own_[2 * k] = slopes[2 * coordinate], own_[2 * k + 1] = slopes[2 * coordinate + 1];
    }
  }

  int marker_count() const override { return control_.marker_count(); }
  int row_count() const override { return control_.row_count(); }
  void evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const override {
    double moved[kWidth], out[kWidth];
    control_.measure(markers, rows, moved + in_, moved);
    for (int k = 0; k < in_ + states_; ++k) moved[k] -= inputs_[k];
    for (int i = 0; i < count_; ++i) {
      out[i] = value_[i];
      for (int k = 0; k < in_ + states_; ++k) out[i] += slopes_[i][k] * moved[k];
    }
    control_.act(markers, out, out + states_, own_, rows);
  }

 private:
  static constexpr int kWidth = 5 * kMaxMarkers;
  const double* add(const ControlProgram& program, const ControlForce::Point& at, int node) {
    value_[count_] = at.signals.value[node];
    program.differentiate(at.signals, node, slopes_[count_]);
    return slopes_[count_++];
  }

  const ControlForce& control_;
  int states_ = 0, in_ = 0, count_ = 0;
  double inputs_[kWidth], value_[kWidth], slopes_[kWidth][kWidth], own_[2 * kMaxMarkers];
};

template <>
std::unique_ptr<ForceBatch> make_force_batch<ControlForce>() {
  return std::make_unique<LinearizedForceBatch<ControlForce, LinearControl>>();
}

// ---- what a run sees ----

void ControlForce::read(Snapshot& now, Point& at) const {
  const MarkerMotions motions(markers(), [&](const Marker& m) { return now.marker(m); });
  ForceRows memory(marker_count());
  memory.recall(now.quarter_turns_of(*this));
  read(now.time(), motions, memory, at);
}

Sensor ControlForce::sensor(ControlSignal signal, Located name, const std::string& unit) const {
  if (signal.node < 0 || signal.node >= static_cast<int>(program_.nodes.size()))
    throw SceneError("'" + this->name() + "' has no such signal", to_string(name.where), "give one of its diagram");
  const std::string column = name.text;
  return Sensor(std::move(name), {column},
                [this, node = signal.node](Snapshot& now, std::span<double> out) {
                  Point at;
                  read(now, at);
                  out[0] = at.signals.value[node];
                },
                {unit});
}

void ControlForce::join(Simulation& simulation, State& state) {
  const System& system = simulation.system();
  const auto watch = [&](const std::string& what, Event::Direction direction, auto function,
                         std::function<void(State&)> change) {
    simulation.on({.name = name() + ": " + what,
                   .function =
                       [this, function](Snapshot& now) {
                         Point at;
                         read(now, at);
                         return function(at.signals);
                       },
                   .direction = direction,
                   .action = Event::Action::restart,
                   .change = std::move(change)});
  };
  // A relay's level counts while it can switch there; then the function stays clear of zero.
  for (const ControlProgram::Relay& relay : program_.relays) {
    const std::string& what = program_.nodes[relay.node].name;
    watch(
        what, Event::Direction::rising,
        [&relay](const auto& s) { return s.value[relay.node] > 0.5 ? -1 : s.value[relay.input] - relay.upper; },
        [this, &relay, &system](State& at) { settle(system, at, &relay, true); });
    watch(
        what, Event::Direction::falling,
        [&relay](const auto& s) { return s.value[relay.node] > 0.5 ? s.value[relay.input] - relay.lower : 1; },
        [this, &relay, &system](State& at) { settle(system, at, &relay, false); });
  }
  for (const ControlNode& node : program_.nodes)
    for (const ControlNode::Corner& corner : node.corners)
      watch(node.name + " at " + number_text(corner.level), Event::Direction::both,
            [corner](const auto& s) { return s.value[corner.input] - corner.level; }, {});
  joined_ = true;
  settle(system, state, nullptr, false);
}

void ControlForce::settle(const System& system, State& state, const ControlProgram::Relay* relay, bool on) const {
  if (program_.relays.empty()) return;
  const auto& slices = system.layout().bodies();
  const Body* body = markers()[2 * static_cast<std::size_t>(coordinates_.count())].body;
  const auto slice = std::find_if(slices.begin(), slices.end(), [&](const auto& s) { return s.body == body; });
  const ControlProgram::Relay* const first = relay;  // it lies at its level, but for round-off
  for (std::size_t tried = 0; tried <= program_.relays.size(); ++tried) {
    if (relay) state.v[slice->v + FirstOrderStates::place(relay->state)] = on ? 1 : 0;
    Snapshot now(system, state);
    Point at;
    read(now, at);
    const auto due = std::find_if(program_.relays.begin(), program_.relays.end(), [&](const auto& other) {
      return &other != first && program_.is_due(other, at.signals);
    });
    if (due == program_.relays.end()) return;
    relay = &*due, on = at.signals.value[due->node] < 0.5;
  }
  throw SimulationError("its relays set one another off without end at " + time_text(state.time) + ".", where(),
                        "give them hysteresis: lower below upper.");
}

}  // namespace lithe
