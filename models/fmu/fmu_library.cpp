#include <dlfcn.h>

#include <filesystem>

#include "engine/base/error.h"
#include "engine/base/log.h"
#include "models/fmu/fmu_library_internal.h"

namespace lithe {

namespace fs = std::filesystem;

SharedLibrary::SharedLibrary(const std::string& file, const std::string& fmu)
    : fmu_(fmu), handle_(dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
  if (!handle_)
    throw FileError("the FMU's binary cannot be loaded: " + std::string(dlerror()) + ".", fmu,
                    "install the libraries that it names.");
}
SharedLibrary::~SharedLibrary() { dlclose(handle_); }

void* SharedLibrary::address(const std::string& name) const {
  void* found = dlsym(handle_, name.c_str());
  if (!found) throw FileError("the FMU's binary has no function " + name + ".", fmu_, "export the FMU again.");
  return found;
}

void FmuMessages::tell(int status, const std::string& message) {
  if (status >= 2) last = message;
  if (status == 0)
    log::debug("'" + instance + "': " + message);
  else if (status == 1)
    log::warn("'" + instance + "': " + message);
}

void FmuMessages::check(const std::string& function, int status) {
  if (status < 2) return;
  const char* answer = status == 2 ? "discards it" : status == 3 ? "gives an error" : "gives a fatal error";
  throw SimulationError("the FMU's " + function + " " + answer + (last.empty() ? "." : ": " + last), fmu,
                        status == 2 ? "take a shorter interval." : "look at its inputs and parameters.");
}

void FmuMessages::ends_simulation() const {
  throw SimulationError("the FMU asks to end the simulation.", fmu, "look at its inputs and parameters.");
}

FmuLibrary::FmuLibrary(std::unique_ptr<SharedLibrary> library, FmuMessages messages, const std::string& prefix,
                       const std::string& state, const std::string& deserialize)
    : library_(std::move(library)),
      messages_(std::move(messages)),
      free_instance_(library_->function<void(Unit)>(prefix + "FreeInstance")),
      exit_initialization_{prefix + "ExitInitializationMode"},
      get_state_{prefix + "Get" + state},
      free_state_{prefix + "Free" + state},
      set_state_{prefix + "Set" + state},
      state_size_{prefix + "Serialized" + state + "Size"},
      serialize_{prefix + "Serialize" + state},
      deserialize_{prefix + deserialize + state} {}

FmuLibrary::~FmuLibrary() {
  if (unit_) free_instance_(unit_);
}

std::vector<unsigned char> FmuLibrary::save() {
  void* state = nullptr;
  std::size_t size = 0;
  call(get_state_, &state);
  call(state_size_, state, &size);
  std::vector<unsigned char> bytes(size);
  call(serialize_, state, bytes.data(), size);
  call(free_state_, &state);
  return bytes;
}

void FmuLibrary::load(const std::vector<unsigned char>& bytes) {
  void* state = nullptr;
  call(deserialize_, bytes.data(), bytes.size(), &state);
  call(set_state_, state);
  call(free_state_, &state);
}

std::unique_ptr<FmuLibrary> make_fmu_library(const FmuContents& contents, FmuKind kind, const std::string& folder,
                                             const std::string& path, const std::string& instance) {
  const bool two = contents.version == 2;
  const fs::path binaries = fs::path(folder) / "binaries";
  const std::string platform = two ? "linux64" : "x86_64-linux";
  const fs::path file = binaries / platform / (contents.identifier + ".so");
  if (!fs::is_regular_file(file)) {
    std::string there;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(binaries, none))
      there += (there.empty() ? "" : ", ") + entry.path().filename().string();
    throw FileError("the FMU has no binary for " + platform + " (it has: " + (there.empty() ? "none" : there) + ").",
                    path, "export it for Linux on x86-64.");
  }
  auto library = std::make_unique<SharedLibrary>(file.string(), path);
  const std::string resources = (fs::path(folder) / "resources").string();
  FmuMessages messages{path, instance, {}};
  return two ? make_fmi2_library(contents, kind, std::move(library), resources, std::move(messages))
             : make_fmi3_library(contents, kind, std::move(library), resources, std::move(messages));
}

}  // namespace lithe
