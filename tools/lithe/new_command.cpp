#include <CLI/CLI.hpp>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "engine/base/error.h"
#include "tools/lithe/commands.h"
#include "tools/lithe/installation.h"

namespace lithe::command {
namespace fs = std::filesystem;
namespace {

/// A CMake target's name from a folder's: "my scene" gives my_scene.
std::string project_name(const fs::path& folder) {
  std::string name = folder.filename().string();
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-') c = '_';
  return name.empty() || !std::isalpha(static_cast<unsigned char>(name[0])) ? "scene_" + name : name;
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
    text.replace(at, what.size(), by);
  return text;
}

void write_project(const std::string& given) {
  fs::path folder = fs::absolute(given).lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();
  if (fs::exists(folder) && (!fs::is_directory(folder) || !fs::is_empty(folder)))
    throw FileError("'" + given + "' is there already", folder.string(), "name a folder that is new or empty");

  const Installation installation = Installation::find();
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw FileError("the folder cannot be made: " + error.message(), folder.string(), "name a folder you may write to");
  for (const auto& entry : fs::directory_iterator(installation.share / "new_project")) {
    std::ifstream from(entry.path(), std::ios::binary);
    std::string text(std::istreambuf_iterator<char>(from), {});
    text = replaced(text, "@PROJECT@", project_name(folder));
    // The package that wrote the project is found without being told; others by CMAKE_PREFIX_PATH.
    const std::string package = installation.package.string();
    text = replaced(text, "@HINT@", package.empty() ? "" : " HINTS \"" + package + "\"");
    const std::string name = entry.path().stem().string();  // scene.cpp.in gives scene.cpp
    std::ofstream to(folder / name, std::ios::binary);
    to << text;
    if (!to.flush()) throw FileError("cannot be written", (folder / name).string(), "see that the disk is not full");
  }
  std::printf("%s: scene.cpp, CMakeLists.txt, README.md\nRun it:  lithe run %s\n", given.c_str(),
              (fs::path(given) / "scene.cpp").c_str());
}

}  // namespace

void add_new(CLI::App& app, int& /*exit_code*/) {
  auto* command = app.add_subcommand("new", "Write a scene project that is ready to run and to build");
  const auto folder = std::make_shared<std::string>();
  command->add_option("DIR", *folder, "Its folder, new or empty")->required();
  command->callback([folder] { write_project(*folder); });
}

}  // namespace lithe::command
