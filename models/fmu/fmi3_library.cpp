// FMI 3.0 (Modelica Association, FMI 3.0.2), the importer's side.
#include <cmath>
#include <cstdint>
#include <map>
#include <tuple>

#include "models/fmu/fmu_library_internal.h"

namespace lithe {
namespace {

using Status = int;

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

class Fmi3Library final : public FmuLibrary {
 public:
  Fmi3Library(const FmuContents& contents, FmuKind kind, std::unique_ptr<SharedLibrary> library,
              const std::string& resources, FmuMessages messages)
      : FmuLibrary(std::move(library), std::move(messages), "fmi3", "FMUState", "Deserialize") {
    using Log = void (*)(void*, Status, const char*, const char*);
    using CoSimulation = Unit(const char* name, const char* token, const char* resources, bool visible, bool logging,
                              bool event_mode, bool early_return, const std::uint32_t* intermediate, std::size_t count,
                              void* environment, Log log, void (*update)());
    using ModelExchange = Unit(const char* name, const char* token, const char* resources, bool visible, bool logging,
                               void* environment, Log log);
    const std::string function = kind == FmuKind::co_simulation ? "fmi3InstantiateCoSimulation"  //
                                                                : "fmi3InstantiateModelExchange";
    instantiate(function, [&] {
      const char *name = messages_.instance.c_str(), *token = contents.token.c_str();
      const std::string folder = resources + "/";
      if (kind == FmuKind::model_exchange)
        return library_->function<ModelExchange>(function)(name, token, folder.c_str(), false, false, &messages_,
                                                           log_message);
      return library_->function<CoSimulation>(function)(name, token, folder.c_str(), false, false, false, false,
                                                        nullptr, 0, &messages_, log_message, nullptr);
    });
  }

  void enter_initialization(double start) override { call(enter_initialization_, false, 0.0, start, false, 0.0); }
  void step(double time, double size) override {
    bool event = false, terminate = false, early = false;
    double reached = 0;
    call(do_step_, time, size, true, &event, &terminate, &early, &reached);
    if (terminate) messages_.ends_simulation();
  }

  double get(const FmuNumber& number) override {
    double out = 0;
    with_type(number.variable->type, [&]<class Number>() {
      const std::size_t size = static_cast<std::size_t>(number.variable->size);
      const auto values = std::make_unique<Number[]>(size);
      call(access<Number>(number).get, &number.variable->reference, 1, values.get(), size);
      out = static_cast<double>(values[static_cast<std::size_t>(number.entry)]);
    });
    return out;
  }
  /// Arrays are set as a whole: what has been set of them is kept.
  void set(const FmuNumber& number, double value) override {
    const std::size_t size = static_cast<std::size_t>(number.variable->size);
    std::vector<double>& all = set_[number.variable->reference];
    for (int i = static_cast<int>(all.size()); i < number.variable->size; ++i) all.push_back(number.variable->start(i));
    all[static_cast<std::size_t>(number.entry)] = value;
    with_type(number.variable->type, [&]<class Number>() {
      const auto values = std::make_unique<Number[]>(size);
      for (std::size_t i = 0; i < size; ++i)
        if constexpr (std::is_same_v<Number, bool>)
          values[i] = all[i] != 0;
        else
          values[i] = static_cast<Number>(std::is_integral_v<Number> ? std::round(all[i]) : all[i]);
      call(access<Number>(number).set, &number.variable->reference, 1, values.get(), size);
    });
  }

 private:
  template <class Number>
  struct Access {
    FmuFunction<const std::uint32_t*, std::size_t, Number*, std::size_t> get;
    FmuFunction<const std::uint32_t*, std::size_t, const Number*, std::size_t> set;
  };
  template <class Number>
  Access<Number>& access(const FmuNumber& number) {
    auto& out = std::get<Access<Number>>(accesses_);
    if (out.get.name.empty()) out = {{"fmi3Get" + number.variable->type}, {"fmi3Set" + number.variable->type}};
    return out;
  }

  FmuFunction<bool, double, double, bool, double> enter_initialization_{"fmi3EnterInitializationMode"};
  FmuFunction<double, double, bool, bool*, bool*, bool*, double*> do_step_{"fmi3DoStep"};
  std::tuple<Access<double>, Access<float>, Access<std::int8_t>, Access<std::uint8_t>, Access<std::int16_t>,
             Access<std::uint16_t>, Access<std::int32_t>, Access<std::uint32_t>, Access<std::int64_t>,
             Access<std::uint64_t>, Access<bool>>
      accesses_;
  std::map<unsigned, std::vector<double>> set_;  // of value references
};

}  // namespace

std::unique_ptr<FmuLibrary> make_fmi3_library(const FmuContents& contents, FmuKind kind,
                                              std::unique_ptr<SharedLibrary> library, const std::string& resources,
                                              FmuMessages messages) {
  return std::make_unique<Fmi3Library>(contents, kind, std::move(library), resources, std::move(messages));
}

}  // namespace lithe
