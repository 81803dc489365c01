#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lithe::command {

/// Where this `lithe` lies, in a build folder or installed, and how its libraries were compiled: scenes must be
/// compiled alike (Eigen's alignment follows the instruction set). Read from share/lithe/scene_build.json beside the
/// command.
struct Installation {
  std::filesystem::path command;  // this executable
  std::filesystem::path share;    // share/lithe
  std::filesystem::path package;  // of find_package; empty in a build folder
  std::filesystem::path library;  // of all of Lithe
  std::string compiler;           // as configured, else by CXX, else one that is found
  std::vector<std::string> flags, link_flags;
  std::vector<std::filesystem::path> includes, system_includes;

  /// Throws FileError if the file is missing or damaged, or if there is no compiler.
  static Installation find();
};

}  // namespace lithe::command
