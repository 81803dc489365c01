#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

/// The sub-commands of `lithe`, one a file. Each adds itself to the command line; its callback sets the exit code and
/// throws lithe::Error. A new one is a new file, a line here and a line in main.cpp.
namespace lithe::command {

/// lithe new DIR: a scene project that is ready to build.
void add_new(CLI::App& app, int& exit_code);
/// lithe run FILE.cpp [arguments]: compiles one scene, runs it.
void add_run(CLI::App& app, int& exit_code);
/// That: `words` are the scene and its arguments; `before`: C++ in front of it. Returns the exit code where the scene
/// is not run.
int run_scene(const std::vector<std::string>& words, bool verbose, bool compile_only, const std::string& before = "");
/// Marks all that follows the scene as the scene's own: "run --verbose -- scene.cpp --verbose".
std::vector<std::string> with_scene_arguments_apart(std::vector<std::string> arguments);
/// lithe chart SCENE: work-precision of all methods on one scene (engine/study/).
void add_chart(CLI::App& app, int& exit_code);
/// lithe prepare: the precompiled header that makes `lithe run` quick; `run` starts it by itself.
void add_prepare(CLI::App& app, int& exit_code);
/// lithe body inspect PATH: a flexible body from a file, proved, with a sheet and pictures.
void add_body(CLI::App& app, int& exit_code);

/// lithe model inspect PATH, lithe model run PATH: a model of another program (models/).
void add_model(CLI::App& app, int& exit_code);
/// lithe fmu SCENE: a scene as a functional mock-up unit (engine/fmu/).
void add_fmu(CLI::App& app, int& exit_code);
/// lithe compile SCENE: a scene as C++ without the engine (models/compiled/).
void add_compile(CLI::App& app, int& exit_code);
/// lithe view RUN...: one page of recorded runs (engine/page/); lithe view --follow FILE.cpp: a run that goes on.
void add_view(CLI::App& app, int& exit_code);

}  // namespace lithe::command
