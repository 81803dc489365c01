#include "models/fmu/imported_fmu.h"

#include <cmath>
#include <set>

#include "engine/archive/archive.h"
#include "engine/base/number_text.h"
#include "engine/run/simulation.h"
#include "models/fmu/fmu_file_internal.h"

namespace lithe {
namespace {

constexpr double kSameInterval = 1e-6;  // of the interval: points apart by it, but for round-off of times

}  // namespace

ImportedFmu::ImportedFmu(const std::string& path, Parameters parameters)
    : parameters_(std::move(parameters)),
      file_(std::make_unique<FmuFile>(path, FmuKind::co_simulation, parameters_.name)) {
  const double known = file_->contents().default_step;
  if (parameters_.interval == 0) parameters_.interval = known;
  if (!(parameters_.interval > 0) || !std::isfinite(parameters_.interval))
    file_->refuse("the interval is " + number_text(parameters_.interval) + " s" +
                      (known > 0 ? "" : ", and the FMU names no default"),
                  "give .interval, the time between communication points, above 0");
  std::set<std::string> connected;
  for (const FromSensor& wire : parameters_.inputs) {
    inputs_.push_back(file_->find(wire.variable, FmuFile::Role::input));
    if (!connected.insert(wire.variable).second)
      file_->refuse("its input '" + wire.variable + "' is connected twice", "keep one of the two sensors");
    if (wire.column < 0 || wire.column >= static_cast<int>(wire.sensor.columns().size()))
      file_->refuse("its input '" + wire.variable + "' takes column " + std::to_string(wire.column) +
                        " of a sensor that has " + std::to_string(wire.sensor.columns().size()),
                    "count columns from 0");
  }
  std::set<const Input*> driven;
  for (const ToInput& wire : parameters_.outputs) {
    outputs_.push_back(file_->find(wire.variable, FmuFile::Role::output));
    if (!wire.input) file_->refuse("its output '" + wire.variable + "' goes to no Input", "give the address of one");
    if (!driven.insert(wire.input).second)
      file_->refuse("two of its outputs go to the input '" + wire.input->name() + "'", "keep one of the two");
  }
  for (const auto& [name, number] : parameters_.values) file_->find_parameter(name, number);
  make_instance();  // a binary that cannot be loaded is told here
}

ImportedFmu::~ImportedFmu() = default;

const std::string& ImportedFmu::name() const { return file_->name(); }

void ImportedFmu::make_instance() {
  library_.reset();  // some binaries allow one instance at a time
  library_ = file_->make_instance();
  fresh_ = true;
}

void ImportedFmu::join(Simulation& simulation) { simulation.observe(*this, every(parameters_.interval)); }

void ImportedFmu::read_sensors(Snapshot& snapshot) {
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const FromSensor& wire = parameters_.inputs[i];
    const double value = wire.sensor.value(snapshot, wire.column);
    if (!std::isfinite(value))
      throw SimulationError("sensor '" + wire.sensor.name() + "' reads " + number_text(value) +
                                " for the FMU's input '" + wire.variable + "' at " + time_text(snapshot.time()) + ".",
                            "FMU '" + name() + "'", "look at the sensor.");
    library_->set(inputs_[i], value);
  }
}

void ImportedFmu::begin(Snapshot& snapshot) {
  if (!library_ || !fresh_) make_instance();
  fresh_ = false;
  time_ = clock_ = snapshot.time();
  for (const auto& [name, value] : parameters_.values) library_->set(file_->find_parameter(name, value), value);
  library_->enter_initialization(time_);
  read_sensors(snapshot);
  library_->exit_initialization();
  hand_over(time_, true);
}

void ImportedFmu::hand_over(double time, bool first) {
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    const double value = this->value(parameters_.outputs[i].variable, outputs_[i]);
    Input& input = *parameters_.outputs[i].input;
    if (first) {
      input.reset(time, value);
    } else if (input.between() == Input::Between::held) {
      input.set(time, value);
    } else {
      input.reset(time, input.value(time));
      input.set(time + interval(), value);
    }
  }
}

void ImportedFmu::observe(Snapshot& snapshot) {
  const double time = snapshot.time();
  if (library_ && begun_ && time == time_) return;
  try {
    if (!begun_ || time < time_) {
      begun_ = false;
      begin(snapshot);
      begun_ = true;
      return;
    }
    if (!library_)
      throw SimulationError("the FMU failed before and cannot go on.", "",
                            "run again from the start, or resume a checkpoint.");
    read_sensors(snapshot);
    double size = time - time_;
    if (std::abs(size - interval()) < kSameInterval * interval()) size = interval();
    library_->step(clock_, size);
    time_ = time, clock_ += size;
    hand_over(time, false);
  } catch (const SimulationError& error) {
    library_.reset();
    throw SimulationError(error.problem(), "FMU '" + name() + "', " + time_text(time), error.fix());
  }
}

double ImportedFmu::value(const std::string& name) const { return value(name, file_->find(name, FmuFile::Role::any)); }

double ImportedFmu::value(const std::string& name, const FmuNumber& asked) const {
  if (fresh_) return asked.variable->start(asked.entry);
  if (!library_)
    throw SimulationError("the FMU failed: '" + name + "' has no value.", "FMU '" + this->name() + "'",
                          "run again from the start, or resume a checkpoint.");
  return file_->checked(name, library_->get(asked));
}

Sensor ImportedFmu::sensor(const std::string& variable, Located as) const {
  const FmuNumber asked = file_->find(variable, FmuFile::Role::any);
  if (as.text.empty()) as.text = variable;
  const std::string column = as.text;
  return Sensor(std::move(as), {column},
                [this, variable, asked](Snapshot&, std::span<double> out) { out[0] = value(variable, asked); },
                {asked.variable->unit});
}

std::string ImportedFmu::describe() const {
  const FmuContents& contents = file_->contents();
  std::string out = file_->title() + "; every " + number_text(interval()) + " s" +
                    (contents.serializes ? "" : "; it cannot give its state: no checkpoints") + "\n";
  for (const ImportedVariable& v : contents.variables) {
    std::string is;
    for (std::size_t i = 0; i < inputs_.size(); ++i)
      if (const FromSensor& wire = parameters_.inputs[i]; inputs_[i].variable == &v)
        is += FmuFile::entry(wire.variable, v) + " from sensor '" + wire.sensor.columns()[wire.column] + "'";
    for (std::size_t i = 0; i < outputs_.size(); ++i)
      if (const ToInput& wire = parameters_.outputs[i]; outputs_[i].variable == &v)
        is += FmuFile::entry(wire.variable, v) + " to input '" + wire.input->name() + "'";
    is += file_->values_of(v, parameters_.values, !is.empty());
    if (!is.empty() || v.causality == "input" || v.causality == "output")
      out += FmuFile::line(v, is.empty() ? ", not connected" : is);
  }
  return out;
}

void ImportedFmu::history(Archive& archive) {
  archive.group("fmu", [&] {
    archive("begun", begun_);
    archive("time", time_);
    archive("clock", clock_);
    file_->history(archive, library_, begun_);
  });
  if (archive.loads()) fresh_ = !begun_;
}

}  // namespace lithe
