// FMI 2.0 (Modelica Association, FMI 2.0.5), the importer's side.
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>

#include "models/fmu/fmu_library_internal.h"

namespace lithe {
namespace {

using Status = int;
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

class Fmi2Library final : public FmuLibrary {
 public:
  Fmi2Library(const FmuContents& contents, FmuKind kind, std::unique_ptr<SharedLibrary> library,
              const std::string& resources, FmuMessages messages)
      : FmuLibrary(std::move(library), std::move(messages), "fmi2", "FMUstate", "DeSerialize") {
    callbacks_ = {log_message, std::calloc, std::free, nullptr, &messages_};
    using Instantiate = Unit(const char* name, int type, const char* token, const char* resources,
                             const Callbacks* callbacks, int visible, int logging);
    instantiate("fmi2Instantiate", [&] {
      return library_->function<Instantiate>("fmi2Instantiate")(messages_.instance.c_str(),
                                                                kind == FmuKind::co_simulation, contents.token.c_str(),
                                                                ("file://" + resources).c_str(), &callbacks_, 0, 0);
    });
  }

  void enter_initialization(double start) override {
    call(setup_, 0, 0.0, start, 0, 0.0);
    call(enter_initialization_);
  }
  void step(double time, double size) override { call(do_step_, time, size, 1); }

  double get(const FmuNumber& number) override {
    if (number.variable->type == "Float64") return got(reals_, number);
    return got(number.variable->type == "Boolean" ? booleans_ : integers_, number);
  }
  void set(const FmuNumber& number, double value) override {
    if (number.variable->type == "Float64")
      give(reals_, number, value);
    else if (number.variable->type == "Boolean")
      give(booleans_, number, static_cast<int>(value != 0));
    else
      give(integers_, number, static_cast<int>(std::lround(value)));
  }

 private:
  template <class Number>
  struct Access {
    FmuFunction<const unsigned*, std::size_t, Number*> get;
    FmuFunction<const unsigned*, std::size_t, const Number*> set;
  };
  template <class Number>
  double got(Access<Number>& access, const FmuNumber& number) {
    Number value{};
    call(access.get, &number.variable->reference, 1, &value);
    return static_cast<double>(value);
  }
  template <class Number>
  void give(Access<Number>& access, const FmuNumber& number, Number value) {
    call(access.set, &number.variable->reference, 1, &value);
  }

  Callbacks callbacks_{};
  FmuFunction<int, double, double, int, double> setup_{"fmi2SetupExperiment"};
  FmuFunction<> enter_initialization_{"fmi2EnterInitializationMode"};
  FmuFunction<double, double, int> do_step_{"fmi2DoStep"};
  Access<double> reals_{{"fmi2GetReal"}, {"fmi2SetReal"}};
  Access<int> integers_{{"fmi2GetInteger"}, {"fmi2SetInteger"}}, booleans_{{"fmi2GetBoolean"}, {"fmi2SetBoolean"}};
};

}  // namespace

std::unique_ptr<FmuLibrary> make_fmi2_library(const FmuContents& contents, FmuKind kind,
                                              std::unique_ptr<SharedLibrary> library, const std::string& resources,
                                              FmuMessages messages) {
  return std::make_unique<Fmi2Library>(contents, kind, std::move(library), resources, std::move(messages));
}

}  // namespace lithe
