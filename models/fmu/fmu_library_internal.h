#pragma once

#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "models/fmu/fmu_contents_internal.h"

namespace lithe {

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
  std::string last{};  // the newest of an error

  /// `status` as both standards number it: 0 ok, 1 warning, 2 discard, 3 error, 4 fatal.
  void tell(int status, const std::string& message);
  /// Throws SimulationError from discard on.
  void check(const std::string& function, int status);
  [[noreturn]] void ends_simulation() const;
};

/// A function of the standard on an instance, looked up when it is first called: binaries may leave out what they say
/// that they cannot do.
template <class... Arguments>
struct FmuFunction {
  std::string name;
  int (*address)(void* unit, Arguments...) = nullptr;
};

/// One instance of an imported unit, by either version of the standard. A call that the unit answers by an error throws
/// SimulationError with what the unit told; then it is not to be called again.
class FmuLibrary {
 public:
  virtual ~FmuLibrary();

  /// From a fresh instance to initialization, and from there to stepping or events.
  virtual void enter_initialization(double start) = 0;
  void exit_initialization() { call(exit_initialization_); }
  virtual void step(double time, double size) = 0;
  virtual double get(const FmuNumber& number) = 0;
  virtual void set(const FmuNumber& number, double value) = 0;
  /// Its state as bytes, of which another instance can be made.
  std::vector<unsigned char> save();
  void load(const std::vector<unsigned char>& bytes);

  template <class... Arguments>
  void call(FmuFunction<Arguments...>& function, std::type_identity_t<Arguments>... arguments) {
    messages_.check(function.name, status_of(function, arguments...));
  }
  /// The same; false where the unit discards the call: it has no answer at such values.
  template <class... Arguments>
  bool try_call(FmuFunction<Arguments...>& function, std::type_identity_t<Arguments>... arguments) {
    constexpr int kDiscard = 2;
    const int status = status_of(function, arguments...);
    if (status != kDiscard) messages_.check(function.name, status);
    return status != kDiscard;
  }
  const FmuMessages& messages() const { return messages_; }

 protected:
  using Unit = void*;
  /// `prefix`: fmi2 or fmi3; `state`, `deserialize`: how it spells these in names.
  FmuLibrary(std::unique_ptr<SharedLibrary> library, FmuMessages messages, const std::string& prefix,
             const std::string& state, const std::string& deserialize);
  /// Makes the instance by `make`, once: `function` names it in errors.
  template <class Make>
  void instantiate(const std::string& function, Make&& make) {
    unit_ = make();
    if (!unit_) messages_.check(function, /*error*/ 3);
  }

  const std::unique_ptr<SharedLibrary> library_;
  FmuMessages messages_;

 private:
  template <class... Arguments>
  int status_of(FmuFunction<Arguments...>& function, Arguments... arguments) {
    if (!function.address) function.address = library_->function<int(void*, Arguments...)>(function.name);
    return function.address(unit_, arguments...);
  }

  Unit unit_ = nullptr;
  void (*const free_instance_)(Unit);
  FmuFunction<> exit_initialization_;
  FmuFunction<void**> get_state_, free_state_;
  FmuFunction<void*> set_state_;
  FmuFunction<void*, std::size_t*> state_size_;
  FmuFunction<void*, unsigned char*, std::size_t> serialize_;
  FmuFunction<const unsigned char*, std::size_t, void**> deserialize_;
};

/// Loads the binary for this platform from the unpacked FMU in `folder` and makes an instance. Throws FileError where
/// there is none for it, or one that cannot be loaded; `path` is the FMU's.
std::unique_ptr<FmuLibrary> make_fmu_library(const FmuContents& contents, FmuKind kind, const std::string& folder,
                                             const std::string& path, const std::string& instance);

std::unique_ptr<FmuLibrary> make_fmi2_library(const FmuContents& contents, FmuKind kind,
                                              std::unique_ptr<SharedLibrary> library, const std::string& resources,
                                              FmuMessages messages);
std::unique_ptr<FmuLibrary> make_fmi3_library(const FmuContents& contents, FmuKind kind,
                                              std::unique_ptr<SharedLibrary> library, const std::string& resources,
                                              FmuMessages messages);

}  // namespace lithe
