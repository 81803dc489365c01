#include "engine/fmu/fmu_instance.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/archive/archive.h"
#include "engine/base/error.h"
#include "engine/base/fnv1a.h"
#include "engine/base/number_text.h"
#include "engine/base/version.h"
#include "engine/observe/stop_run.h"

namespace lithe {
namespace {

constexpr double kSamePoint = 1e-9;  // of a step: communication points that differ by rounding
constexpr char kMagic[8] = {'l', 'i', 't', 'h', 'e', 'F', 'M', 'U'};
constexpr std::size_t kHead = sizeof kMagic + sizeof(std::uint64_t);

std::string_view view(const unsigned char* bytes, std::size_t size) {
  return {reinterpret_cast<const char*>(bytes), size};
}

}  // namespace

class FmuInstance::Steps final : public Observer {
 public:
  Steps(FmuInstance& instance, Intermediate tell) : instance_(instance), tell_(std::move(tell)) {}
  void observe(Snapshot& snapshot) override {
    const double time = snapshot.state().time;
    if (time == instance_.told_) return;
    instance_.told_ = time;
    instance_.seen_ = &snapshot;
    instance_.inputs_set_ = instance_.evaluated_ = false;
    instance_.rates_.resize(0);
    if (instance_.equations_) instance_.x_ = instance_.equations_->states_of(snapshot.state());
    const bool ends = tell_(time);
    instance_.seen_ = nullptr;
    instance_.evaluated_ = false;
    if (ends) throw StopRun{"the importer"};
  }

 private:
  FmuInstance& instance_;
  const Intermediate tell_;
};

FmuInstance::FmuInstance(const FmuModel& model, Form form, Intermediate intermediate)
    : model_(model), form_(form), graph_({.gravity = model.scene.gravity}) {
  sensors_ = model.scene.draw(graph_);
  system_ = std::make_unique<const System>(assemble(graph_));
  refusal_ = FmuEquations::refusal(*system_);
  if (refusal_.empty())
    equations_ = std::make_unique<const FmuEquations>(*system_, model.scene.characteristic_length);
  else if (form == Form::model_exchange)
    throw SceneError("there is no model exchange: " + refusal_, model.scene.name, "take co-simulation");
  variables_.push_back({.name = "time", .unit = "s", .description = "simulation time"});
  for (const Input* input : graph_.inputs()) {
    const auto& p = input->parameters();
    variables_.push_back({.name = input->name(),
                          .unit = p.unit,
                          .description = p.description,
                          .role = p.parameter ? FmuVariable::Role::parameter : FmuVariable::Role::input,
                          .start = p.value,
                          .lower = p.lower,
                          .upper = p.upper,
                          .place = static_cast<int>(variables_.size()) - 1,
                          .within_steps = !p.parameter && p.between != Input::Between::smooth});
  }
  for (std::size_t s = 0; s < sensors_.size(); ++s)
    for (std::size_t c = 0; c < sensors_[s].columns().size(); ++c) {
      variables_.push_back({.name = sensors_[s].columns()[c],
                            .unit = sensors_[s].unit(c),
                            .role = FmuVariable::Role::output,
                            .place = static_cast<int>(outputs_.size()),
                            .sensor = sensors_[s].columns().size() > 1 ? sensors_[s].name() : ""});
      outputs_.emplace_back(static_cast<int>(s), static_cast<int>(c));
    }
  if (equations_) variables_.insert(variables_.end(), equations_->variables().begin(), equations_->variables().end());
  std::set<std::string> names;
  for (const FmuVariable& v : variables_)
    if (!names.insert(v.name).second)
      throw SceneError("two variables of the FMU would have the name '" + v.name + "'", model.scene.name,
                       "name inputs and sensors differently, and none of them 'time'");
  if (intermediate) steps_ = std::make_unique<Steps>(*this, std::move(intermediate));
  reset();
}

FmuInstance::~FmuInstance() = default;

double FmuInstance::time() const { return seen_ ? seen_->state().time : state_.time; }

void FmuInstance::reset() {
  simulation_.reset();
  snapshot_ = std::make_unique<Snapshot>(*system_);
  state_ = system_->initial_state();
  if (form_ == Form::co_simulation) {
    integrator_ = model_.integrator();
    simulation_ = std::make_unique<Simulation>(*system_, *integrator_);
    if (steps_) simulation_->observe(*steps_, every_step());
  }
  started_ = inputs_set_ = evaluated_ = false;
  start_ = state_.time;
  tolerance_ = 0;
  given_.clear();
  for (Input* input : graph_.inputs()) {
    input->reset();
    given_.push_back(input->parameters().value);
  }
  if (!equations_) return;
  sides_.assign(static_cast<std::size_t>(equations_->indicator_count()), 0);
  if (form_ == Form::co_simulation) return;
  x_ = equations_->states_of(state_);
  state_.v_dot.setConstant(std::numeric_limits<double>::quiet_NaN());  // those of the equations, or none
}

void FmuInstance::begin(double start, double tolerance) {
  if (!std::isfinite(start))
    throw SceneError("the start time is not finite", model_.scene.name, "give a time in seconds");
  if (!(tolerance >= 0) || !std::isfinite(tolerance))
    throw SceneError("a tolerance of " + number_text(tolerance), model_.scene.name, "give a positive one, or none");
  state_.time = start_ = start;
  tolerance_ = tolerance;
  apply_inputs(start);
  if (form_ == Form::model_exchange) update();
}

/// As given, at all times.
void FmuInstance::apply_inputs(double time) {
  for (std::size_t i = 0; i < given_.size(); ++i) graph_.inputs()[i]->reset(time, given_[i]);
  evaluated_ = false;
}

const FmuVariable& FmuInstance::variable(unsigned reference) const {
  if (reference >= variables_.size())
    throw SceneError("no variable has the value reference " + std::to_string(reference), model_.scene.name,
                     "take value references from modelDescription.xml");
  return variables_[reference];
}

Snapshot& FmuInstance::look() {
  if (seen_ && !inputs_set_) return *seen_;
  if (evaluated_) return *snapshot_;
  rates_.resize(0);
  if (form_ == Form::model_exchange) {
    equations_->evaluate(state_, *snapshot_);
  } else {
    const bool solved = !started_ || inputs_set_ || integrator_->approximates_accelerations();
    const State& state = seen_ ? seen_->state() : state_;
    snapshot_->evaluate(state, solved ? Accelerations::solved : Accelerations::as_left);
    if (equations_) x_ = equations_->states_of(state);
  }
  evaluated_ = true;
  return *snapshot_;
}

double FmuInstance::get(unsigned reference) {
  const FmuVariable& asked = variable(reference);
  const auto place = static_cast<std::size_t>(asked.place);
  double value = 0;
  switch (asked.role) {
    case FmuVariable::Role::time:
      return time();
    case FmuVariable::Role::input:
    case FmuVariable::Role::parameter:
      return given_[place];
    case FmuVariable::Role::state:
      if (form_ == Form::co_simulation) look();
      return x_[asked.place];
    case FmuVariable::Role::derivative:
      return derivatives()[asked.place];
    case FmuVariable::Role::indicator:
      value = equations_->indicator(asked.place, look(), sides_);
      break;
    case FmuVariable::Role::output:
      const auto [sensor, column] = outputs_[place];
      value = sensors_[static_cast<std::size_t>(sensor)].value(look(), column);
  }
  if (!std::isfinite(value))
    throw SimulationError("'" + asked.name + "' is not finite", time_text(time()),
                          "look for what makes it so: a division by zero, a locked mechanism");
  return value;
}

void FmuInstance::set(unsigned reference, double value, bool jumps) {
  const FmuVariable& asked = variable(reference);
  if (asked.role != FmuVariable::Role::input && asked.role != FmuVariable::Role::parameter)
    throw SceneError(
        "'" + asked.name + "' (value reference " + std::to_string(reference) + ") is no input or parameter",
        model_.scene.name, "set inputs and parameters alone");
  Input& input = *graph_.inputs()[static_cast<std::size_t>(asked.place)];
  if (seen_)
    set_within_step(input, value);
  else if (jumps || input.between() == Input::Between::held)
    input.reset(state_.time, value);
  else  // checked as if it were set
    input.require(state_.time, value, model_.scene.name);
  given_[static_cast<std::size_t>(asked.place)] = value;
  inputs_set_ = true;
  evaluated_ = false;
}

void FmuInstance::set_within_step(Input& input, double value) {
  const double now = time();
  input.require(now, value, model_.scene.name);
  if (input.between() == Input::Between::smooth)
    throw SceneError("input '" + input.name() + "' moves smoothly, from rest to rest over a communication step",
                     model_.scene.name,
                     "set it between steps, or draw it with .between = Input::Between::linear or held");
  if (input.between() == Input::Between::held) {
    input.set(now, value);
    input.end_at(std::numeric_limits<double>::infinity());  // what is asked next sees it at the end of the step too
  } else if (now < end_) {
    input.reset(now, input.value(now));
    input.set(end_, value);
  }
}

bool FmuInstance::step(double current, double size) {
  if (!(size > 0) || !std::isfinite(size))
    throw SceneError("a communication step of " + std::to_string(size) + " s", model_.scene.name,
                     "give a positive step");
  if (!(std::abs(current - state_.time) <= kSamePoint * size))
    throw SceneError(
        "the communication point " + time_text(current) + " is not the one reached, " + time_text(state_.time),
        model_.scene.name, "step from where the last step has ended, or restore a state");
  told_ = state_.time;
  end_ = current + size;
  for (std::size_t i = 0; i < given_.size(); ++i) {
    Input& input = *graph_.inputs()[i];
    const double present = input.value(state_.time);
    const bool held = input.between() == Input::Between::held;
    if (held ? input.samples().size() == 1 : present == given_[i]) continue;
    input.reset(state_.time, present);  // forgets what was set within the last step
    if (!held) input.set(end_, given_[i]);
  }
  evaluated_ = inputs_set_ = false;
  started_ = true;
  simulation_->run(state_, end_);
  return !simulation_->stopped_by().empty();
}

std::vector<unsigned char> FmuInstance::save(int mode) {
  Archive archive("the FMU's state");
  archive.same("token", model_.token);
  archive("mode", mode);
  history(archive);
  const std::vector<unsigned char> content = archive.bytes();
  std::vector<unsigned char> bytes(kHead);
  const std::uint64_t sum = fnv1a(view(content.data(), content.size()));
  std::memcpy(bytes.data(), kMagic, sizeof kMagic);
  std::memcpy(bytes.data() + sizeof kMagic, &sum, sizeof sum);
  bytes.insert(bytes.end(), content.begin(), content.end());
  return bytes;
}

void FmuInstance::check_saved(const unsigned char* bytes, std::size_t size) {
  std::uint64_t sum = 0;
  if (size >= kHead) std::memcpy(&sum, bytes + sizeof kMagic, sizeof sum);
  if (size < kHead || std::memcmp(bytes, kMagic, sizeof kMagic) != 0 || fnv1a(view(bytes + kHead, size - kHead)) != sum)
    throw FileError("the bytes are not a state of an FMU, or are damaged", "FMU state",
                    "restore what Get or Serialize of the FMU's state gave");
}

int FmuInstance::load(const unsigned char* bytes, std::size_t size) {
  check_saved(bytes, size);
  Archive archive = Archive::of_bytes("the FMU's state", bytes + kHead, size - kHead);
  archive.same("token", model_.token);
  reset();
  int mode = 0;
  archive("mode", mode);
  try {
    history(archive);
  } catch (...) {
    reset();
    throw;
  }
  return mode;
}

void FmuInstance::history(Archive& archive) {
  archive.same("form", static_cast<double>(form_));
  archive("started", started_);
  archive("inputs set", inputs_set_);
  archive("start", start_);
  archive("tolerance", tolerance_);
  std::vector<double> given = given_;
  archive("given", given);
  if (given.size() != given_.size())
    throw FileError("the state is of an FMU with other inputs", model_.scene.name, "restore states of this FMU");
  given_ = given;
  if (form_ == Form::model_exchange) {
    archive("state", state_);
    archive("x", x_);
    archive("sides", sides_);
    if (archive.loads()) apply_inputs(state_.time);
  } else if (!started_) {
    if (archive.loads()) begin(start_, tolerance_);
  } else if (archive.loads()) {
    archive.group("simulation", [&] { state_ = simulation_->resume(archive); });
  } else {
    archive.group("simulation", [&] { simulation_->save(state_, archive); });
  }
}

std::string fmu_facts(const FmuModel& model) {
  const FmuInstance instance(model);
  nlohmann::ordered_json facts = {{"name", model.scene.name},
                                  {"duration", model.scene.duration},
                                  {"lithe", kVersion},
                                  {"token", model.token},
                                  {"no model exchange", instance.refusal()}};
  const auto bound = [](double value) { return std::isfinite(value) ? nlohmann::ordered_json(value) : nullptr; };
  for (const FmuVariable& v : instance.variables())
    facts["variables"].push_back({{"name", v.name},
                                  {"unit", v.unit},
                                  {"description", v.description},
                                  {"role", static_cast<int>(v.role)},
                                  {"start", v.start},
                                  {"nominal", v.nominal},
                                  {"place", v.place},
                                  {"sensor", v.sensor},
                                  {"within steps", v.within_steps},
                                  {"lower", bound(v.lower)},
                                  {"upper", bound(v.upper)}});
  return facts.dump();
}

}  // namespace lithe
