#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "tools/lithe/commands.h"
#include "tools/lithe/compiler_messages.h"
#include "tools/lithe/scene_program.h"

namespace lithe::command {
namespace {

struct RunOptions {
  std::vector<std::string> words;  // the scene, its arguments
  bool verbose = false, compile_only = false;
};

}  // namespace

int run_scene(const std::vector<std::string>& words, bool verbose, bool compile_only, const std::string& before) {
  const SceneFile scene = SceneFile::find(words[0]);
  const std::string main_text = before.empty() ? "" : before + "#include \"" + scene.path.string() + "\"\n";
  std::filesystem::path program;
  try {
    program = compiled_scene(Installation::find(), scene, verbose, main_text);
  } catch (const CompileFailure& failure) {
    std::fprintf(stderr, "%s", failure.what());
    return 2;
  }
  if (compile_only) return 0;
  become_scene(program, {words.begin() + 1, words.end()});
}

void add_run(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("run", "Compile one scene and run it; again at once if nothing changed");
  const auto options = std::make_shared<RunOptions>();
  command->add_option("scene", options->words, "The scene, a .cpp file with a main(), then its own arguments")
      ->required();
  command->add_flag("--verbose", options->verbose, "Show the compiler's command and all of its messages");
  command->add_flag("--compile-only", options->compile_only, "Do not run it");
  command->callback(
      [options, &exit_code] { exit_code = run_scene(options->words, options->verbose, options->compile_only); });
}

std::vector<std::string> with_scene_arguments_apart(std::vector<std::string> arguments) {
  if (arguments.empty() || arguments[0] != "run") return arguments;
  const auto scene = std::find_if(arguments.begin() + 1, arguments.end(),
                                  [](const std::string& word) { return !word.starts_with('-'); });
  if (std::find(arguments.begin(), scene, "--") == scene && scene != arguments.end()) arguments.insert(scene, "--");
  return arguments;
}

}  // namespace lithe::command
