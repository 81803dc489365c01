#include <CLI/CLI.hpp>

#include "tools/lithe/commands.h"
#include "tools/lithe/scene_cache.h"

namespace lithe::command {

void add_prepare(CLI::App& app, int& /*exit_code*/) {
  app.add_subcommand("prepare", "Make the precompiled header that lets scenes compile quickly (run does it by itself)")
      ->callback([] {
        const Installation installation = Installation::find();
        precompile(installation, headers_key(installation));
      });
}

}  // namespace lithe::command
