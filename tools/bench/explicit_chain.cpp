// explicit_chain: the falling chain by an error-controlled method, and the cost of its accelerations.
//
//   --n 1000  rods   --joint spherical|revolute
//   --method rk5|rk8|adams|automatic  --tol 1e-6  --T 1  time, s   --reference FILE  joint points at T   --repeat 5
//   --evaluations K  accelerations of the chain as released, K times, instead of a run; limit_explicit.cpp is the same
//                    without an engine
#include "engine/assembly/evaluator.h"
#include "engine/simplify/simplification.h"
#include "tools/bench/runs.h"
#include "tools/bench/scenes.h"

namespace {

using namespace lithe;
using namespace lithe::bench;

/// CPU seconds of so many evaluations of v̇ at the start, as explicit integrators make them.
double accelerations(const System& system, int evaluations) {
  Evaluator evaluator(system);
  ForwardDynamics& forward = *evaluator.parts().forward_dynamics;
  State state = system.initial_state();
  forward.accelerations(0, state.q, state.v, state.v_dot);  // the first one analyses and allocates
  const double started = cpu_seconds();
  for (int i = 0; i < evaluations; ++i) forward.accelerations(0, state.q, state.v, state.v_dot);
  return cpu_seconds() - started;
}

}  // namespace

int main(int argument_count, char** words) {
  return run_program(argument_count, words, [](Arguments& arguments) {
    const int count = arguments.integer("n", 1000), evaluations = arguments.integer("evaluations", 0);
    const std::string joint = arguments.text("joint", "spherical"), reference = arguments.text("reference", "");
    const double end = arguments.number("T", 1);
    const Setting setting = read_setting(arguments);
    arguments.finish();

    std::vector<Marker> ends;
    Scene scene([&](SystemGraph& graph) { return draw_chain(graph, count, chain_joint(joint), &ends); });
    JsonLine line;
    line.add("engine", "Lithe").add("problem", "chain").add("joint", joint).add("n", count);
    if (evaluations > 0) {
      double seconds = accelerations(scene.system, evaluations);
      for (int i = 1; i < setting.repeats; ++i) seconds = std::min(seconds, accelerations(scene.system, evaluations));
      line.add("evaluations", evaluations).add("us_per_link_acceleration", 1e6 * seconds / evaluations / count, 5);
      line.print();
      return;
    }
    // Hinges hold the links in a plane: three coordinates each.
    Simplification simple{scene.graph};
    const Run run = simulate(assemble(simple.graph()), setting, simple.start(), end);
    run.add_to(line, setting);
    if (!reference.empty()) {
      State whole = simple.whole().initial_state();
      simple.expand(run.end, whole);
      const ChainError error = chain_error(simple.whole(), whole, ends, reference);
      line.add("tip_error", error.tip, 4).add("joint_error", error.joint, 4);
    }
    line.print();
  });
}
