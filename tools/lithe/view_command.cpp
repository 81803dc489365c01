#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <set>

#include "engine/base/error.h"
#include "engine/page/page.h"
#include "tools/lithe/commands.h"

namespace lithe::command {
namespace fs = std::filesystem;
namespace {

struct ViewOptions {
  std::vector<std::string> paths;
  std::string page, title;
  bool follow = false, verbose = false;
  int port = 0;
};

int view(const ViewOptions& options) {
  std::vector<Run> runs;
  std::set<std::string> names;
  for (const std::string& path : options.paths) {
    runs.push_back(Run::read(path));
    // Runs that were given no name, or the same, bear that of their file.
    if (!names.insert(runs.back().name()).second) {
      const std::string name = fs::path(path).stem().string();
      if (!names.insert(name).second)
        throw SceneError("two runs of the page are called '" + name + "'", path, "give their files different names");
      runs.back() = Run::read(path, name);
    }
  }
  std::string page = options.page;
  if (page.empty()) page = fs::path(options.paths.front()).replace_extension(".html").string();
  write_page({runs.begin(), runs.end()}, page, {.title = options.title});
  for (const Run& run : runs) std::printf("%s: %d states\n", run.name().c_str(), run.frame_count());
  std::printf("page: %s\n", page.c_str());
  return 0;
}

int follow(const ViewOptions& options) {
  ::setenv(Run::kFollowVariable, std::to_string(options.port).c_str(), 1);
  // Scenes that record no Run are followed all the same (engine/page/followed_simulation.h).
  return run_scene(options.paths, options.verbose, false,
                   "#include \"lithe/lithe.h\"\n#define Simulation FollowedSimulation\n");
}

}  // namespace

void add_view(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("view", "Make one page of recorded runs, to be opened in any browser; or follow one.");
  auto options = std::make_shared<ViewOptions>();
  command->add_option("runs", options->paths, "files that Run::stream() wrote; several: laid over each other")
      ->required();
  CLI::Option* follows = command->add_flag(
      "--follow", options->follow,
      "RUNS is a scene, a .cpp file with a main(), and its arguments (behind --): run it, and show it meanwhile");
  command->add_option("--port", options->port, "of 127.0.0.1, to follow at; default: any that is free")->needs(follows);
  command->add_flag("--verbose", options->verbose, "Show the compiler's command and all of its messages")
      ->needs(follows);
  command->add_option("-o,--out", options->page, "the page; default: beside the first run, .html")->excludes(follows);
  command->add_option("--title", options->title, "default: the names of the runs")->excludes(follows);
  command->callback([options, &exit_code] { exit_code = options->follow ? follow(*options) : view(*options); });
}

}  // namespace lithe::command
