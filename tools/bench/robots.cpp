// robots: cost of a robot's accelerations, as explicit integrators ask for them, from its URDF file.
//
//   --model FILE.urdf   --floating 0|1   --evaluations 100000   --repeat 5   --compile FOLDER
// All joints turned by 0.3 rad or moved by 0.01 m, at 0.5 rad/s or 0.05 m/s, under gravity; no torques, no damping.
// --compile writes the robot as a compiled scene (models/compiled/) of the name `robot` instead of timing it.
#include "engine/assembly/evaluator.h"
#include "models/compiled/compiled_scene.h"
#include "models/draw_model.h"
#include "models/read_model.h"
#include "tools/bench/measure.h"

namespace {

using namespace lithe;
using namespace lithe::bench;

DrawnModel::Options moving(const ModelDescription& model, bool floating) {
  DrawnModel::Options options{.floating = floating, .damping = false};
  for (const ModelJoint& joint : model.joints) {
    if (joint.mimic) continue;
    if (joint.type == ModelJoint::Type::revolute)
      options.positions[joint.name] = 0.3, options.velocities[joint.name] = 0.5;
    if (joint.type == ModelJoint::Type::prismatic)
      options.positions[joint.name] = 0.01, options.velocities[joint.name] = 0.05;
  }
  return options;
}

}  // namespace

int main(int argument_count, char** words) {
  return run_program(argument_count, words, [](Arguments& arguments) {
    const std::string file = arguments.text("model", "");
    const bool floating = arguments.integer("floating", 0) != 0;
    const int evaluations = arguments.integer("evaluations", 100000), repeats = arguments.integer("repeat", 5);
    const std::string folder = arguments.text("compile", "");
    arguments.finish();

    const ModelDescription model = read_model(file);
    SystemGraph graph;
    draw_model(graph, model, moving(model, floating));
    const System system = assemble(graph);
    if (!folder.empty()) {
      const CompiledScene compiled = CompiledScene::of(system, "robot");
      compiled.write(folder);
      JsonLine line;
      line.add("robot", model.name).add("products", compiled.products).add("sums", compiled.sums);
      return line.print();
    }
    Evaluator evaluator(system);
    ForwardDynamics* forward = evaluator.parts().forward_dynamics;
    if (!forward) throw std::runtime_error("this robot's accelerations have no fast path");
    State state = system.initial_state();
    forward->accelerations(0, state.q, state.v, state.v_dot);  // the first one analyses and allocates
    double least = 1e300;
    for (int r = 0; r < repeats; ++r) {
      const double started = cpu_seconds();
      for (int i = 0; i < evaluations; ++i) forward->accelerations(0, state.q, state.v, state.v_dot);
      least = std::min(least, cpu_seconds() - started);
    }
    const int freedoms = system.degrees_of_freedom();
    JsonLine line;
    line.add("engine", "Lithe").add("problem", "robot").add("robot", model.name).add("floating", floating ? 1 : 0);
    line.add("freedoms", freedoms).add("us_per_acceleration", 1e6 * least / evaluations, 5);
    line.add("us_per_freedom", 1e6 * least / evaluations / freedoms, 5);
    line.add("norm", state.v_dot.norm(), 16);
    line.print();
  });
}
