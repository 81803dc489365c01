#pragma once

#include "engine/fmu/fmu_border.h"

/// The functions of FMI 2.0 (Modelica Association, FMI 2.0.5) for model exchange and co-simulation, over an
/// FmuInstance. Included once, in the source that `lithe fmu` compiles, after a function lithe::FmuModel
/// lithe_fmu_model().
extern "C" {

using fmi2Component = void*;
using fmi2ComponentEnvironment = void*;
using fmi2FMUstate = void*;
using fmi2ValueReference = unsigned int;
using fmi2Real = double;
using fmi2Integer = int;
using fmi2Boolean = int;
using fmi2String = const char*;
using fmi2Byte = char;
enum fmi2Status { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending };
enum fmi2Type { fmi2ModelExchange, fmi2CoSimulation };
enum fmi2StatusKind { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated };
struct fmi2CallbackFunctions {
  void (*logger)(fmi2ComponentEnvironment, fmi2String instance, fmi2Status, fmi2String category, fmi2String message,
                 ...);
  void* (*allocateMemory)(size_t, size_t);
  void (*freeMemory)(void*);
  void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
  fmi2ComponentEnvironment componentEnvironment;
};
struct fmi2EventInfo {
  fmi2Boolean newDiscreteStatesNeeded, terminateSimulation, nominalsOfContinuousStatesChanged,
      valuesOfContinuousStatesChanged, nextEventTimeDefined;
  fmi2Real nextEventTime;
};

}  // extern "C"

namespace lithe::fmu::v2 {

template <class Work>
fmi2Status with(fmi2Component component, Work&& work) noexcept {
  if (!component) return fmi2Error;
  return static_cast<fmi2Status>(work(*static_cast<Component*>(component)));
}
inline fmi2Status refuse(fmi2Component component, const char* function) noexcept {
  return with(component, [&](Component& c) {
    c.tell(Outcome::error, "logStatusError", std::string(function) + " is not offered by this FMU");
    return Outcome::error;
  });
}

}  // namespace lithe::fmu::v2

LITHE_FMU_EXPORT const char* fmi2GetTypesPlatform() { return "default"; }
LITHE_FMU_EXPORT const char* fmi2GetVersion() { return "2.0"; }
LITHE_FMU_EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t, const fmi2String*) {
  return lithe::fmu::v2::with(component, [&](lithe::fmu::Component& c) {
    c.logging = on != 0;
    return lithe::fmu::Outcome::ok;
  });
}

LITHE_FMU_EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                               const fmi2CallbackFunctions* functions, fmi2Boolean,
                                               fmi2Boolean logging) {
  using namespace lithe::fmu;
  try {
    const std::string instance = name ? name : "";
    const auto tell = [functions, instance](Outcome outcome, const char* category, const std::string& message) {
      // The message is an argument: the importer takes the format for printf's.
      if (functions && functions->logger)
        functions->logger(functions->componentEnvironment, instance.c_str(), static_cast<fmi2Status>(outcome), category,
                          "%s", message.c_str());
    };
    const auto refuse = [&](const std::string& why) -> fmi2Component {
      tell(Outcome::error, "logStatusError", why);
      return nullptr;
    };
    try {
      const lithe::ResourceFolder folder(lithe::ResourceFolder::of_address(resources));
      static const lithe::FmuModel model = lithe_fmu_model();
      if (!guid || model.token != guid) return refuse("the GUID is that of another FMU");
      using Form = lithe::FmuInstance::Form;
      return new Component(model, type == fmi2CoSimulation ? Form::co_simulation : Form::model_exchange, tell,
                           logging != 0);
    } catch (const std::exception& error) {
      return refuse(error.what());
    }
  } catch (...) {
    return nullptr;
  }
}
LITHE_FMU_EXPORT void fmi2FreeInstance(fmi2Component component) {
  delete static_cast<lithe::fmu::Component*>(component);
}

LITHE_FMU_EXPORT fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean has_tolerance, fmi2Real tolerance,
                                                fmi2Real start, fmi2Boolean, fmi2Real) {
  return lithe::fmu::v2::with(component,
                              [&](lithe::fmu::Component& c) { return c.set_up(start, has_tolerance ? tolerance : 0); });
}
LITHE_FMU_EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component component) {
  return lithe::fmu::v2::with(component, [](lithe::fmu::Component& c) { return c.enter_initialization(); });
}
LITHE_FMU_EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component component) {
  return lithe::fmu::v2::with(component, [](lithe::fmu::Component& c) { return c.exit_initialization(); });
}
LITHE_FMU_EXPORT fmi2Status fmi2Terminate(fmi2Component component) {
  return lithe::fmu::v2::with(component, [](lithe::fmu::Component& c) { return c.terminate(); });
}
LITHE_FMU_EXPORT fmi2Status fmi2Reset(fmi2Component component) {
  return lithe::fmu::v2::with(component, [](lithe::fmu::Component& c) { return c.reset(); });
}
LITHE_FMU_EXPORT fmi2Status fmi2DoStep(fmi2Component component, fmi2Real current, fmi2Real size, fmi2Boolean) {
  return lithe::fmu::v2::with(component, [&](lithe::fmu::Component& c) {
    bool early = false;
    return c.step(current, size, early);
  });
}

LITHE_FMU_EXPORT fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference* references, size_t count,
                                        fmi2Real* values) {
  return lithe::fmu::v2::with(component,
                              [&](lithe::fmu::Component& c) { return c.get("GetReal", references, count, values); });
}
LITHE_FMU_EXPORT fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference* references, size_t count,
                                        const fmi2Real* values) {
  return lithe::fmu::v2::with(component,
                              [&](lithe::fmu::Component& c) { return c.set("SetReal", references, count, values); });
}
#define LITHE_NO_VALUES(TYPE)                                                                                     \
  LITHE_FMU_EXPORT fmi2Status fmi2Get##TYPE(fmi2Component component, const fmi2ValueReference*, size_t count,     \
                                            fmi2##TYPE*) {                                                        \
    return lithe::fmu::v2::with(component, [&](lithe::fmu::Component& c) { return c.none("Get" #TYPE, count); }); \
  }                                                                                                               \
  LITHE_FMU_EXPORT fmi2Status fmi2Set##TYPE(fmi2Component component, const fmi2ValueReference*, size_t count,     \
                                            const fmi2##TYPE*) {                                                  \
    return lithe::fmu::v2::with(component, [&](lithe::fmu::Component& c) { return c.none("Set" #TYPE, count); }); \
  }
LITHE_NO_VALUES(Integer)
LITHE_NO_VALUES(Boolean)
LITHE_NO_VALUES(String)
#undef LITHE_NO_VALUES

LITHE_FMU_EXPORT fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate* state) {
  return lithe::fmu::v2::with(component, [&](lithe::fmu::Component& c) { return c.save(state); });
}
LITHE_FMU_EXPORT fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state) {
  return lithe::fmu::v2::with(component, [&](lithe::fmu::Component& c) { return c.load(state); });
}
LITHE_FMU_EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate* state) {
  return lithe::fmu::v2::with(component, [&](lithe::fmu::Component&) {
    lithe::fmu::Component::forget(state);
    return lithe::fmu::Outcome::ok;
  });
}
LITHE_FMU_EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t* size) {
  return lithe::fmu::v2::with(component, [&](lithe::fmu::Component& c) { return c.size(state, size); });
}
LITHE_FMU_EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte* bytes,
                                                  size_t size) {
  return lithe::fmu::v2::with(component, [&](lithe::fmu::Component& c) {
    return c.serialize(state, reinterpret_cast<unsigned char*>(bytes), size);
  });
}
LITHE_FMU_EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte* bytes, size_t size,
                                                    fmi2FMUstate* state) {
  return lithe::fmu::v2::with(component, [&](lithe::fmu::Component& c) {
    return c.deserialize(reinterpret_cast<const unsigned char*>(bytes), size, state);
  });
}
LITHE_FMU_EXPORT fmi2Status fmi2GetRealStatus(fmi2Component component, fmi2StatusKind kind, fmi2Real* value) {
  return lithe::fmu::v2::with(component, [&](lithe::fmu::Component& c) {
    if (kind != fmi2LastSuccessfulTime) return lithe::fmu::Outcome::discard;
    *value = c.time();
    return lithe::fmu::Outcome::ok;
  });
}
LITHE_FMU_EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component component, fmi2StatusKind kind, fmi2Boolean* value) {
  return lithe::fmu::v2::with(component, [&](lithe::fmu::Component&) {
    if (kind != fmi2Terminated) return lithe::fmu::Outcome::discard;
    *value = 0;  // it never asks to end
    return lithe::fmu::Outcome::ok;
  });
}

// ---- model exchange ----

LITHE_FMU_EXPORT fmi2Status fmi2EnterEventMode(fmi2Component component) {
  return lithe::fmu::v2::with(component, [](lithe::fmu::Component& c) { return c.enter_event(); });
}
LITHE_FMU_EXPORT fmi2Status fmi2EnterContinuousTimeMode(fmi2Component component) {
  return lithe::fmu::v2::with(component, [](lithe::fmu::Component& c) {
    return c.leave_event("EnterContinuousTimeMode", lithe::fmu::kContinuous);
  });
}
LITHE_FMU_EXPORT fmi2Status fmi2NewDiscreteStates(fmi2Component component, fmi2EventInfo* event) {
  return lithe::fmu::v2::with(component, [&](lithe::fmu::Component& c) {
    bool states_changed = false;
    const lithe::fmu::Outcome outcome = c.update(states_changed);
    *event = {.valuesOfContinuousStatesChanged = states_changed};
    return outcome;
  });
}
LITHE_FMU_EXPORT fmi2Status fmi2CompletedIntegratorStep(fmi2Component component, fmi2Boolean, fmi2Boolean* event,
                                                        fmi2Boolean* terminate) {
  return lithe::fmu::v2::with(component, [&](lithe::fmu::Component& c) {
    bool asks = false;
    const lithe::fmu::Outcome outcome = c.completed_step(asks);
    *event = asks, *terminate = 0;
    return outcome;
  });
}
LITHE_FMU_EXPORT fmi2Status fmi2SetTime(fmi2Component component, fmi2Real time) {
  return lithe::fmu::v2::with(component,
                              [&](lithe::fmu::Component& c) { return c.set_time(lithe::fmu::kExchange, time); });
}
LITHE_FMU_EXPORT fmi2Status fmi2SetContinuousStates(fmi2Component component, const fmi2Real* x, size_t count) {
  return lithe::fmu::v2::with(component, [&](lithe::fmu::Component& c) { return c.set_states(x, count); });
}
#define LITHE_LOOK(NAME, WORK)                                                                               \
  LITHE_FMU_EXPORT fmi2Status fmi2##NAME(fmi2Component component, fmi2Real* values, size_t count) {          \
    return lithe::fmu::v2::with(component, [&](lithe::fmu::Component& c) { return c.WORK(values, count); }); \
  }
LITHE_LOOK(GetContinuousStates, states)
LITHE_LOOK(GetDerivatives, derivatives)
LITHE_LOOK(GetNominalsOfContinuousStates, nominals)
LITHE_LOOK(GetEventIndicators, indicators)
#undef LITHE_LOOK
LITHE_FMU_EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference* unknowns,
                                                         size_t unknown, const fmi2ValueReference* knowns, size_t known,
                                                         const fmi2Real* seed, fmi2Real* sensitivity) {
  return lithe::fmu::v2::with(component, [&](lithe::fmu::Component& c) {
    return c.derivative("GetDirectionalDerivative", &lithe::FmuInstance::directional_derivative, {unknowns, unknown},
                        {knowns, known}, {seed, known}, {sensitivity, unknown});
  });
}

// ---- what this FMU does not offer, and says so ----

#define LITHE_REFUSE(NAME, ...)                                                    \
  LITHE_FMU_EXPORT fmi2Status fmi2##NAME(fmi2Component component, ##__VA_ARGS__) { \
    return lithe::fmu::v2::refuse(component, #NAME);                               \
  }
LITHE_REFUSE(SetRealInputDerivatives, const fmi2ValueReference*, size_t, const fmi2Integer*, const fmi2Real*)
LITHE_REFUSE(GetRealOutputDerivatives, const fmi2ValueReference*, size_t, const fmi2Integer*, fmi2Real*)
LITHE_REFUSE(CancelStep)
LITHE_REFUSE(GetStatus, fmi2StatusKind, fmi2Status*)
LITHE_REFUSE(GetIntegerStatus, fmi2StatusKind, fmi2Integer*)
LITHE_REFUSE(GetStringStatus, fmi2StatusKind, fmi2String*)
#undef LITHE_REFUSE
