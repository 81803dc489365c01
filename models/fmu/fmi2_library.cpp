// FMI 2.0 (Modelica Association, FMI 2.0.5), the importer's side of co-simulation.
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>

#include "models/fmu/fmu_library_internal.h"

namespace lithe {
namespace {

using Status = int;
using Unit = void*;

struct Callbacks {
  void (*logger)(void* environment, const char* instance, Status, const char* category, const char* format, ...);
  void* (*allocate)(std::size_t, std::size_t);
  void (*release)(void*);
  void (*step_finished)(void*, Status);
  void* environment;
};

void log_message(void* environment, const char*, Status status, const char*, const char* format, ...) {
  char text[4096] = "";
  va_list arguments;
  va_start(arguments, format);
  if (format) std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  static_cast<FmuMessages*>(environment)->tell(status, text);
}

class Fmi2Library final : public FmuCalls {
 public:
  Fmi2Library(const FmuContents& contents, std::unique_ptr<SharedLibrary> library, const std::string& resources,
              FmuMessages messages)
      : FmuCalls(std::move(library), std::move(messages),
                 {"fmi2GetFMUstate", "fmi2SetFMUstate", "fmi2FreeFMUstate", "fmi2SerializedFMUstateSize",
                  "fmi2SerializeFMUstate", "fmi2DeSerializeFMUstate"}) {
    callbacks_ = {log_message, std::calloc, std::free, nullptr, &messages_};
    constexpr int kCoSimulation = 1;
    const auto instantiate =
        library_->function<Unit(const char*, int, const char*, const char*, const Callbacks*, int, int)>(
            "fmi2Instantiate");
    unit_ = instantiate(messages_.instance.c_str(), kCoSimulation, contents.token.c_str(),
                        ("file://" + resources).c_str(), &callbacks_, 0, 0);
    if (!unit_) messages_.check("fmi2Instantiate", 3);
  }
  ~Fmi2Library() override { library_->function<void(Unit)>("fmi2FreeInstance")(unit_); }

  void enter_initialization(double start) override {
    call<int, double, double, int, double>("fmi2SetupExperiment", 0, 0.0, start, 0, 0.0);
    call<>("fmi2EnterInitializationMode");
  }
  void exit_initialization() override { call<>("fmi2ExitInitializationMode"); }
  void step(double time, double size) override { call<double, double, int>("fmi2DoStep", time, size, 1); }

  double get(const ImportedVariable& variable) override {
    if (variable.type == "Float64") return got<double>("fmi2GetReal", variable);
    return got<int>(variable.type == "Boolean" ? "fmi2GetBoolean" : "fmi2GetInteger", variable);
  }
  void set(const ImportedVariable& variable, double value) override {
    if (variable.type == "Float64")
      give("fmi2SetReal", variable, value);
    else if (variable.type == "Boolean")
      give("fmi2SetBoolean", variable, static_cast<int>(value != 0));
    else
      give("fmi2SetInteger", variable, static_cast<int>(std::lround(value)));
  }

 private:
  template <class Number>
  double got(const char* name, const ImportedVariable& variable) {
    Number value{};
    call<const unsigned*, std::size_t, Number*>(name, &variable.reference, 1, &value);
    return static_cast<double>(value);
  }
  template <class Number>
  void give(const char* name, const ImportedVariable& variable, Number value) {
    call<const unsigned*, std::size_t, const Number*>(name, &variable.reference, 1, &value);
  }

  Callbacks callbacks_{};
};

}  // namespace

std::unique_ptr<FmuLibrary> make_fmi2_library(const FmuContents& contents, std::unique_ptr<SharedLibrary> library,
                                              const std::string& resources, FmuMessages messages) {
  return std::make_unique<Fmi2Library>(contents, std::move(library), resources, std::move(messages));
}

}  // namespace lithe
