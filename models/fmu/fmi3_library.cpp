// FMI 3.0 (Modelica Association, FMI 3.0.2), the importer's side of co-simulation.
#include <cmath>
#include <cstdint>

#include "engine/base/error.h"
#include "models/fmu/fmu_library_internal.h"

namespace lithe {
namespace {

using Status = int;
using Unit = void*;

void log_message(void* environment, Status status, const char*, const char* message) {
  static_cast<FmuMessages*>(environment)->tell(status, message ? message : "");
}

/// Calls work.operator()<Number>() for the C type of a variable.
template <class Work>
void with_type(const std::string& type, Work&& work) {
  if (type == "Float64") return work.template operator()<double>();
  if (type == "Float32") return work.template operator()<float>();
  if (type == "Int8") return work.template operator()<std::int8_t>();
  if (type == "UInt8") return work.template operator()<std::uint8_t>();
  if (type == "Int16") return work.template operator()<std::int16_t>();
  if (type == "UInt16") return work.template operator()<std::uint16_t>();
  if (type == "Int32") return work.template operator()<std::int32_t>();
  if (type == "UInt32") return work.template operator()<std::uint32_t>();
  if (type == "Int64") return work.template operator()<std::int64_t>();
  if (type == "UInt64") return work.template operator()<std::uint64_t>();
  work.template operator()<bool>();
}

class Fmi3Library final : public FmuCalls {
 public:
  Fmi3Library(const FmuContents& contents, std::unique_ptr<SharedLibrary> library, const std::string& resources,
              FmuMessages messages)
      : FmuCalls(std::move(library), std::move(messages),
                 {"fmi3GetFMUState", "fmi3SetFMUState", "fmi3FreeFMUState", "fmi3SerializedFMUStateSize",
                  "fmi3SerializeFMUState", "fmi3DeserializeFMUState"}) {
    using Instantiate = Unit(const char* name, const char* token, const char* resources, bool visible, bool logging,
                             bool event_mode, bool early_return, const std::uint32_t* intermediate, std::size_t count,
                             void* environment, void (*log)(void*, Status, const char*, const char*), void (*update)());
    unit_ = library_->function<Instantiate>("fmi3InstantiateCoSimulation")(
        messages_.instance.c_str(), contents.token.c_str(), (resources + "/").c_str(), false, false, false, false,
        nullptr, 0, &messages_, log_message, nullptr);
    if (!unit_) messages_.check("fmi3InstantiateCoSimulation", 3);
  }
  ~Fmi3Library() override { library_->function<void(Unit)>("fmi3FreeInstance")(unit_); }

  void enter_initialization(double start) override {
    call<bool, double, double, bool, double>("fmi3EnterInitializationMode", false, 0.0, start, false, 0.0);
  }
  void exit_initialization() override { call<>("fmi3ExitInitializationMode"); }
  void step(double time, double size) override {
    bool event = false, terminate = false, early = false;
    double reached = 0;
    call<double, double, bool, bool*, bool*, bool*, double*>("fmi3DoStep", time, size, true, &event, &terminate, &early,
                                                             &reached);
    if (terminate)
      throw SimulationError("the FMU asks to end the simulation.", messages_.fmu, "look at its inputs and parameters.");
  }

  double get(const ImportedVariable& variable) override {
    double out = 0;
    with_type(variable.type, [&]<class Number>() {
      Number value{};
      call<const std::uint32_t*, std::size_t, Number*, std::size_t>("fmi3Get" + variable.type, &variable.reference, 1,
                                                                    &value, 1);
      out = static_cast<double>(value);
    });
    return out;
  }
  void set(const ImportedVariable& variable, double value) override {
    with_type(variable.type, [&]<class Number>() {
      Number number;
      if constexpr (std::is_same_v<Number, bool>)
        number = value != 0;
      else
        number = static_cast<Number>(std::is_integral_v<Number> ? std::round(value) : value);
      call<const std::uint32_t*, std::size_t, const Number*, std::size_t>("fmi3Set" + variable.type,
                                                                          &variable.reference, 1, &number, 1);
    });
  }
};

}  // namespace

std::unique_ptr<FmuLibrary> make_fmi3_library(const FmuContents& contents, std::unique_ptr<SharedLibrary> library,
                                              const std::string& resources, FmuMessages messages) {
  return std::make_unique<Fmi3Library>(contents, std::move(library), resources, std::move(messages));
}

}  // namespace lithe
