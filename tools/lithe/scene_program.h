#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/lithe/installation.h"

namespace lithe::command {

/// A scene file as the user named it.
struct SceneFile {
  std::string shown;           // as written, for messages
  std::filesystem::path path;  // absolute

  /// Throws FileError if there is no such file.
  static SceneFile find(const std::string& name);
};

/// The program made of a scene, compiled unless that was done before (scene_cache.h). `main_text`: C++ that includes
/// the scene and is compiled in its place; empty: the scene has its own main(). Afterwards the precompiled header is
/// made in the background. Throws CompileFailure, FileError.
std::filesystem::path compiled_scene(const Installation& installation, const SceneFile& scene, bool verbose,
                                     const std::string& main_text = "");

/// A main_text of a file that has `StudyScene scene()`: the file, whose own main() is left aside, then `rest`.
std::string text_around(const std::filesystem::path& scene, const std::string& rest);

/// Becomes the program. Throws FileError if it cannot be started.
[[noreturn]] void become_scene(const std::filesystem::path& program, const std::vector<std::string>& arguments);

}  // namespace lithe::command
