#pragma once

#include <filesystem>
#include <string>

#include "engine/plugin_abi.h"

namespace lithe {

/// A shared library with the entry lithe_plugin_v1. It stays loaded as long as this object.
class PluginLibrary {
 public:
  /// Throws FileError: no such file, no library, no entry, an entry of another version of the interface.
  explicit PluginLibrary(const std::filesystem::path& path);
  PluginLibrary(const PluginLibrary&) = delete;
  PluginLibrary& operator=(const PluginLibrary&) = delete;
  ~PluginLibrary();

  const std::filesystem::path& path() const { return path_; }
  /// Calls the entry. Throws FileError if the library refuses this host.
  void hand_over_types(const lithe_host& host) const;

 private:
  std::filesystem::path path_;
  void* library_;
  int32_t (*entry_)(const lithe_host*);
};

}  // namespace lithe
