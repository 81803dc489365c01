#pragma once

#include <memory>
#include <string>
#include <vector>

#include "models/fmu/fmu_contents_internal.h"

namespace lithe {

/// One instance of an imported unit, by either version of the standard. A call that the unit answers by an error throws
/// SimulationError with what the unit told; then it is not to be called again.
class FmuLibrary {
 public:
  virtual ~FmuLibrary() = default;

  /// From a fresh instance to initialization, and from there to stepping.
  virtual void enter_initialization(double start) = 0;
  virtual void exit_initialization() = 0;
  virtual void step(double time, double size) = 0;
  virtual double get(const ImportedVariable& variable) = 0;
  virtual void set(const ImportedVariable& variable, double value) = 0;
  virtual std::vector<unsigned char> save() = 0;
  virtual void load(const std::vector<unsigned char>& bytes) = 0;
};

/// Loads the binary for this platform from the unpacked FMU in `folder` and makes an instance. Throws FileError where
/// there is none for it, or one that cannot be loaded; `path` is the FMU's.
std::unique_ptr<FmuLibrary> make_fmu_library(const FmuContents& contents, const std::string& folder,
                                             const std::string& path, const std::string& instance);

/// A shared library and its functions by name.
class SharedLibrary {
 public:
  SharedLibrary(const std::string& file, const std::string& fmu);
  ~SharedLibrary();
  SharedLibrary(const SharedLibrary&) = delete;
  SharedLibrary& operator=(const SharedLibrary&) = delete;

  /// Throws FileError for one that is missing.
  template <class Function>
  Function* function(const std::string& name) const {
    return reinterpret_cast<Function*>(address(name));
  }

 private:
  void* address(const std::string& name) const;
  std::string fmu_;
  void* handle_;
};

/// What a unit tells through its logger, and what becomes of a status.
struct FmuMessages {
  std::string fmu, instance;
  std::string last;  // the newest of an error

  /// `status` as both standards number it: 0 ok, 1 warning, 2 discard, 3 error, 4 fatal.
  void tell(int status, const std::string& message);
  /// Throws SimulationError from discard on.
  void check(const std::string& function, int status);
};

/// What both standards do alike: a call and its status, the state as bytes.
class FmuCalls : public FmuLibrary {
 public:
  std::vector<unsigned char> save() override;
  void load(const std::vector<unsigned char>& bytes) override;

 protected:
  struct StateFunctions {
    const char *get, *set, *free, *size, *serialize, *deserialize;
  };
  FmuCalls(std::unique_ptr<SharedLibrary> library, FmuMessages messages, const StateFunctions& state_functions)
      : library_(std::move(library)), messages_(std::move(messages)), state_functions_(state_functions) {}

  template <class... Arguments>
  void call(const std::string& name, Arguments... arguments) {
    messages_.check(name, library_->function<int(void*, Arguments...)>(name)(unit_, arguments...));
  }

  const std::unique_ptr<SharedLibrary> library_;
  FmuMessages messages_;
  void* unit_ = nullptr;

 private:
  const StateFunctions state_functions_;
};

std::unique_ptr<FmuLibrary> make_fmi2_library(const FmuContents& contents, std::unique_ptr<SharedLibrary> library,
                                              const std::string& resources, FmuMessages messages);
std::unique_ptr<FmuLibrary> make_fmi3_library(const FmuContents& contents, std::unique_ptr<SharedLibrary> library,
                                              const std::string& resources, FmuMessages messages);

}  // namespace lithe
