#include "models/fmu/imported_fmu.h"

#include <cmath>
#include <cstring>
#include <set>

#include "engine/archive/archive.h"
#include "engine/base/number_text.h"
#include "engine/plugin/plugin_type.h"
#include "engine/run/simulation.h"
#include "models/fmu/fmu_contents_internal.h"
#include "models/fmu/fmu_library_internal.h"
#include "models/fmu/fmu_package_internal.h"

namespace lithe {
namespace {

constexpr double kSameInterval = 1e-6;  // of the interval: points apart by it, but for round-off of times

std::unique_ptr<FmuContents> contents_of(const FmuPackage& package) {
  const auto description = package.folder() / "modelDescription.xml";
  if (!std::filesystem::is_regular_file(description))
    throw FileError("the archive has no modelDescription.xml.", package.path(), "give an FMU.");
  try {
    return std::make_unique<FmuContents>(read_fmu_contents(description.string()));
  } catch (const FileError& error) {  // where it lies unpacked is nobody's business
    std::string where = error.where();
    const std::string folder = package.folder().string() + "/";
    if (where.starts_with(folder)) where = package.path() + ", " + where.substr(folder.size());
    throw FileError(error.problem(), where, error.fix());
  }
}

}  // namespace

ImportedFmu::ImportedFmu(const std::string& path, Parameters parameters)
    : parameters_(std::move(parameters)),
      package_(std::make_unique<FmuPackage>(path)),
      contents_(contents_of(*package_)) {
  if (parameters_.name.empty()) parameters_.name = contents_->model_name;
  if (contents_->needs_tool)
    refuse("the FMU needs the tool that made it to run", "export it with its own solver and without that need");
  if (parameters_.interval == 0) parameters_.interval = contents_->default_step;
  if (!(parameters_.interval > 0) || !std::isfinite(parameters_.interval))
    refuse("the interval is " + number_text(parameters_.interval) + " s" +
               (contents_->default_step > 0 ? "" : ", and the FMU names no default"),
           "give .interval, the time between communication points, above 0");
  std::set<std::string> connected;
  for (const FromSensor& wire : parameters_.inputs) {
    inputs_.push_back(&variable(wire.variable, "input"));
    if (!connected.insert(wire.variable).second)
      refuse("its input '" + wire.variable + "' is connected twice", "keep one of the two sensors");
    if (wire.column < 0 || wire.column >= static_cast<int>(wire.sensor.columns().size()))
      refuse("its input '" + wire.variable + "' takes column " + std::to_string(wire.column) +
                 " of a sensor that has " + std::to_string(wire.sensor.columns().size()),
             "count columns from 0");
  }
  std::set<const Input*> driven;
  for (const ToInput& wire : parameters_.outputs) {
    outputs_.push_back(&variable(wire.variable, "output"));
    if (!wire.input) refuse("its output '" + wire.variable + "' goes to no Input", "give the address of one");
    if (!driven.insert(wire.input).second)
      refuse("two of its outputs go to the input '" + wire.input->name() + "'", "keep one of the two");
  }
  for (const auto& [name, number] : parameters_.values) {
    variable(name, "parameter");
    if (!std::isfinite(number)) refuse("the value of '" + name + "' is not finite", "give a number");
  }
  make_instance();  // a binary that cannot be loaded is told here
}

ImportedFmu::~ImportedFmu() = default;

void ImportedFmu::refuse(const std::string& problem, const std::string& fix) const {
  throw SceneError(problem, "FMU '" + parameters_.name + "'", fix);
}

/// `role`: input, output, parameter (a start value may be an input's too), or empty: any.
const ImportedVariable& ImportedFmu::variable(const std::string& name, const std::string& role) const {
  const auto fits = [&](const ImportedVariable& v) {
    if (role == "input") return v.causality == "input";
    if (role == "output") return v.causality == "output" || v.causality == "local";
    if (role == "parameter") return v.causality == "parameter" || v.causality == "input";
    return true;
  };
  std::vector<std::string> known;
  for (const ImportedVariable& v : contents_->variables) {
    if (v.name != name) {
      if (fits(v)) known.push_back(v.name);
      continue;
    }
    if (!fits(v))
      refuse("'" + name + "' is no " + role + ", its causality is " + v.causality, "connect one of that kind");
    if (v.array || v.type == "String" || v.type == "Binary" || v.type == "Clock")
      refuse("'" + name + "' is " + (v.array ? "an array" : "of type " + v.type) + "; single numbers can be used",
             "use another variable");
    return v;
  }
  refuse("it has no " + (role.empty() ? "variable" : role) + " '" + name + "'", name_hint(name, known));
}

void ImportedFmu::make_instance() {
  library_.reset();  // some binaries allow one instance at a time
  library_ = make_fmu_library(*contents_, package_->folder().string(), package_->path(), parameters_.name);
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
    library_->set(*inputs_[i], value);
  }
}

void ImportedFmu::begin(Snapshot& snapshot) {
  if (!library_ || !fresh_) make_instance();
  fresh_ = false;
  time_ = clock_ = snapshot.time();
  for (const auto& [name, value] : parameters_.values) library_->set(variable(name, "parameter"), value);
  library_->enter_initialization(time_);
  read_sensors(snapshot);
  library_->exit_initialization();
  hand_over(time_, true);
}

void ImportedFmu::hand_over(double time, bool first) {
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    const double value = this->value(*outputs_[i]);
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

double ImportedFmu::value(const std::string& name) const { return value(variable(name, "")); }

double ImportedFmu::value(const ImportedVariable& asked) const {
  if (fresh_) return asked.start.value_or(0);
  if (!library_)
    throw SimulationError("the FMU failed: '" + asked.name + "' has no value.", "FMU '" + name() + "'",
                          "run again from the start, or resume a checkpoint.");
  const double value = library_->get(asked);
  if (!std::isfinite(value))
    throw SimulationError("the FMU gives " + number_text(value) + " for '" + asked.name + "'.", "FMU '" + name() + "'",
                          "look at its inputs and parameters.");
  return value;
}

Sensor ImportedFmu::sensor(const std::string& name, Located as) const {
  const ImportedVariable& asked = variable(name, "");
  if (as.text.empty()) as.text = name;
  const std::string column = as.text;
  return Sensor(std::move(as), {column}, [this, &asked](Snapshot&, std::span<double> out) { out[0] = value(asked); },
                {asked.unit});
}

std::string ImportedFmu::describe() const {
  std::string out = "FMU '" + name() + "': " + contents_->model_name + ", FMI " + std::to_string(contents_->version) +
                    ".0" + (contents_->tool.empty() ? "" : ", made by " + contents_->tool) + "; every " +
                    number_text(interval()) + " s" +
                    (contents_->serializes ? "" : "; it cannot give its state: no checkpoints") + "\n";
  const auto line = [&](const ImportedVariable& v, const std::string& is) {
    out += "  " + v.causality + " " + v.name + (v.unit.empty() ? "" : " [" + v.unit + "]") + is + "\n";
  };
  for (const ImportedVariable& v : contents_->variables) {
    std::string is;
    for (const FromSensor& wire : parameters_.inputs)
      if (wire.variable == v.name) is = " from sensor '" + wire.sensor.columns()[wire.column] + "'";
    for (const ToInput& wire : parameters_.outputs)
      if (wire.variable == v.name) is = " to input '" + wire.input->name() + "'";
    for (const auto& [name, value] : parameters_.values)
      if (name == v.name) is += " = " + number_text(value);
    if (is.empty() && (v.causality == "parameter" || v.causality == "input") && v.start)
      is = " = " + number_text(*v.start) + ", its default";
    if (!is.empty() || v.causality == "input" || v.causality == "output") line(v, is.empty() ? ", not connected" : is);
  }
  return out;
}

void ImportedFmu::history(Archive& archive) {
  if (!contents_->serializes)
    refuse("it cannot give its state (canSerializeFMUState), which checkpoints need",
           "run without checkpoints, or export it with that ability");
  std::vector<int> words;
  std::size_t size = 0;
  if (!archive.loads() && begun_) {
    if (!library_) refuse("it failed before, so there is no state to save", "save before the failure");
    const std::vector<unsigned char> bytes = library_->save();
    size = bytes.size();
    words.resize((size + sizeof(int) - 1) / sizeof(int));
    std::memcpy(words.data(), bytes.data(), size);
  }
  archive.group("fmu", [&] {
    archive("begun", begun_);
    archive("time", time_);
    archive("clock", clock_);
    archive("size", size);
    archive("state", words);
  });
  if (!archive.loads()) return;
  make_instance();
  if (!begun_) return;
  fresh_ = false;
  if (words.size() != (size + sizeof(int) - 1) / sizeof(int))
    throw FileError("the state of the FMU '" + name() + "' is damaged.", archive.source(), "take another checkpoint.");
  std::vector<unsigned char> bytes(size);
  std::memcpy(bytes.data(), words.data(), size);
  library_->load(bytes);
}

}  // namespace lithe
