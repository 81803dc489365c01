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

std::vector<unsigned char> FmuCalls::save() {
  void* state = nullptr;
  std::size_t size = 0;
  call<void**>(state_functions_.get, &state);
  call<void*, std::size_t*>(state_functions_.size, state, &size);
  std::vector<unsigned char> bytes(size);
  call<void*, unsigned char*, std::size_t>(state_functions_.serialize, state, bytes.data(), size);
  call<void**>(state_functions_.free, &state);
  return bytes;
}

void FmuCalls::load(const std::vector<unsigned char>& bytes) {
  void* state = nullptr;
  call<const unsigned char*, std::size_t, void**>(state_functions_.deserialize, bytes.data(), bytes.size(), &state);
  call<void*>(state_functions_.set, state);
  call<void**>(state_functions_.free, &state);
}

std::unique_ptr<FmuLibrary> make_fmu_library(const FmuContents& contents, const std::string& folder,
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
  return two ? make_fmi2_library(contents, std::move(library), resources, std::move(messages))
             : make_fmi3_library(contents, std::move(library), resources, std::move(messages));
}

}  // namespace lithe
