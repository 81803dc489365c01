#include "joints/control/control_force.h"

#include <algorithm>

#include "engine/base/number_text.h"
#include "engine/model/marker_motions.h"
#include "engine/model/system_graph.h"
#include "engine/run/simulation.h"
#include "joints/forces/coordinate_effort.h"

namespace lithe {
namespace {

// What one part of a large diagram pushes, by two markers each, and how many states it drives.
constexpr int kOutputsOfPart = kMaxMarkers / 2, kStatesOfPart = kMaxRows;

int parts_for(int count, int of_part) { return (count + of_part - 1) / of_part; }

}  // namespace

ControlForce::ControlForce(Parameters parameters)
    : program_(parameters.diagram.program()),
      coordinates_(program_.coordinates),
      points_(FirstOrderStates::points_for(static_cast<int>(program_.states.size()))),
      part_(parameters.part) {
  program_.sort();
  const int outputs = static_cast<int>(program_.outputs.size()), states = static_cast<int>(program_.states.size());
  const std::string size =
      std::to_string(coordinates_.count()) + " coordinates and " + std::to_string(states) + " states are more than ";
  if (marker_count() > kMostMarkers)
    throw SceneError(size + "there is room for", "", "draw several diagrams, each with at most 128 coordinates");
  if (part_ < 0) {
    if (part_count() > 1)
      throw SceneError(size + "one element has room for", "",
                       "draw the diagram by add_control(graph, name, diagram, states)");
    outputs_.count = outputs, states_.count = states;
    return;
  }
  const auto range = [](int part, int of_part, int all) {
    const int first = std::min(part * of_part, all);
    return Range{first, std::min(of_part, all - first)};
  };
  const int by_outputs = parts_for(outputs, kOutputsOfPart);
  if (part_ < by_outputs)
    outputs_ = range(part_, kOutputsOfPart, outputs);
  else
    states_ = range(part_ - by_outputs, kStatesOfPart, states);
  if (part_ == 0) return;  // it has the sensors, and looks at all signals
  std::vector<int> nodes;
  for (int k = outputs_.first; k < outputs_.first + outputs_.count; ++k) nodes.push_back(program_.outputs[k].node);
  for (int i = states_.first; i < states_.first + states_.count; ++i) nodes.push_back(program_.states[i].rate);
  program_.keep(nodes);
}

int ControlForce::part_count() const {
  if (marker_count() <= kMaxMarkers) return 1;
  return std::max(2, parts_for(static_cast<int>(program_.outputs.size()), kOutputsOfPart) +
                         parts_for(static_cast<int>(program_.states.size()), kStatesOfPart));
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

void ControlForce::act(const Point& at, std::span<const MarkerView> markers, ForceRows& rows) const {
  // 1. The markers that it acts on.
  int acting[kMaxMarkers], count = 0;
  const int of_points = 2 * outputs_.count;
  for (int k = outputs_.first; k < outputs_.first + outputs_.count; ++k) {
    acting[count++] = 2 * program_.outputs[k].coordinate;
    acting[count++] = 2 * program_.outputs[k].coordinate + 1;
  }
  for (int i = 0; i < states_.count; i += 3) acting[count++] = 2 * coordinates_.count() + (states_.first + i) / 3;
  rows.act_on({acting, static_cast<std::size_t>(count)});
  const auto open = [&] {
    Wrench* W = rows.open();
    std::fill_n(W, count, Wrench{Vector3::Zero(), Vector3::Zero()});
    return W;
  };
  // 2. A row for each number.
  double slopes[kMostInputs];
  for (int k = 0; k < outputs_.count; ++k) {
    const auto& [coordinate, node] = program_.outputs[outputs_.first + k];
    program_.differentiate(at.signals, node, slopes);
    const MeasuredCoordinate x = coordinates_.measure(coordinate, markers, rows);
    Wrench* W = open() + 2 * k;
    W[0] = x.on_A, W[1] = x.on_B;
    rows.finish(-at.signals.value[node], -slopes[2 * coordinate], -slopes[2 * coordinate + 1]);
  }
  for (int i = 0; i < states_.count; ++i) {
    open()[of_points + i / 3] = force(Vector3::Unit(i % 3));
    rows.finish(-at.signals.value[program_.states[states_.first + i].rate], 0, 0);
  }
}

void ControlForce::evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const {
  Point at;
  read(time, markers, rows, at);
  if (!joined_ && part_ <= 0 && time > 0)
    for (const ControlProgram::Relay& relay : program_.relays)
      if (program_.is_due(relay, at.signals))
        throw SimulationError("relay '" + program_.nodes[relay.node].name + "' has to switch at " + time_text(time) +
                                  ", and no simulation looks for that.",
                              "", "call join(simulation, state) of this element before the run.");
  if (part_ >= 0) return act(at, markers, rows);
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

// ---- of any size ----

ControlForce& add_control(SystemGraph& graph, const Located& name, const ControlDiagram& diagram,
                          const FirstOrderStates& states) {
  const std::vector<Marker> markers = diagram.markers(states);
  const bool large = static_cast<int>(markers.size()) > kMaxMarkers;
  auto& first = graph.add<ControlForce>(name, markers, {diagram, large ? 0 : -1});
  for (int part = 1; part < first.part_count(); ++part)
    graph.add<ControlForce>(Located(name.text + " part " + std::to_string(part + 1), name.where), markers,
                            {diagram, part});
  return first;
}

}  // namespace lithe
