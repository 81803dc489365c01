#include "engine/fmu/fmu_border.h"

#include <algorithm>
#include <exception>
#include <vector>

#include "engine/base/error.h"

namespace lithe::fmu {
namespace {

struct Saved {
  std::vector<unsigned char> bytes;
};

constexpr int kLooks = kInitialization | kExchange | kTerminated;

void same_count(std::size_t given, int count, const char* what) {
  if (given != static_cast<std::size_t>(count))
    throw SceneError("there are " + std::to_string(count) + " " + what + ", not " + std::to_string(given),
                     "model exchange", "take their number from modelDescription.xml");
}

void copy(const VectorX& from, double* to) { std::copy(from.begin(), from.end(), to); }

}  // namespace

Component::Component(const FmuModel& model, FmuInstance::Form form, Tell tell, bool tells_all, bool has_events,
                     FmuInstance::Intermediate intermediate)
    : logging(tells_all), tell_(std::move(tell)), events_(has_events), intermediate_(std::move(intermediate)) {
  const log::Redirect redirect(sink());
  FmuInstance::Intermediate told;
  if (intermediate_) told = [this](double time) { return tell_intermediate(time); };
  instance_ = std::make_unique<FmuInstance>(model, form, told);
}

bool Component::tell_intermediate(double time) {
  mode_ = kIntermediate;
  bool ends = false;
  try {
    ends = intermediate_(time);
  } catch (...) {  // NOLINT: as in tell()
  }
  mode_ = kStep;
  return ends;
}

std::function<void(log::Level, const std::string&)> Component::sink() {
  return [this](log::Level level, const std::string& message) {
    if (level == log::Level::warn)
      tell(Outcome::warning, "logStatusWarning", message);
    else if (logging)
      tell(Outcome::ok, "logEvents", message);
  };
}

void Component::tell(Outcome outcome, const char* category, const std::string& message) const {
  try {
    tell_(outcome, category, message);
  } catch (...) {  // NOLINT: an importer written in C++ may throw; nothing of ours does
  }
}

/// Runs `work` if the mode allows it; whatever it throws is told and becomes an outcome. Where an importer tries a
/// state that the equations cannot take, it may try another.
template <class Work>
Outcome Component::guarded(const char* function, int allowed, Work&& work) noexcept {
  if ((mode_ & allowed) == 0) {
    tell(Outcome::error, "logStatusError", std::string(function) + " is not allowed in this mode");
    return Outcome::error;
  }
  try {
    const log::Redirect redirect(sink());
    work();
    return Outcome::ok;
  } catch (const SimulationError& error) {
    const bool tried = mode_ == kContinuous;
    tell(tried ? Outcome::discard : Outcome::error, tried ? "logStatusDiscard" : "logStatusError",
         std::string(function) + ": " + error.what());
    if (tried) return Outcome::discard;
  } catch (const Error& error) {
    tell(Outcome::error, "logStatusError", std::string(function) + ": " + error.what());
  } catch (const std::exception& error) {
    tell(Outcome::error, "logStatusError", std::string(function) + " threw: " + error.what());
  } catch (...) {
    tell(Outcome::error, "logStatusError", std::string(function) + " threw what is no std::exception");
  }
  return Outcome::error;
}

// ---- what both standards ask for ----

Outcome Component::set_up(double start, double tolerance) {
  return guarded("SetupExperiment", kInstantiated, [&] { instance_->begin(start, tolerance); });
}
Outcome Component::enter_initialization() {
  return guarded("EnterInitializationMode", kInstantiated, [&] { mode_ = kInitialization; });
}
Outcome Component::enter_initialization(double start, double tolerance) {
  return guarded("EnterInitializationMode", kInstantiated, [&] {
    instance_->begin(start, tolerance);
    mode_ = kInitialization;
  });
}
Outcome Component::exit_initialization() {
  return guarded("ExitInitializationMode", kInitialization, [&] { mode_ = exchange() || events_ ? kEvent : kStep; });
}
Outcome Component::get(const char* function, const std::uint32_t* references, std::size_t count, double* values) {
  return guarded(function, kInitialized | kTerminated | kIntermediate, [&] {
    for (std::size_t i = 0; i < count; ++i) values[i] = instance_->get(references[i]);
  });
}
Outcome Component::set(const char* function, const std::uint32_t* references, std::size_t count, const double* values) {
  return guarded(function, kInstantiated | kInitialized | kIntermediate, [&] {
    for (std::size_t i = 0; i < count; ++i) {
      if ((mode_ & (kContinuous | kIntermediate)) != 0 &&
          instance_->variable(references[i]).role == FmuVariable::Role::parameter)
        throw SceneError("'" + instance_->variable(references[i]).name + "' is a parameter, constant between events",
                         function, "set it in event mode, or between communication steps");
      instance_->set(references[i], values[i], mode_ != kStep);
    }
  });
}
Outcome Component::none(const char* function, std::size_t count) {
  return guarded(function, kAnywhere, [&] {
    if (count > 0) throw SceneError("no variable is of that type", function, "take types from modelDescription.xml");
  });
}
Outcome Component::step(double current, double size, bool& early) {
  const Outcome outcome = guarded("DoStep", kStep, [&] { early = instance_->step(current, size); });
  if (outcome != Outcome::ok && mode_ == kStep) mode_ = kFailed;
  return outcome;
}
Outcome Component::terminate() {
  return guarded("Terminate", kStep | kExchange | kFailed, [&] { mode_ = kTerminated; });
}
Outcome Component::reset() {
  return guarded("Reset", kAnywhere, [&] {
    instance_->reset();
    mode_ = kInstantiated;
  });
}
Outcome Component::save(void** state) {
  return guarded("GetFMUState", kAnywhere & ~kFailed, [&] {
    auto saved = std::make_unique<Saved>(Saved{instance_->save(mode_)});
    if (*state)
      *static_cast<Saved*>(*state) = *saved;
    else
      *state = saved.release();
  });
}
Outcome Component::load(const void* state) {
  return guarded("SetFMUState", kAnywhere, [&] {
    if (!state) throw SceneError("there is no state to restore", "SetFMUState", "give one that GetFMUState made");
    const auto& bytes = static_cast<const Saved*>(state)->bytes;
    const int saved = instance_->load(bytes.data(), bytes.size());
    mode_ = static_cast<Mode>(saved);
  });
}
void Component::forget(void** state) {
  if (!state || !*state) return;
  delete static_cast<Saved*>(*state);
  *state = nullptr;
}
Outcome Component::size(const void* state, std::size_t* size) {
  return guarded("SerializedFMUStateSize", kAnywhere, [&] { *size = static_cast<const Saved*>(state)->bytes.size(); });
}
Outcome Component::serialize(const void* state, unsigned char* bytes, std::size_t size) {
  return guarded("SerializeFMUState", kAnywhere, [&] {
    const auto& all = static_cast<const Saved*>(state)->bytes;
    if (size != all.size())
      throw SceneError("the size given is " + std::to_string(size) + ", the state has " + std::to_string(all.size()),
                       "SerializeFMUState", "ask SerializedFMUStateSize for this state");
    std::copy(all.begin(), all.end(), bytes);
  });
}
Outcome Component::deserialize(const unsigned char* bytes, std::size_t size, void** state) {
  return guarded("DeserializeFMUState", kAnywhere, [&] {
    auto saved = std::make_unique<Saved>(Saved{{bytes, bytes + size}});
    FmuInstance::check_saved(bytes, size);
    forget(state);
    *state = saved.release();
  });
}
Outcome Component::enter_event() {
  return guarded("EnterEventMode", exchange() ? kContinuous : events_ ? kStep : 0, [&] { mode_ = kEvent; });
}
Outcome Component::update(bool& states_changed) {
  states_changed = false;
  return guarded("UpdateDiscreteStates", kEvent, [&] { states_changed = exchange() && instance_->update(); });
}
Outcome Component::leave_event(const char* function, Mode next) {
  return guarded(function, exchange() == (next == kContinuous) ? kEvent : 0, [&] { mode_ = next; });
}

// ---- model exchange ----

/// Of an instance for model exchange.
const FmuEquations& Component::equations() const {
  if (!exchange())
    throw SceneError("this instance is for co-simulation", "model exchange", "instantiate for model exchange");
  return instance_->equations();
}

template <class Work>
Outcome Component::look(const char* function, std::size_t count, Work&& work) {
  return guarded(function, kLooks, [&] {
    same_count(count, equations().state_count(), "continuous states");
    work();
  });
}

Outcome Component::set_time(int allowed, double time) {
  return guarded("SetTime", allowed, [&] { instance_->set_time(time); });
}
Outcome Component::set_states(const double* x, std::size_t count) {
  return guarded("SetContinuousStates", kContinuous, [&] {
    same_count(count, equations().state_count(), "continuous states");
    instance_->set_states({x, count});
  });
}
Outcome Component::completed_step(bool& event) {
  event = false;
  return guarded("CompletedIntegratorStep", kContinuous, [&] { event = instance_->complete_step(); });
}
Outcome Component::states(double* x, std::size_t count) {
  return look("GetContinuousStates", count, [&] { copy(instance_->states(), x); });
}
Outcome Component::derivatives(double* x_dot, std::size_t count) {
  return look("GetContinuousStateDerivatives", count, [&] { copy(instance_->derivatives(), x_dot); });
}
Outcome Component::nominals(double* x, std::size_t count) {
  return look("GetNominalsOfContinuousStates", count, [&] { copy(equations().nominals(), x); });
}
Outcome Component::indicators(double* values, std::size_t count) {
  return guarded("GetEventIndicators", kLooks, [&] {
    same_count(count, equations().indicator_count(), "event indicators");
    instance_->indicators({values, count});
  });
}
Outcome Component::count(const char* function, int (FmuEquations::*what)() const, std::size_t* count) {
  return guarded(function, kAnywhere & ~kFailed, [&] { *count = static_cast<std::size_t>((equations().*what)()); });
}
Outcome Component::derivative(const char* function, decltype(&FmuInstance::directional_derivative) of,
                              std::span<const std::uint32_t> unknowns, std::span<const std::uint32_t> knowns,
                              std::span<const double> seed, std::span<double> sensitivity) {
  return guarded(function, kLooks, [&] {
    equations();
    (*instance_.*of)(unknowns, knowns, seed, sensitivity);
  });
}

}  // namespace lithe::fmu
