#include <CLI/CLI.hpp>
#include <cstdio>
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

}  // namespace

void add_view(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("view", "Make one page of recorded runs, to be opened in any browser.");
  auto options = std::make_shared<ViewOptions>();
  command->add_option("runs", options->paths, "files that Run::stream() wrote; several: laid over each other")
      ->required();
  command->add_option("-o,--out", options->page, "the page; default: beside the first run, .html");
  command->add_option("--title", options->title, "default: the names of the runs");
  command->callback([options, &exit_code] { exit_code = view(*options); });
}

}  // namespace lithe::command
