#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tests/scripting/command.h"

namespace lithe::test {

/// An FMU as made by the command, with a fixed step, s, and unpacked.
struct UnpackedFmu {
  std::filesystem::path folder, library;
  std::string description;

  UnpackedFmu(const ScriptFolder& scratch, const std::string& scene, int version, const std::string& options = "",
              const std::string& step = "1e-3");
  /// Of the first element with that name, or of the root.
  std::string attribute(const std::string& name) const;
  std::string token() const;
  /// 9999 and a failure: there is no such variable.
  unsigned reference(const std::string& variable) const;
  /// Outputs follow each other.
  unsigned first_output() const;
};

/// The unpacked description satisfies the standard's schema, where xmllint is installed.
void expect_valid_description(const ScriptFolder& scratch, int version);

/// model.fmu passes FMPy's validation and runs there, and in OMSimulator, where these are installed.
void expect_passes_importers(const ScriptFolder& scratch);

/// Rows of numbers among what a program prints, each behind the word row.
std::vector<std::vector<double>> rows_of(const std::string& output);
/// A number in every bit, as text.
std::string exact_text(double value);

/// What a program prints that drives the scene by Simulation, compiled by `lithe run` as FMUs are: rows of numbers, in
/// every bit. `body` is in main(), after graph, system, method (GeneralizedAlpha), simulation, state and
/// print(state, accelerations), which prints all outputs; `before` stands before main().
std::vector<std::vector<double>> native_rows(const ScriptFolder& scratch, const std::string& scene,
                                             const std::string& before, const std::string& body,
                                             const std::string& step = "1e-3");

/// Receives intermediate updates of an instance; returns whether to end the communication step.
using IntermediateUpdate = std::function<bool(double time, bool may_end)>;

/// The library's functions, by the standard's names and signatures (tests/data/fmi). It stays loaded for the rest of
/// the process, as scenes have statics.
class FmuLibrary {
 public:
  explicit FmuLibrary(const std::filesystem::path& path);
  template <class Result, class... Arguments>
  Result call(const std::string& name, Arguments... arguments) const {
    return reinterpret_cast<Result (*)(Arguments...)>(find(name))(arguments...);
  }
  bool has(const std::string& name) const;

 private:
  void* find(const std::string& name) const;
  void* handle_;
};

/// What an instance tells its importer, a line each.
struct FmuLog {
  std::string text;
};

struct FmuCallbacks2 {
  void (*logger)(void*, const char*, int, const char*, const char*, ...);
  void* (*allocate)(std::size_t, std::size_t);
  void (*release)(void*);
  void (*finished)(void*, int);
  void* environment;
};

/// One instance, by either standard: the library has both. Functions give the standard's status.
class ImportedInstance {
 public:
  enum class Form { model_exchange, co_simulation };
  ImportedInstance(const FmuLibrary& library, const std::string& token, int version, bool logging = false,
                   Form form = Form::co_simulation, const std::string& resources = "");
  /// For co-simulation by FMI 3.0 with all that it offers: event mode, intermediate updates, early return.
  ImportedInstance(const FmuLibrary& library, const std::string& token, IntermediateUpdate update);
  ~ImportedInstance();
  ImportedInstance(const ImportedInstance&) = delete;

  bool exists() const { return component_ != nullptr; }
  int start(double time = 0);
  int set(unsigned reference, double value);
  int get(const std::vector<unsigned>& references, std::vector<double>& values);
  int step(double time, double size);
  /// FMI 3.0: `last` is where the step has ended, `early` whether an update ended it.
  int step(double time, double size, bool& early, double& last);
  /// A function without arguments, without its prefix.
  int call(const std::string& name) { return library_.call<int>(full(name), component_); }

  int save(void** state);
  int restore(void* state);
  int forget(void** state);
  std::vector<unsigned char> serialized(void* state);
  int deserialize(const std::vector<unsigned char>& bytes, void** state);

  // ---- model exchange ----
  int set_time(double time) { return library_.call<int>(full("SetTime"), component_, time); }
  int set_states(std::span<const double> x) {
    return library_.call<int>(full("SetContinuousStates"), component_, x.data(), x.size());
  }
  int states(std::span<double> x) { return read("GetContinuousStates", x); }
  int derivatives(std::span<double> x) { return read(three_ ? "GetContinuousStateDerivatives" : "GetDerivatives", x); }
  int nominals(std::span<double> x) { return read("GetNominalsOfContinuousStates", x); }
  int indicators(std::span<double> x) { return read("GetEventIndicators", x); }
  int complete_step(bool& event);
  int update(bool& states_changed);
  int directional_derivative(const std::vector<unsigned>& unknowns, const std::vector<unsigned>& knowns,
                             const std::vector<double>& seed, std::vector<double>& sensitivity);

  FmuLog log;
  IntermediateUpdate update_of;  // what the importer does in an intermediate update

 private:
  std::string full(const std::string& name) const { return (three_ ? "fmi3" : "fmi2") + name; }
  int read(const std::string& name, std::span<double> x) {
    return library_.call<int>(full(name), component_, x.data(), x.size());
  }
  const FmuLibrary& library_;
  bool three_;
  FmuCallbacks2 callbacks_;
  void* component_ = nullptr;
};

}  // namespace lithe::test
