#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "bodies/rigid_body.h"
#include "engine/assembly/system.h"
#include "engine/base/error.h"
#include "engine/page/page.h"
#include "engine/run/simulation.h"
#include "integrators/automatic.h"
#include "models/draw_model.h"
#include "models/read_model.h"
#include "tools/lithe/commands.h"

namespace lithe::command {
namespace fs = std::filesystem;
namespace {

struct ModelOptions {
  std::string path, page;
  double duration = 2, every = 0.02, tolerance = 1e-6;
  bool free = false, undamped = false;
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

int inspect(const ModelOptions& options) {
  std::printf("%s", read_model(options.path).sheet().c_str());
  return 0;
}

/// The model under gravity alone, from rest.
int run(const ModelOptions& options) {
  const ModelDescription model = read_model(options.path);
  SystemGraph graph;
  const DrawnModel drawn = draw_model(
      graph, model,
      {.floating = options.free, .positions = joint_values(options.positions), .damping = !options.undamped});
  const System system = assemble(graph);
  std::vector<Sensor> coordinates;
  for (const ModelJoint& joint : model.joints)
    if (joint.type == ModelJoint::Type::revolute || joint.type == ModelJoint::Type::prismatic)
      coordinates.push_back(coordinate(drawn.coordinate(joint.name), joint.name));
  Run record{system, coordinates, {.name = model.name}};
  for (const auto& [body, shape] : drawn.shapes()) record.draw(*body, shape);
  Automatic integrator{{.tolerance = {.relative = options.tolerance, .absolute = 0.01 * options.tolerance}}};
  Simulation simulation{system, integrator};
  simulation.observe(record, every(options.every));
  State state = system.initial_state();
  simulation.run(state, options.duration);
  const fs::path page = options.page.empty() ? fs::path("results") / (model.name + ".html") : fs::path(options.page);
  if (page.has_parent_path()) fs::create_directories(page.parent_path());
  write_page(record, page.string());
  const auto& steps = integrator.statistics();
  std::printf("%s: %d freedoms, %.6g s in %ld steps\n", model.name.c_str(), system.degrees_of_freedom(),
              options.duration, static_cast<long>(steps.steps));
  std::printf("page: %s\n", page.string().c_str());
  return 0;
}

}  // namespace

void add_model(CLI::App& app, int& exit_code) {
  CLI::App* model = app.add_subcommand("model", "Models of other programs: URDF.");
  model->require_subcommand(1);
  auto options = std::make_shared<ModelOptions>();
  CLI::App* look = model->add_subcommand("inspect", "Print what a model file holds, and what of it does not act.");
  look->add_option("path", options->path, "a model file")->required();
  look->callback([options, &exit_code] { exit_code = inspect(*options); });
  CLI::App* move = model->add_subcommand("run", "Let a model move under gravity from rest, and write a page.");
  move->add_option("path", options->path, "a model file")->required();
  move->add_option("--duration", options->duration, "s")->check(CLI::PositiveNumber)->capture_default_str();
  move->add_option("--every", options->every, "s between states of the page")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  move->add_option("--tolerance", options->tolerance, "of the integrator")->check(CLI::PositiveNumber);
  move->add_option("--set", options->positions, "joint=value at the start, rad or m; several times");
  move->add_flag("--free", options->free, "the root link is free instead of fixed");
  move->add_flag("--undamped", options->undamped, "leave out the damping of joints");
  move->add_option("-o,--out", options->page, "the page; default: results/NAME.html");
  move->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace lithe::command
