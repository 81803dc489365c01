#include <CLI/CLI.hpp>
#include <cstdio>

#include "engine/base/error.h"
#include "tools/lithe/commands.h"
#include "tools/lithe/compiler_messages.h"
#include "tools/lithe/scene_program.h"

namespace lithe::command {
namespace fs = std::filesystem;
namespace {

constexpr const char* kChartMain = R"(int main(int count, char** words) {
  lithe::chart_study(scene(), lithe::standard_methods(), lithe::reference_methods(), {words + 1, words + count});
}
)";

/// A path, or the name of one of the project's own studies.
SceneFile find_study(const std::string& name, const Installation& installation) {
  std::vector<fs::path> folders = {fs::current_path()};
  folders.insert(folders.end(), installation.includes.begin(), installation.includes.end());
  for (const fs::path& folder : folders)
    if (const fs::path file = folder / "examples/studies" / (name + ".cpp"); fs::is_regular_file(file))
      return {name, file.lexically_normal()};
  return SceneFile::find(name);
}

struct ChartOptions {
  std::string scene, out = "results/charts";
  std::vector<std::string> words;  // for the program, see engine/study/chart_study.h
  bool verbose = false;
};

int chart(const ChartOptions& options) {
  const Installation installation = Installation::find();
  const SceneFile scene = find_study(options.scene, installation);
  fs::path program;
  try {
    program = compiled_scene(installation, scene, options.verbose, text_around(scene.path, kChartMain));
  } catch (const CompileFailure& failure) {
    std::fprintf(stderr, "%s", failure.what());
    return 2;
  }
  std::vector<std::string> words = {"out=" + (fs::path(options.out) / scene.path.stem()).string()};
  words.insert(words.end(), options.words.begin(), options.words.end());
  become_scene(program, words);
}

}  // namespace

void add_chart(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("chart", "Chart speed against accuracy of all methods on one scene");
  const auto options = std::make_shared<ChartOptions>();
  command
      ->add_option("scene", options->scene,
                   "A .cpp file with  lithe::StudyScene scene()  in it, or the name of one in examples/studies/")
      ->required();
  command->add_option("--out", options->out, "Folder for SCENE.svg, .png, .csv and .txt")->capture_default_str();
  const auto add_word = [&](const std::string& word, const std::string& meaning) {
    command->add_option_function<std::string>(
        "--" + word, [options, word](const std::string& text) { options->words.push_back(word + "=" + text); },
        meaning);
  };
  add_word("tolerances", "1e-2,1e-4,... of methods that control their error");
  add_word("steps", "1e-2,1e-3,... s, of methods with a fixed step");
  add_word("methods", "runge,alpha,...: parts of the names of those that shall run; default: all");
  add_word("samples", "Number of instants compared, evenly spaced; 1: the end alone; default: 20");
  add_word("repeats", "CPU time is the least of so many runs; default: 3");
  add_word("limit", "s of CPU a run; longer ones are stopped; default: 60");
  add_word("reference", "Tolerance of the two reference runs; default: 1e-11");
  add_word("peers", "CSV of others' points: error, and a column of CPU s a simulated second each");
  command->add_flag_callback(
      "--progress", [options] { options->words.push_back("progress=always"); },
      "Show the progress bar even where stderr is no terminal");
  command->add_flag("--verbose", options->verbose, "Show the compiler's command and all of its messages");
  command->callback([options, &exit_code] { exit_code = chart(*options); });
}

}  // namespace lithe::command
