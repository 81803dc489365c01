// lithe: the command. `lithe --help` lists its sub-commands; each is a file here.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "engine/base/error.h"
#include "tools/lithe/commands.h"

int main(int argc, char** argv) {
  CLI::App app("Lithe: rigid and flexible multibody dynamics, scenes written in C++.", "lithe");
  app.require_subcommand(1);
  int exit_code = 0;
  lithe::command::add_new(app, exit_code);
  lithe::command::add_run(app, exit_code);
  lithe::command::add_chart(app, exit_code);
  lithe::command::add_prepare(app, exit_code);
  lithe::command::add_body(app, exit_code);
  lithe::command::add_model(app, exit_code);
  lithe::command::add_fmu(app, exit_code);
  lithe::command::add_compile(app, exit_code);
  lithe::command::add_view(app, exit_code);
  try {
    auto arguments = lithe::command::with_scene_arguments_apart({argv + 1, argv + argc});
    std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants a vector
    app.parse(std::move(arguments));
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const lithe::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return exit_code;
}
