#include <CLI/CLI.hpp>
#include <cstdio>

#include "engine/assembly/system.h"
#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "models/compiled/compiled_scene.h"
#include "models/draw_model.h"
#include "models/read_model.h"
#include "tools/lithe/commands.h"
#include "tools/lithe/compiler_messages.h"
#include "tools/lithe/process.h"
#include "tools/lithe/scene_program.h"

namespace lithe::command {
namespace fs = std::filesystem;
namespace {

struct CompileOptions {
  std::string path, name, folder = ".";
  double right_angles_within = 0;
  bool free = false, undamped = false, verbose = false;
};

constexpr const char* kWriterMain = R"(int main(int, char** words) {
  const lithe::StudyScene drawn = scene();
  lithe::SystemGraph graph{{.gravity = drawn.gravity}};
  drawn.draw(graph);
  const lithe::System system = lithe::assemble(graph);
  lithe::CompiledScene::of(system, words[1], {.right_angles_within = std::stod(words[3])}).write(words[2]);
}
)";

/// A scene in C++ is drawn by its own program, a model file here.
int compile(const CompileOptions& options) {
  const fs::path path(options.path);
  std::string name = options.name.empty() ? path.stem().string() : options.name;
  if (options.name.empty())
    for (char& c : name)
      if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  if (path.extension() == ".cpp") {
    const SceneFile scene = SceneFile::find(options.path);
    try {
      const fs::path program =
          compiled_scene(Installation::find(), scene, options.verbose, text_around(scene.path, kWriterMain));
      const Finished drawn =
          run_captured({program.string(), name, options.folder, number_text(options.right_angles_within)});
      std::fprintf(stderr, "%s", drawn.output.c_str());
      if (drawn.exit_code != 0) return drawn.exit_code;
    } catch (const CompileFailure& failure) {
      std::fprintf(stderr, "%s", failure.what());
      return 2;
    }
  } else {
    const ModelDescription model = read_model(options.path);
    SystemGraph graph{{.gravity = model.gravity}};
    draw_model(graph, model, {.floating = options.free, .damping = !options.undamped});
    const System system = assemble(graph);
    CompiledScene::of(system, name, {.right_angles_within = options.right_angles_within}).write(options.folder);
  }
  const std::string files = (fs::path(options.folder) / name).string();
  std::printf(
      "compiled scene: %s.h, and a program that times its steps:\n"
      "  c++ -std=c++17 -O3 -march=native -ffp-contract=off %s.cpp -o %s\n",
      files.c_str(), files.c_str(), files.c_str());
  return 0;
}

}  // namespace

void add_compile(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand(
      "compile", "A scene of rigid bodies in trees as C++ of its own, for real time and for many at once");
  const auto options = std::make_shared<CompileOptions>();
  command
      ->add_option("scene", options->path,
                   "A .cpp file with  lithe::StudyScene scene()  in it, or a model file (URDF, SDF, MJCF)")
      ->required();
  command->add_option("-o,--out", options->folder, "Folder for NAME.h and NAME.cpp")->capture_default_str();
  command->add_option("--name", options->name, "Of the struct and its files; default: that of the scene's file");
  command->add_option("--right-angles-within", options->right_angles_within,
                      "rad: axes so near to parallel or a right angle are taken to be, as a file's 1.5708; default: 0");
  command->add_flag("--free", options->free, "The root link of a model file is free instead of fixed");
  command->add_flag("--undamped", options->undamped, "Leave out springs and damping of a model file's joints");
  command->add_flag("--verbose", options->verbose, "Show all messages of the compiler");
  command->callback([options, &exit_code] { exit_code = compile(*options); });
}

}  // namespace lithe::command
