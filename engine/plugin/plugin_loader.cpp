#include "engine/plugin/plugin_loader.h"

#include <dlfcn.h>

#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr int kMostVersions = 100;

std::string entry_name(int version) { return "lithe_plugin_v" + std::to_string(version); }

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& problem, const std::string& fix) {
  throw FileError(problem, path.string(), fix);
}

/// Why a library without our entry does not serve: built for another version, or no plug-in at all.
[[noreturn]] void refuse_entry(const std::filesystem::path& path, void* library) {
  const std::string ours = std::to_string(LITHE_PLUGIN_VERSION);
  for (int version = 0; version < kMostVersions; ++version)
    if (dlsym(library, entry_name(version).c_str()))
      refuse(path,
             "the plug-in is built for version " + std::to_string(version) +
                 " of the plug-in interface; this Lithe has " + "version " + ours,
             "build the plug-in anew against this Lithe");
  refuse(path, "the library is not a Lithe plug-in: it has no symbol " + entry_name(LITHE_PLUGIN_VERSION),
         "build it with lithe_add_plugin(), and export its types with LITHE_EXPORT_JOINT or its like");
}

}  // namespace

PluginLibrary::PluginLibrary(const std::filesystem::path& path) : path_(path) {
  if (!std::filesystem::is_regular_file(path))
    refuse(path, std::filesystem::exists(path) ? "the plug-in is not a file" : "there is no such plug-in",
           "give the path of the library that lithe_add_plugin() built, with its .so");
  // An absolute path: a bare name would be looked for elsewhere. All its symbols now: better here than within a step.
  library_ = dlopen(std::filesystem::absolute(path).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library_) {
    const char* why = dlerror();
    refuse(path, std::string("the plug-in cannot be loaded: ") + (why ? why : "unknown reason"),
           "build it for this machine with lithe_add_plugin(); it must find the libraries that it needs");
  }
  void* entry = dlsym(library_, entry_name(LITHE_PLUGIN_VERSION).c_str());
  if (!entry) {
    try {
      refuse_entry(path, library_);
    } catch (...) {
      dlclose(library_);
      throw;
    }
  }
  entry_ = reinterpret_cast<int32_t (*)(const lithe_host*)>(entry);
}

PluginLibrary::~PluginLibrary() { dlclose(library_); }

void PluginLibrary::hand_over_types(const lithe_host& host) const {
  if (const int32_t code = entry_(&host); code != 0)
    refuse(path_, "the plug-in will not serve this Lithe: its entry returned " + std::to_string(code),
           "build the plug-in anew against this Lithe");
}

}  // namespace lithe
