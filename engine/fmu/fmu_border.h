#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "engine/base/log.h"
#include "engine/base/resource.h"
#include "engine/fmu/fmu_instance.h"

/// What the C functions of FMI 2.0 and 3.0 have in common: an instance with the mode it is in, behind which no
/// exception passes.
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

/// An instance as importers use it. Compiled once, in the library beneath FMUs; the borders, which each FMU compiles,
/// only call it.
class Component {
 public:
  /// What the importer is told: how it went, a category, a text.
  using Tell = std::function<void(Outcome outcome, const char* category, const std::string& message)>;

  Component(const FmuModel& model, FmuInstance::Form form, Tell tell, bool tells_all, bool has_events = false,
            FmuInstance::Intermediate intermediate = {});

  bool logging;  // also what is no error

  void tell(Outcome outcome, const char* category, const std::string& message) const;

  // ---- what both standards ask for ----

  double time() const { return instance_->time(); }
  /// Of 2.0, before initialization mode; 3.0 gives the same as it enters that mode. A tolerance of 0 is not known.
  Outcome set_up(double start, double tolerance);
  Outcome enter_initialization();
  Outcome enter_initialization(double start, double tolerance);
  Outcome exit_initialization();
  Outcome get(const char* function, const std::uint32_t* references, std::size_t count, double* values);
  Outcome set(const char* function, const std::uint32_t* references, std::size_t count, const double* values);
  /// None is of another type than Float64.
  Outcome none(const char* function, std::size_t count);
  /// To the end; early: to where the importer ended it in an intermediate update.
  Outcome step(double current, double size, bool& early);
  Outcome terminate();
  Outcome reset();
  Outcome save(void** state);
  Outcome load(const void* state);
  static void forget(void** state);
  Outcome size(const void* state, std::size_t* size);
  Outcome serialize(const void* state, unsigned char* bytes, std::size_t size);
  Outcome deserialize(const unsigned char* bytes, std::size_t size, void** state);
  Outcome enter_event();
  /// In co-simulation nothing: what the scene does at an event, it has done within the step.
  Outcome update(bool& states_changed);
  /// Continuous-time mode, or step mode.
  Outcome leave_event(const char* function, Mode next);

  // ---- model exchange ----

  Outcome set_time(int allowed, double time);
  Outcome set_states(const double* x, std::size_t count);
  Outcome completed_step(bool& event);
  Outcome states(double* x, std::size_t count);
  Outcome derivatives(double* x_dot, std::size_t count);
  Outcome nominals(double* x, std::size_t count);
  Outcome indicators(double* values, std::size_t count);
  /// How many states, or event indicators, there are.
  Outcome count(const char* function, int (FmuEquations::*what)() const, std::size_t* count);
  /// Directional or adjoint.
  Outcome derivative(const char* function, decltype(&FmuInstance::directional_derivative) of,
                     std::span<const std::uint32_t> unknowns, std::span<const std::uint32_t> knowns,
                     std::span<const double> seed, std::span<double> sensitivity);

 private:
  template <class Work>
  Outcome guarded(const char* function, int allowed, Work&& work) noexcept;
  template <class Work>
  Outcome look(const char* function, std::size_t count, Work&& work);
  bool tell_intermediate(double time);
  std::function<void(log::Level, const std::string&)> sink();
  bool exchange() const { return instance_->form() == FmuInstance::Form::model_exchange; }
  const FmuEquations& equations() const;

  Mode mode_ = kInstantiated;
  const Tell tell_;
  const bool events_;  // co-simulation with event mode
  const FmuInstance::Intermediate intermediate_;
  std::unique_ptr<FmuInstance> instance_;
};

}  // namespace lithe::fmu

#define LITHE_FMU_EXPORT extern "C" __attribute__((visibility("default")))
