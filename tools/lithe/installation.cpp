#include "tools/lithe/installation.h"

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/base/error.h"
#include "tools/lithe/process.h"

namespace lithe::command {
namespace fs = std::filesystem;
namespace {

std::string find_compiler(const std::string& configured) {
  if (const char* chosen = std::getenv("CXX"); chosen && *chosen) {
    if (!find_program(chosen).empty()) return find_program(chosen);
    throw FileError("there is no compiler '" + std::string(chosen) + "'", "environment variable CXX",
                    "unset CXX, or let it name a GCC of version 12 or later");
  }
  for (const std::string& name : {configured, std::string("g++"), std::string("c++")})
    if (const std::string found = find_program(name); !found.empty()) return found;
  throw FileError("no C++ compiler was found: neither '" + configured + "' nor g++", "PATH",
                  "install one (Debian: apt-get install g++), or name one by the environment variable CXX");
}

}  // namespace

Installation Installation::find() {
  Installation made;
  made.command = fs::read_symlink("/proc/self/exe");
  made.share = (made.command.parent_path() / LITHE_SHARE_FROM_BIN).lexically_normal();
  const fs::path file = made.share / "scene_build.json";
  std::ifstream stream(file);
  if (!stream)
    throw FileError("cannot read how Lithe was compiled", file.string(),
                    "keep bin/ and share/ of the installation together, or install Lithe again");

  // Relative paths count from the file.
  const auto located = [&](const std::string& path) { return (made.share / path).lexically_normal(); };
  try {
    const auto json = nlohmann::json::parse(stream);
    made.flags = json.at("flags");
    made.link_flags = json.at("link_flags");
    for (const std::string path : json.at("includes")) made.includes.push_back(located(path));
    for (const std::string path : json.at("system_includes")) made.system_includes.push_back(located(path));
    made.library = located(json.at("library_folder").get<std::string>()) / "liblithe_scene.so";
    if (const std::string package = json.at("package"); !package.empty()) made.package = located(package);
    made.compiler = find_compiler(json.at("compiler"));
  } catch (const nlohmann::json::exception& error) {
    throw FileError(std::string("damaged: ") + error.what(), file.string(), "install Lithe again");
  }
  if (!fs::exists(made.library))
    throw FileError("Lithe's library is missing", made.library.string(), "build Lithe, or install it again");
  return made;
}

}  // namespace lithe::command
