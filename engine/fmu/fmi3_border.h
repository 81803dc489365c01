#pragma once

#include "engine/fmu/fmu_border.h"

/// The functions of FMI 3.0 (Modelica Association, FMI 3.0.2) for model exchange and co-simulation, over an
/// FmuInstance. Included once, in the source that `lithe fmu` compiles, after a function lithe::FmuModel
/// lithe_fmu_model().
extern "C" {

using fmi3Instance = void*;
using fmi3InstanceEnvironment = void*;
using fmi3FMUState = void*;
using fmi3ValueReference = std::uint32_t;
using fmi3Float32 = float;
using fmi3Float64 = double;
using fmi3Int8 = std::int8_t;
using fmi3UInt8 = std::uint8_t;
using fmi3Int16 = std::int16_t;
using fmi3UInt16 = std::uint16_t;
using fmi3Int32 = std::int32_t;
using fmi3UInt32 = std::uint32_t;
using fmi3Int64 = std::int64_t;
using fmi3UInt64 = std::uint64_t;
using fmi3Boolean = bool;
using fmi3String = const char*;
using fmi3Byte = std::uint8_t;
using fmi3Binary = const fmi3Byte*;
using fmi3Clock = bool;
enum fmi3Status { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal };
enum fmi3DependencyKind { fmi3Independent, fmi3Constant, fmi3Fixed, fmi3Tunable, fmi3Discrete, fmi3Dependent };
enum fmi3IntervalQualifier { fmi3IntervalNotYetKnown, fmi3IntervalUnchanged, fmi3IntervalChanged };

using fmi3LogMessageCallback = void (*)(fmi3InstanceEnvironment, fmi3Status, fmi3String category, fmi3String message);
using fmi3ClockUpdateCallback = void (*)(fmi3InstanceEnvironment);
using fmi3IntermediateUpdateCallback = void (*)(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean, fmi3Boolean,
                                                fmi3Boolean, fmi3Boolean, fmi3Boolean*, fmi3Float64*);
using fmi3LockPreemptionCallback = void (*)();
using fmi3UnlockPreemptionCallback = void (*)();

}  // extern "C"

namespace lithe::fmu::v3 {

/// A component, and a call without one.
template <class Work>
fmi3Status with(fmi3Instance instance, Work&& work) noexcept {
  if (!instance) return fmi3Error;
  return static_cast<fmi3Status>(work(*static_cast<Component*>(instance)));
}
inline fmi3Status refuse(fmi3Instance instance, const char* function) noexcept {
  return with(instance, [&](Component& c) {
    c.tell(Outcome::error, "logStatusError", std::string(function) + " is not offered by this FMU");
    return Outcome::error;
  });
}
inline void tell(fmi3LogMessageCallback callback, fmi3InstanceEnvironment environment, Outcome outcome,
                 const char* category, const std::string& message) {
  if (callback) callback(environment, static_cast<fmi3Status>(outcome), category, message.c_str());
}
inline fmi3Instance refuse_instance(fmi3LogMessageCallback callback, fmi3InstanceEnvironment environment,
                                    const std::string& why) noexcept {
  tell(callback, environment, Outcome::error, "logStatusError", why);
  return nullptr;
}

inline fmi3Instance instantiate(FmuInstance::Form form, fmi3String token, fmi3String resources, fmi3Boolean logging,
                                fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, bool events = false,
                                const FmuInstance::Intermediate& intermediate = {}) noexcept {
  try {
    const ResourceFolder folder(resources ? resources : "");
    static const FmuModel model = lithe_fmu_model();
    if (!token || model.token != token)
      return refuse_instance(log, environment, "the instantiation token is that of another FMU");
    const auto tell = [=](Outcome outcome, const char* category, const std::string& message) {
      v3::tell(log, environment, outcome, category, message);
    };
    return new Component(model, form, tell, logging, events, intermediate);
  } catch (const std::exception& error) {
    return refuse_instance(log, environment, error.what());
  } catch (...) {
    return refuse_instance(log, environment, "the scene threw what is no std::exception");
  }
}

}  // namespace lithe::fmu::v3

LITHE_FMU_EXPORT const char* fmi3GetVersion() { return "3.0"; }

LITHE_FMU_EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t, const fmi3String*) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) {
    c.logging = on;
    return lithe::fmu::Outcome::ok;
  });
}

LITHE_FMU_EXPORT fmi3Instance fmi3InstantiateCoSimulation(fmi3String, fmi3String token, fmi3String resources,
                                                          fmi3Boolean, fmi3Boolean logging, fmi3Boolean event_mode,
                                                          fmi3Boolean early_return, const fmi3ValueReference*, size_t,
                                                          fmi3InstanceEnvironment environment,
                                                          fmi3LogMessageCallback log,
                                                          fmi3IntermediateUpdateCallback update) {
  using namespace lithe;
  FmuInstance::Intermediate intermediate;
  if (update)
    intermediate = [=](double time) {
      fmi3Boolean ends = false;
      fmi3Float64 end = time;  // later ones are met here too: the next step of the integrator may pass them
      update(environment, time, true, true, true, early_return, &ends, &end);
      return ends && early_return;
    };
  return fmu::v3::instantiate(FmuInstance::Form::co_simulation, token, resources, logging, environment, log, event_mode,
                              intermediate);
}
LITHE_FMU_EXPORT fmi3Instance fmi3InstantiateModelExchange(fmi3String, fmi3String token, fmi3String resources,
                                                           fmi3Boolean, fmi3Boolean logging,
                                                           fmi3InstanceEnvironment environment,
                                                           fmi3LogMessageCallback log) {
  using namespace lithe;
  return fmu::v3::instantiate(FmuInstance::Form::model_exchange, token, resources, logging, environment, log);
}
LITHE_FMU_EXPORT fmi3Instance fmi3InstantiateScheduledExecution(fmi3String, fmi3String, fmi3String, fmi3Boolean,
                                                                fmi3Boolean, fmi3InstanceEnvironment environment,
                                                                fmi3LogMessageCallback log, fmi3ClockUpdateCallback,
                                                                fmi3LockPreemptionCallback,
                                                                fmi3UnlockPreemptionCallback) {
  return lithe::fmu::v3::refuse_instance(log, environment, "this FMU has no scheduled execution");
}
LITHE_FMU_EXPORT void fmi3FreeInstance(fmi3Instance instance) { delete static_cast<lithe::fmu::Component*>(instance); }

LITHE_FMU_EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean has_tolerance,
                                                        fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean,
                                                        fmi3Float64) {
  return lithe::fmu::v3::with(
      instance, [&](lithe::fmu::Component& c) { return c.enter_initialization(start, has_tolerance ? tolerance : 0); });
}
LITHE_FMU_EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
  return lithe::fmu::v3::with(instance, [](lithe::fmu::Component& c) { return c.exit_initialization(); });
}
LITHE_FMU_EXPORT fmi3Status fmi3Terminate(fmi3Instance instance) {
  return lithe::fmu::v3::with(instance, [](lithe::fmu::Component& c) { return c.terminate(); });
}
LITHE_FMU_EXPORT fmi3Status fmi3Reset(fmi3Instance instance) {
  return lithe::fmu::v3::with(instance, [](lithe::fmu::Component& c) { return c.reset(); });
}

LITHE_FMU_EXPORT fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 current, fmi3Float64 size, fmi3Boolean,
                                       fmi3Boolean* event, fmi3Boolean* terminate, fmi3Boolean* early,
                                       fmi3Float64* last) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) {
    if (event) *event = false;
    if (terminate) *terminate = false;
    bool ended = false;
    const lithe::fmu::Outcome outcome = c.step(current, size, ended);
    if (early) *early = ended;
    if (last) *last = c.time();
    return outcome;
  });
}

LITHE_FMU_EXPORT fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference* references, size_t count,
                                           fmi3Float64* values, size_t value_count) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) {
    return count == value_count ? c.get("GetFloat64", references, count, values) : c.none("GetFloat64", 1);
  });
}
LITHE_FMU_EXPORT fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference* references, size_t count,
                                           const fmi3Float64* values, size_t value_count) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) {
    return count == value_count ? c.set("SetFloat64", references, count, values) : c.none("SetFloat64", 1);
  });
}
#define LITHE_NO_VALUES(TYPE)                                                                                    \
  LITHE_FMU_EXPORT fmi3Status fmi3Get##TYPE(fmi3Instance instance, const fmi3ValueReference*, size_t count,      \
                                            fmi3##TYPE*, size_t) {                                               \
    return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) { return c.none("Get" #TYPE, count); }); \
  }                                                                                                              \
  LITHE_FMU_EXPORT fmi3Status fmi3Set##TYPE(fmi3Instance instance, const fmi3ValueReference*, size_t count,      \
                                            const fmi3##TYPE*, size_t) {                                         \
    return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) { return c.none("Set" #TYPE, count); }); \
  }
LITHE_NO_VALUES(Float32)
LITHE_NO_VALUES(Int8)
LITHE_NO_VALUES(UInt8)
LITHE_NO_VALUES(Int16)
LITHE_NO_VALUES(UInt16)
LITHE_NO_VALUES(Int32)
LITHE_NO_VALUES(UInt32)
LITHE_NO_VALUES(Int64)
LITHE_NO_VALUES(UInt64)
LITHE_NO_VALUES(Boolean)
LITHE_NO_VALUES(String)
#undef LITHE_NO_VALUES
LITHE_FMU_EXPORT fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference*, size_t count, size_t*,
                                          fmi3Binary*, size_t) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) { return c.none("GetBinary", count); });
}
LITHE_FMU_EXPORT fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference*, size_t count, const size_t*,
                                          const fmi3Binary*, size_t) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) { return c.none("SetBinary", count); });
}
LITHE_FMU_EXPORT fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference*, size_t count, fmi3Clock*) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) { return c.none("GetClock", count); });
}
LITHE_FMU_EXPORT fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference*, size_t count,
                                         const fmi3Clock*) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) { return c.none("SetClock", count); });
}

LITHE_FMU_EXPORT fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState* state) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) { return c.save(state); });
}
LITHE_FMU_EXPORT fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) { return c.load(state); });
}
LITHE_FMU_EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState* state) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component&) {
    lithe::fmu::Component::forget(state);
    return lithe::fmu::Outcome::ok;
  });
}
LITHE_FMU_EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t* size) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) { return c.size(state, size); });
}
LITHE_FMU_EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte* bytes,
                                                  size_t size) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) { return c.serialize(state, bytes, size); });
}
LITHE_FMU_EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte* bytes, size_t size,
                                                    fmi3FMUState* state) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) { return c.deserialize(bytes, size, state); });
}

// ---- events ----

LITHE_FMU_EXPORT fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
  return lithe::fmu::v3::with(
      instance, [](lithe::fmu::Component& c) { return c.leave_event("EnterStepMode", lithe::fmu::kStep); });
}
LITHE_FMU_EXPORT fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
  return lithe::fmu::v3::with(instance, [](lithe::fmu::Component& c) { return c.enter_event(); });
}
LITHE_FMU_EXPORT fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) {
  return lithe::fmu::v3::with(instance, [](lithe::fmu::Component& c) {
    return c.leave_event("EnterContinuousTimeMode", lithe::fmu::kContinuous);
  });
}
LITHE_FMU_EXPORT fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean* again, fmi3Boolean* terminate,
                                                     fmi3Boolean* nominals_changed, fmi3Boolean* states_changed,
                                                     fmi3Boolean* next_event, fmi3Float64*) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) {
    *again = *terminate = *nominals_changed = *next_event = false;
    return c.update(*states_changed);
  });
}

// ---- model exchange ----

LITHE_FMU_EXPORT fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean, fmi3Boolean* event,
                                                        fmi3Boolean* terminate) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) {
    *terminate = false;
    return c.completed_step(*event);
  });
}
LITHE_FMU_EXPORT fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time) {
  return lithe::fmu::v3::with(instance,
                              [&](lithe::fmu::Component& c) { return c.set_time(lithe::fmu::kContinuous, time); });
}
LITHE_FMU_EXPORT fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64* x, size_t count) {
  return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) { return c.set_states(x, count); });
}
#define LITHE_LOOK(NAME, WORK)                                                                              \
  LITHE_FMU_EXPORT fmi3Status fmi3##NAME(fmi3Instance instance, fmi3Float64* values, size_t count) {        \
    return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) { return c.WORK(values, count); }); \
  }
LITHE_LOOK(GetContinuousStates, states)
LITHE_LOOK(GetContinuousStateDerivatives, derivatives)
LITHE_LOOK(GetNominalsOfContinuousStates, nominals)
LITHE_LOOK(GetEventIndicators, indicators)
#undef LITHE_LOOK
#define LITHE_COUNT(NAME, WHAT)                                                                                 \
  LITHE_FMU_EXPORT fmi3Status fmi3##NAME(fmi3Instance instance, size_t* count) {                                \
    return lithe::fmu::v3::with(                                                                                \
        instance, [&](lithe::fmu::Component& c) { return c.count(#NAME, &lithe::FmuEquations::WHAT, count); }); \
  }
LITHE_COUNT(GetNumberOfContinuousStates, state_count)
LITHE_COUNT(GetNumberOfEventIndicators, indicator_count)
#undef LITHE_COUNT
#define LITHE_DERIVATIVE(NAME, WHAT, SEEDS, RESULTS)                                                                \
  LITHE_FMU_EXPORT fmi3Status fmi3##NAME(fmi3Instance instance, const fmi3ValueReference* unknowns, size_t unknown, \
                                         const fmi3ValueReference* knowns, size_t known, const fmi3Float64* seed,   \
                                         size_t seeds, fmi3Float64* sensitivity, size_t results) {                  \
    return lithe::fmu::v3::with(instance, [&](lithe::fmu::Component& c) {                                           \
      if (seeds != SEEDS || results != RESULTS) return c.none(#NAME, 1);                                            \
      return c.derivative(#NAME, &lithe::FmuInstance::WHAT, {unknowns, unknown}, {knowns, known}, {seed, seeds},    \
                          {sensitivity, results});                                                                  \
    });                                                                                                             \
  }
LITHE_DERIVATIVE(GetDirectionalDerivative, directional_derivative, known, unknown)
LITHE_DERIVATIVE(GetAdjointDerivative, adjoint_derivative, unknown, known)
#undef LITHE_DERIVATIVE

// ---- what this FMU does not offer, and says so ----

#define LITHE_REFUSE(NAME, ...)                                                  \
  LITHE_FMU_EXPORT fmi3Status fmi3##NAME(fmi3Instance instance, ##__VA_ARGS__) { \
    return lithe::fmu::v3::refuse(instance, #NAME);                              \
  }
LITHE_REFUSE(GetNumberOfVariableDependencies, fmi3ValueReference, size_t*)
LITHE_REFUSE(GetVariableDependencies, fmi3ValueReference, size_t*, fmi3ValueReference*, size_t*, fmi3DependencyKind*,
             size_t)
LITHE_REFUSE(EnterConfigurationMode)
LITHE_REFUSE(ExitConfigurationMode)
LITHE_REFUSE(GetIntervalDecimal, const fmi3ValueReference*, size_t, fmi3Float64*, fmi3IntervalQualifier*)
LITHE_REFUSE(GetIntervalFraction, const fmi3ValueReference*, size_t, fmi3UInt64*, fmi3UInt64*, fmi3IntervalQualifier*)
LITHE_REFUSE(GetShiftDecimal, const fmi3ValueReference*, size_t, fmi3Float64*)
LITHE_REFUSE(GetShiftFraction, const fmi3ValueReference*, size_t, fmi3UInt64*, fmi3UInt64*)
LITHE_REFUSE(SetIntervalDecimal, const fmi3ValueReference*, size_t, const fmi3Float64*)
LITHE_REFUSE(SetIntervalFraction, const fmi3ValueReference*, size_t, const fmi3UInt64*, const fmi3UInt64*)
LITHE_REFUSE(SetShiftDecimal, const fmi3ValueReference*, size_t, const fmi3Float64*)
LITHE_REFUSE(SetShiftFraction, const fmi3ValueReference*, size_t, const fmi3UInt64*, const fmi3UInt64*)
LITHE_REFUSE(EvaluateDiscreteStates)
LITHE_REFUSE(GetOutputDerivatives, const fmi3ValueReference*, size_t, const fmi3Int32*, fmi3Float64*, size_t)
LITHE_REFUSE(ActivateModelPartition, fmi3ValueReference, fmi3Float64)
#undef LITHE_REFUSE
