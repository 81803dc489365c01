#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/fnv1a.h"
#include "tools/lithe/installation.h"

/// What `lithe run` keeps between runs, in $XDG_CACHE_HOME/lithe (else ~/.cache/lithe):
///   headers/KEY/scene.h.gch         the precompiled header; KEY: compiler, flags, every header of Lithe
///   programs/KEY/depends            the files a scene was made of; KEY: its path and the above
///   programs/KEY/program-DIGEST     the program; DIGEST: what those files contain
/// Files appear by rename, so a reader never sees half of one; makers of the same thing wait for each other.
namespace lithe::command {

/// FNV-1a, 64 bits: tells texts apart, no more.
class Digest {
 public:
  void add(const std::string& text);
  /// The content of a file; a missing one counts as a content of its own.
  void add_file(const std::filesystem::path& file);
  std::string text() const;

 private:
  std::uint64_t value_ = kFnvStart;
};

/// Held as long as it lives; others who want the same folder wait. Throws FileError if the folder cannot be written.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_;
};

/// Throws FileError if there is neither XDG_CACHE_HOME nor HOME.
std::filesystem::path cache_folder();

/// Key of everything but the scene: compiler (path, size, time), flags, headers of Lithe by content.
std::string headers_key(const Installation& installation);

/// The header of this key that includes lithe/lithe.h and stands, once precompiled, for it.
std::filesystem::path precompiled_header(const std::string& key);
bool is_precompiled(const std::string& key);
/// Lets a compiler read it, if there is one. It must come before all else that the source includes.
void append_precompiled(std::vector<std::string>& command, const std::string& key);
/// Compiles lithe/lithe.h unless that was done, or is being done: then waits. Throws FileError.
void precompile(const Installation& installation, const std::string& key);

/// The compiler and the flags that scenes and the precompiled header share.
std::vector<std::string> compile_command(const Installation& installation);
void append_include_folders(std::vector<std::string>& command, const Installation& installation);

}  // namespace lithe::command
