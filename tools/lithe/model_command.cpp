#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "bodies/rigid_body.h"
#include "engine/assembly/system.h"
#include "engine/base/error.h"
#include "engine/page/page.h"
#include "engine/run/simulation.h"
#include "integrators/automatic.h"
#include "models/draw_model.h"
#include "models/read_model.h"
#include "models/write_scene.h"
#include "tools/lithe/commands.h"

namespace lithe::command {
namespace fs = std::filesystem;
namespace {

struct ModelOptions {
  std::string path, page, scene;
  std::optional<double> duration, every, tolerance;  // else those of the file, or 2 s, a hundredth of it, 1e-6
  bool free = false, undamped = false, table = false;
  std::vector<std::string> positions;  // joint=value
};

std::map<std::string, double> joint_values(const std::vector<std::string>& words) {
  std::map<std::string, double> values;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    double value = NAN;
    if (equals != std::string::npos) std::from_chars(word.data() + equals + 1, word.data() + word.size(), value);
    if (!std::isfinite(value))
      throw SceneError("'" + word + "' is not joint=value.", "--set", "give --set elbow=0.5, rad or m.");
    values[word.substr(0, equals)] = value;
  }
  return values;
}

/// The model's name as that of a file: what a path could be made of is left out.
std::string file_name(const std::string& name) {
  std::string safe;
  for (const char c : name.substr(0, 100)) {
    const bool plain =
        std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || (c == '.' && !safe.empty());
    safe += plain ? c : '_';
  }
  return safe.empty() ? "model" : safe;
}

void print(const ModelDescription& model, bool table) {
  std::printf("%s", model.sheet().c_str());
  if (table) std::printf("%s", model.table().c_str());
}

/// The model as a scene in C++, if that is asked for.
void write(const ModelOptions& options, const ModelDescription& model, const DrawnModel::Options& drawing) {
  if (options.scene.empty()) return;
  write_scene(model, options.scene, drawing);
  std::printf("scene: %s\n", options.scene.c_str());
}

DrawnModel::Options drawing(const ModelOptions& options) {
  return {.floating = options.free, .positions = joint_values(options.positions), .damping = !options.undamped};
}

/// What the file holds, and whether it can be drawn.
int inspect(const ModelOptions& options) {
  const ModelDescription model = read_model(options.path);
  print(model, options.table);
  SystemGraph graph{{.gravity = model.gravity}};
  draw_model(graph, model, drawing(options));
  if (graph.bodies().size() > 1) std::printf("  degrees of freedom: %d\n", assemble(graph).degrees_of_freedom());
  write(options, model, drawing(options));
  return 0;
}

/// The model under its gravity and forces, from its start.
int run(const ModelOptions& options) {
  const ModelDescription model = read_model(options.path);
  if (options.table) print(model, true);
  write(options, model, drawing(options));
  SystemGraph graph{{.gravity = model.gravity}};
  const DrawnModel drawn = draw_model(graph, model, drawing(options));
  const System system = assemble(graph);
  std::vector<Sensor> sensors = drawn.outputs();
  if (!model.adams)
    for (const ModelJoint& joint : model.joints)
      if (joint.type == ModelJoint::Type::revolute || joint.type == ModelJoint::Type::prismatic)
        sensors.push_back(coordinate(drawn.coordinate(joint.name), joint.name));
  const double duration = options.duration.value_or(model.duration.value_or(2));
  const double step = options.every.value_or(model.every.value_or(0.01 * duration));
  const double tolerance = options.tolerance.value_or(model.tolerance.value_or(1e-6));
  Run record{system, sensors, {.name = model.name}};
  for (const auto& [body, shape] : drawn.shapes()) record.draw(*body, shape);
  Automatic integrator{{.tolerance = {.relative = tolerance, .absolute = 0.01 * tolerance}}};
  Simulation simulation{system, integrator};
  simulation.observe(record, every(step));
  State state = system.initial_state();
  simulation.run(state, duration);
  const fs::path page =
      options.page.empty() ? fs::path("results") / (file_name(model.name) + ".html") : fs::path(options.page);
  if (page.has_parent_path()) fs::create_directories(page.parent_path());
  write_page(record, page.string());
  const auto& steps = integrator.statistics();
  const Vector3& g = model.gravity;
  std::printf("%s: %d freedoms, %.6g s in %ld steps, gravity %g %g %g, tolerance %g\n", model.name.c_str(),
              system.degrees_of_freedom(), duration, static_cast<long>(steps.steps), g.x(), g.y(), g.z(), tolerance);
  if (!model.notes.empty()) std::printf("not all of the file acts: lithe model inspect %s\n", options.path.c_str());
  std::printf("page: %s\n", page.string().c_str());
  return 0;
}

}  // namespace

void add_model(CLI::App& app, int& exit_code) {
  CLI::App* model = app.add_subcommand("model", "Models of other programs: URDF, SDF, MJCF, Adams data sets (.adm).");
  model->require_subcommand(1);
  auto options = std::make_shared<ModelOptions>();
  CLI::App* look = model->add_subcommand("inspect", "Print what a model file holds, and what of it does not act.");
  CLI::App* move = model->add_subcommand("run", "Let a model move from its start, and write a page.");
  for (CLI::App* command : {look, move}) {
    command->add_option("path", options->path, "a model file")->required();
    command->add_flag("--table", options->table, "list every body and joint too");
    command->add_option("--write", options->scene, "write the model as a scene in C++ (lithe run FILE) too");
    command->add_option("--set", options->positions, "joint=value at the start, rad or m; several times");
    command->add_flag("--free", options->free, "the root link is free instead of fixed");
    command->add_flag("--undamped", options->undamped, "leave out springs and damping of joints");
  }
  look->callback([options, &exit_code] { exit_code = inspect(*options); });
  move->add_option("--duration", options->duration, "s; default: the file's, or 2")->check(CLI::PositiveNumber);
  move->add_option("--every", options->every, "s between states of the page; default: the file's, or a hundredth")
      ->check(CLI::PositiveNumber);
  move->add_option("--tolerance", options->tolerance, "of the integrator; default: the file's, or 1e-6")
      ->check(CLI::PositiveNumber);
  move->add_option("-o,--out", options->page, "the page; default: results/NAME.html");
  move->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace lithe::command
