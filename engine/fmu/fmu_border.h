#pragma once

#include <algorithm>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/resource.h"
#include "engine/fmu/fmu_instance.h"

/// What the C functions of FMI 2.0 and 3.0 have in common: an instance with the mode it is in, behind which no
/// exception passes. Included by the two borders alone, which are compiled into each FMU.
namespace lithe::fmu {

/// Modes as bits: a function names those that it is allowed in.
enum Mode : int {
  kInstantiated = 1,
  kInitialization = 2,
  kStep = 4,
  kTerminated = 8,
  kFailed = 16,
  kEvent = 32,
  kContinuous = 64,
  kExchange = kEvent | kContinuous,
  kInitialized = kInitialization | kStep | kExchange,
  kAnywhere = 127,
  kIntermediate = 128,  // at a state within a communication step: to read, and for inputs from there on
};

enum class Outcome { ok = 0, warning = 1, discard = 2, error = 3, fatal = 4 };  // the numbers of both standards

struct Saved {
  std::vector<unsigned char> bytes;
};

class Component {
 public:
  /// What the importer is told: how it went, a category, a text.
  using Tell = std::function<void(Outcome outcome, const char* category, const std::string& message)>;

  Component(const FmuModel& model, FmuInstance::Form form, Tell tell, bool tells_all, bool has_events = false,
            FmuInstance::Intermediate intermediate = {})
      : logging(tells_all), tell_(std::move(tell)), events_(has_events), intermediate_(std::move(intermediate)) {
    const log::Redirect redirect(sink());
    FmuInstance::Intermediate told;
    if (intermediate_) told = [this](double time) { return tell_intermediate(time); };
    instance = std::make_unique<FmuInstance>(model, form, told);
  }

  Mode mode = kInstantiated;
  bool logging;  // also what is no error

 private:
  Tell tell_;
  const bool events_;  // co-simulation with event mode
  const FmuInstance::Intermediate intermediate_;
  bool tell_intermediate(double time) {
    mode = kIntermediate;
    bool ends = false;
    try {
      ends = intermediate_(time);
    } catch (...) {  // NOLINT: as in tell()
    }
    mode = kStep;
    return ends;
  }
  bool exchange() const { return instance->form() == FmuInstance::Form::model_exchange; }
  std::function<void(log::Level, const std::string&)> sink() {
    return [this](log::Level level, const std::string& message) {
      if (level == log::Level::warn)
        tell(Outcome::warning, "logStatusWarning", message);
      else if (logging)
        tell(Outcome::ok, "logEvents", message);
    };
  }

 public:
  std::unique_ptr<FmuInstance> instance;

  void tell(Outcome outcome, const char* category, const std::string& message) const {
    try {
      tell_(outcome, category, message);
    } catch (...) {  // NOLINT: an importer written in C++ may throw; nothing of ours does
    }
  }

  /// Runs `work` if the mode allows it; whatever it throws is told and becomes an outcome. Where an importer tries a
  /// state that the equations cannot take, it may try another.
  template <class Work>
  Outcome guarded(const char* function, int allowed, Work&& work) noexcept {
    if ((mode & allowed) == 0) {
      tell(Outcome::error, "logStatusError", std::string(function) + " is not allowed in this mode");
      return Outcome::error;
    }
    try {
      const log::Redirect redirect(sink());
      work();
      return Outcome::ok;
    } catch (const SimulationError& error) {
      const bool tried = mode == kContinuous;
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

  Outcome get(const char* function, const std::uint32_t* references, std::size_t count, double* values) {
    return guarded(function, kInitialized | kTerminated | kIntermediate, [&] {
      for (std::size_t i = 0; i < count; ++i) values[i] = instance->get(references[i]);
    });
  }
  Outcome set(const char* function, const std::uint32_t* references, std::size_t count, const double* values) {
    return guarded(function, kInstantiated | kInitialized | kIntermediate, [&] {
      for (std::size_t i = 0; i < count; ++i) {
        if ((mode & (kContinuous | kIntermediate)) != 0 &&
            instance->variable(references[i]).role == FmuVariable::Role::parameter)
          throw SceneError("'" + instance->variable(references[i]).name + "' is a parameter, constant between events",
                           function, "set it in event mode, or between communication steps");
        instance->set(references[i], values[i], mode != kStep);
      }
    });
  }
  /// None is of another type than Float64.
  Outcome none(const char* function, std::size_t count) {
    return guarded(function, kAnywhere, [&] {
      if (count > 0) throw SceneError("no variable is of that type", function, "take types from modelDescription.xml");
    });
  }
  Outcome exit_initialization() {
    return guarded("ExitInitializationMode", kInitialization, [&] { mode = exchange() || events_ ? kEvent : kStep; });
  }
  /// To the end; early: to where the importer ended it in an intermediate update.
  Outcome step(double current, double size, bool& early) {
    const Outcome outcome = guarded("DoStep", kStep, [&] { early = instance->step(current, size); });
    if (outcome != Outcome::ok && mode == kStep) mode = kFailed;
    return outcome;
  }
  Outcome terminate() {
    return guarded("Terminate", kStep | kExchange | kFailed, [&] { mode = kTerminated; });
  }
  Outcome reset() {
    return guarded("Reset", kAnywhere, [&] {
      instance->reset();
      mode = kInstantiated;
    });
  }
  Outcome save(void** state) {
    return guarded("GetFMUState", kAnywhere & ~kFailed, [&] {
      auto saved = std::make_unique<Saved>(Saved{instance->save(mode)});
      if (*state)
        *static_cast<Saved*>(*state) = *saved;
      else
        *state = saved.release();
    });
  }
  Outcome load(const void* state) {
    return guarded("SetFMUState", kAnywhere, [&] {
      if (!state) throw SceneError("there is no state to restore", "SetFMUState", "give one that GetFMUState made");
      const auto& bytes = static_cast<const Saved*>(state)->bytes;
      const int saved = instance->load(bytes.data(), bytes.size());
      mode = static_cast<Mode>(saved);
    });
  }
  static void forget(void** state) {
    if (!state || !*state) return;
    delete static_cast<Saved*>(*state);
    *state = nullptr;
  }
  Outcome size(const void* state, std::size_t* size) {
    return guarded("SerializedFMUStateSize", kAnywhere,
                   [&] { *size = static_cast<const Saved*>(state)->bytes.size(); });
  }
  Outcome serialize(const void* state, unsigned char* bytes, std::size_t size) {
    return guarded("SerializeFMUState", kAnywhere, [&] {
      const auto& all = static_cast<const Saved*>(state)->bytes;
      if (size != all.size())
        throw SceneError("the size given is " + std::to_string(size) + ", the state has " + std::to_string(all.size()),
                         "SerializeFMUState", "ask SerializedFMUStateSize for this state");
      std::copy(all.begin(), all.end(), bytes);
    });
  }
  Outcome deserialize(const unsigned char* bytes, std::size_t size, void** state) {
    return guarded("DeserializeFMUState", kAnywhere, [&] {
      auto saved = std::make_unique<Saved>(Saved{{bytes, bytes + size}});
      FmuInstance::check_saved(bytes, size);
      forget(state);
      *state = saved.release();
    });
  }

  Outcome enter_event() {
    return guarded("EnterEventMode", exchange() ? kContinuous : events_ ? kStep : 0, [&] { mode = kEvent; });
  }
  /// In co-simulation nothing: what the scene does at an event, it has done within the step.
  Outcome update(bool& states_changed) {
    states_changed = false;
    return guarded("UpdateDiscreteStates", kEvent, [&] { states_changed = exchange() && instance->update(); });
  }
  /// Continuous-time mode, or step mode.
  Outcome leave_event(const char* function, Mode next) {
    return guarded(function, exchange() == (next == kContinuous) ? kEvent : 0, [&] { mode = next; });
  }

  // ---- model exchange ----

  Outcome set_time(int allowed, double time) {
    return guarded("SetTime", allowed, [&] { instance->set_time(time); });
  }
  Outcome set_states(const double* x, std::size_t count) {
    return guarded("SetContinuousStates", kContinuous, [&] {
      same_count(count, equations().state_count(), "continuous states");
      instance->set_states({x, count});
    });
  }
  Outcome completed_step(bool& event) {
    event = false;
    return guarded("CompletedIntegratorStep", kContinuous, [&] { event = instance->complete_step(); });
  }
  Outcome states(double* x, std::size_t count) {
    return look("GetContinuousStates", count, [&] { copy(instance->states(), x); });
  }
  Outcome derivatives(double* x_dot, std::size_t count) {
    return look("GetContinuousStateDerivatives", count, [&] { copy(instance->derivatives(), x_dot); });
  }
  Outcome nominals(double* x, std::size_t count) {
    return look("GetNominalsOfContinuousStates", count, [&] { copy(equations().nominals(), x); });
  }
  Outcome indicators(double* values, std::size_t count) {
    return guarded("GetEventIndicators", kLooks, [&] {
      same_count(count, equations().indicator_count(), "event indicators");
      instance->indicators({values, count});
    });
  }
  /// How many states, or event indicators, there are.
  Outcome count(const char* function, int (FmuEquations::*what)() const, std::size_t* count) {
    return guarded(function, kAnywhere & ~kFailed, [&] { *count = static_cast<std::size_t>((equations().*what)()); });
  }
  /// Directional or adjoint.
  Outcome derivative(const char* function, decltype(&FmuInstance::directional_derivative) of,
                     std::span<const std::uint32_t> unknowns, std::span<const std::uint32_t> knowns,
                     std::span<const double> seed, std::span<double> sensitivity) {
    return guarded(function, kLooks, [&] {
      equations();
      (*instance.*of)(unknowns, knowns, seed, sensitivity);
    });
  }

 private:
  static constexpr int kLooks = kInitialization | kExchange | kTerminated;
  /// Of an instance for model exchange.
  const FmuEquations& equations() const {
    if (!exchange())
      throw SceneError("this instance is for co-simulation", "model exchange", "instantiate for model exchange");
    return instance->equations();
  }
  static void same_count(std::size_t given, int count, const char* what) {
    if (given != static_cast<std::size_t>(count))
      throw SceneError("there are " + std::to_string(count) + " " + what + ", not " + std::to_string(given),
                       "model exchange", "take their number from modelDescription.xml");
  }
  template <class Work>
  Outcome look(const char* function, std::size_t count, Work&& work) {
    return guarded(function, kLooks, [&] {
      same_count(count, equations().state_count(), "continuous states");
      work();
    });
  }
  static void copy(const VectorX& from, double* to) { std::copy(from.begin(), from.end(), to); }
};

}  // namespace lithe::fmu

#define LITHE_FMU_EXPORT extern "C" __attribute__((visibility("default")))
