// stiff_chain: rods tied by stiff bushings in place of joints (draw_chain), falling for a second: decay at 1e3 to 1e5
// 1/s beside a motion of seconds.
//
//   --n 16  rods   --method bdf|radau|alpha|automatic  --tol 1e-6   --T 1  time, s
//   --reference FILE  joint points at T   --repeat 5   --write FILE  the joint points, instead of a JSON line
#include <cstdio>

#include "engine/assembly/evaluated.h"
#include "engine/assembly/evaluator.h"
#include "tools/bench/runs.h"
#include "tools/bench/scenes.h"

namespace {

using namespace lithe;
using namespace lithe::bench;

void write_points(const System& system, const State& state, const std::vector<Marker>& ends, const std::string& path,
                  const std::string& heading) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (!file) throw std::runtime_error("cannot write " + path);
  std::fputs(heading.c_str(), file);
  Evaluator evaluator(system);
  evaluator.evaluate(state.time, state.q, state.v, Level::position);
  for (const Marker& end : ends) {
    const Vector3 p = marker_kinematics(evaluator, end, Level::position).p;
    std::fprintf(file, "%.17g %.17g\n", p.x(), p.z());
  }
  std::fclose(file);
}

}  // namespace

int main(int argument_count, char** words) {
  return run_program(argument_count, words, [](Arguments& arguments) {
    const int count = arguments.integer("n", 16);
    const std::string reference = arguments.text("reference", ""), path = arguments.text("write", "");
    const double time = arguments.number("T", 1);
    const Setting setting = read_setting(arguments);
    arguments.finish();

    std::vector<Marker> ends;
    const Scene scene([&](SystemGraph& graph) { return draw_chain(graph, count, ChainJoint::bushing, &ends); });
    const Run run = simulate(scene.system, setting, scene.system.initial_state(), time);
    if (!path.empty()) {
      char heading[300];
      std::snprintf(heading, sizeof heading,
                    "# joint points (x z, m) of the chain of %d rods on bushings at t = %g s: stiff_chain --n %d "
                    "--method %s --tol %g --write FILE\n",
                    count, time, count, setting.method.c_str(), setting.tolerance);
      write_points(scene.system, run.end, ends, path, heading);
      return;
    }
    JsonLine line;
    line.add("engine", "Lithe").add("problem", "stiff_chain").add("n", count);
    run.add_to(line, setting);
    if (!reference.empty()) {
      const ChainError error = chain_error(scene.system, run.end, ends, reference);
      line.add("tip_error", error.tip, 4).add("joint_error", error.joint, 4);
    }
    line.print();
  });
}
