#include "models/fmu/model_exchange_fmu.h"

#include <cmath>
#include <set>

#include "engine/archive/archive.h"
#include "engine/model/marker_motions.h"
#include "engine/run/simulation.h"
#include "joints/forces/first_order_states.h"
#include "models/fmu/fmu_force_internal.h"

namespace lithe {
namespace {

bool same(const JointCoordinate& a, const JointCoordinate& b) {
  return a.kind == b.kind && a.A == b.A && a.B == b.B && a.axis == b.axis && a.sign == b.sign;
}

/// The variables that wires of one side name, arrays as a whole, one after the other.
class Connected {
 public:
  explicit Connected(const FmuFile& file, FmuFile::Role role) : file_(file), role_(role) {}

  /// Where the number that a wire names stands among theirs.
  int place(const std::string& name) {
    const FmuNumber number = file_.find(name, role_);
    const ImportedVariable& v = *number.variable;
    if (v.type != "Float64" || v.variability != "continuous")
      file_.refuse(
          "'" + name + "' is a " + v.variability + " " + v.type + "; a scene connects continuous Float64 (Real)",
          "use another variable, or give it a value at the start");
    int first = 0;
    for (const ImportedVariable* other : variables) {
      if (other == &v) return first + number.entry;
      first += other->size;
    }
    variables.push_back(&v);
    return first + number.entry;
  }
  std::vector<unsigned> references() const {
    std::vector<unsigned> out;
    for (const ImportedVariable* v : variables) out.push_back(v->reference);
    return out;
  }
  VectorX starts() const {
    std::vector<double> out;
    for (const ImportedVariable* v : variables)
      for (int i = 0; i < v->size; ++i) out.push_back(v->start(i));
    return Eigen::Map<const VectorX>(out.data(), static_cast<Eigen::Index>(out.size()));
  }

  std::vector<const ImportedVariable*> variables;

 private:
  const FmuFile& file_;
  const FmuFile::Role role_;
};

}  // namespace

ModelExchangeFmu::ModelExchangeFmu(SystemGraph& graph, Located name, const std::string& path, Parameters parameters)
    : parameters_(std::move(parameters)) {
  auto file = std::make_unique<const FmuFile>(path, FmuKind::model_exchange, name.text);
  // 1. The wires.
  std::vector<JointCoordinate> coordinates;
  const auto coordinate_place = [&](const JointCoordinate& c) {
    const auto at = std::find_if(coordinates.begin(), coordinates.end(), [&](const auto& x) { return same(x, c); });
    const auto place = static_cast<int>(at - coordinates.begin());
    if (at == coordinates.end()) coordinates.push_back(c);
    return place;
  };
  Connected inputs(*file, FmuFile::Role::input), outputs(*file, FmuFile::Role::output);
  FmuWires wires{CoordinateSet({}), {}, {}};
  std::set<int> connected;
  const auto connect = [&](const std::string& variable, int coordinate, bool rate, const MotionLaw& law) {
    const int place = inputs.place(variable);
    if (!connected.insert(place).second) file->refuse("its input '" + variable + "' is connected twice", "keep one");
    wires.inputs.push_back({place, coordinate, rate, law});
  };
  for (const FromCoordinate& wire : parameters_.inputs)
    connect(wire.variable, coordinate_place(wire.coordinate), wire.reads == Reads::rate, {});
  for (const FromLaw& wire : parameters_.laws) {
    if (!wire.law) file->refuse("its input '" + wire.variable + "' has no law", "give one, as in constant(1)");
    connect(wire.variable, -1, false, wire.law);
  }
  for (const ToCoordinate& wire : parameters_.outputs)
    wires.outputs.push_back({outputs.place(wire.variable), coordinate_place(wire.coordinate)});
  wires.coordinates = CoordinateSet(coordinates);
  // 2. Their values at the start.
  ExchangeEquations::Parameters p{.values = parameters_.values,
                                  .connected = {inputs.references(), outputs.references()},
                                  .inputs = inputs.starts()};
  for (const auto& [variable, value] : parameters_.values)
    if (const FmuNumber number = file->find_parameter(variable, value); number.variable->causality == "input")
      if (std::find(inputs.variables.begin(), inputs.variables.end(), number.variable) != inputs.variables.end())
        p.inputs[inputs.place(variable)] = value;
  for (const ImportedVariable* v : outputs.variables) {
    p.output_count += v->size;
    p.differentiable &= v->causality == "output";
  }
  // 3. The elements.
  const int states = file->contents().state_count;
  wires.points = FirstOrderStates::points_for(states);
  if (wires.marker_count() > kMostMarkers)
    file->refuse(std::to_string(wires.coordinates.count()) + " coordinates and " + std::to_string(states) +
                     " states are more than there is room for",
                 "connect fewer coordinates, use several FMUs, or one for co-simulation (ImportedFmu)");
  auto equations = std::make_unique<ExchangeEquations>(std::move(file), std::move(p));
  const MatrixX jacobian = equations->jacobian(/*time=*/0);
  for (FmuWires::Out& out : wires.outputs)
    for (const FmuWires::In& in : wires.inputs)
      if (const double by = jacobian(states + out.place, states + in.place);
          in.coordinate == out.coordinate && std::isfinite(by))
        (in.rate ? out.by_rate : out.by_value) += by;
  auto& body =
      graph.add<FirstOrderStates>(Located(name.text + " states", name.where), {.start = equations->initial_states()});
  std::vector<Marker> markers = wires.coordinates.markers();
  for (int i = 0; i < wires.points; ++i) markers.push_back(body.point(i));
  const std::vector<FmuWires::Part> parts = wires.parts(states);
  std::optional<FmuWires::Part> first;
  if (!parts.empty()) first = parts[0];
  force_ = &graph.add<FmuForce>(name, markers, {.equations = std::move(equations), .wires = wires, .part = first});
  for (std::size_t i = 1; i < parts.size(); ++i)
    graph.add<FmuForce>(Located(name.text + " part " + std::to_string(i + 1), name.where), markers,
                        {.first = force_, .wires = wires, .part = parts[i]});
  states_ = &body;
}

const std::string& ModelExchangeFmu::name() const { return force_->equations().file().name(); }

void ModelExchangeFmu::reset() {
  const auto lock = force_->equations().lock();
  force_->equations().reset();
}

/// Brings z and u of the equations to a snapshot; under their lock.
void ModelExchangeFmu::read(Snapshot& now) const {
  const MarkerMotions motions(force_->markers(), [&](const Marker& m) { return now.marker(m); });
  ForceRows memory(force_->marker_count());
  memory.recall(now.quarter_turns_of(*force_));
  force_->wires().read(now.time(), motions, memory, force_->equations().z, force_->equations().u);
}

void ModelExchangeFmu::join(Simulation& simulation) {
  ExchangeEquations& fmu = force_->equations();
  if (at_event_) fmu.file().refuse("it has joined a simulation before", "draw another scene with another one");
  const auto watch = [&](const std::string& what, auto function) {
    simulation.on({.name = name() + ": " + what,
                   .function =
                       [this, function](Snapshot& now) {
                         const auto lock = force_->equations().lock();
                         read(now);
                         return function(force_->equations(), now.time());
                       },
                   .action = Event::Action::restart,
                   .change = [this](State& state) { change(state); }});
  };
  for (int i = 0; i < fmu.file().contents().indicator_count; ++i)
    watch("state event " + std::to_string(i + 1),
          [i](ExchangeEquations& of, double time) { return of.indicators(time)[i]; });
  watch("time event", [](ExchangeEquations& of, double time) { return of.until_time_event(time); });
  simulation.observe(*this, every_step());
  at_event_.emplace(simulation.system());
  fmu.join();
}

void ModelExchangeFmu::change(State& state) {
  ExchangeEquations& fmu = force_->equations();
  at_event_->evaluate(state);  // its forces take the lock
  const auto lock = fmu.lock();
  read(*at_event_);
  fmu.handle_event(state.time);
  const auto& slices = at_event_->system().layout().bodies();
  const auto slice = std::find_if(slices.begin(), slices.end(), [&](const auto& s) { return s.body == states_; });
  for (int i = 0; i < fmu.state_count(); ++i) state.v[slice->v + FirstOrderStates::place(i)] = fmu.z[i];
  // The integrals of the states mean nothing, and dense output of the short steps that follow has their round-off.
  for (int i = 0; i < states_->point_count(); ++i) state.q.segment<3>(slice->q + 7 * i).setZero();
}

void ModelExchangeFmu::observe(Snapshot& now) {
  ExchangeEquations& fmu = force_->equations();
  const auto lock = fmu.lock();
  read(now);
  fmu.see(now.time());
}

Sensor ModelExchangeFmu::sensor(const std::string& variable, Located as) const {
  const FmuNumber asked = force_->equations().file().find(variable, FmuFile::Role::any);
  if (as.text.empty()) as.text = variable;
  const std::string column = as.text;
  return Sensor(std::move(as), {column},
                [this, variable, asked](Snapshot& now, std::span<double> out) {
                  ExchangeEquations& fmu = force_->equations();
                  const auto lock = fmu.lock();
                  read(now);
                  out[0] = fmu.value(now.time(), variable, asked);
                },
                {asked.variable->unit});
}

std::string ModelExchangeFmu::describe() const {
  const FmuFile& file = force_->equations().file();
  const FmuContents& contents = file.contents();
  std::string out = file.title() + "; " + std::to_string(contents.state_count) + " states, " +
                    std::to_string(contents.indicator_count) + " event indicators" +
                    (contents.serializes ? "" : "; it cannot give its state: no checkpoints") + "\n";
  for (const ImportedVariable& v : contents.variables) {
    std::string is;
    const auto add = [&](const std::string& variable, const std::string& what) {
      if (file.find(variable, FmuFile::Role::any).variable == &v) is += FmuFile::entry(variable, v) + what;
    };
    for (const FromCoordinate& w : parameters_.inputs)
      add(w.variable, std::string(w.reads == Reads::rate ? " from the rate of" : " from") + " a coordinate");
    for (const FromLaw& w : parameters_.laws) add(w.variable, " from a function of time");
    for (const ToCoordinate& w : parameters_.outputs) add(w.variable, " to a coordinate");
    is += file.values_of(v, parameters_.values, !is.empty());
    if (!is.empty() || v.causality == "input" || v.causality == "output")
      out += FmuFile::line(v, is.empty() ? ", not connected" : is);
  }
  return out;
}

void ModelExchangeFmu::history(Archive& archive) {
  ExchangeEquations& fmu = force_->equations();
  const auto lock = fmu.lock();
  archive.group("fmu", [&] { fmu.history(archive); });
}

}  // namespace lithe
