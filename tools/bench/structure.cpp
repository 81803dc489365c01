// structure: what a step of closed ladders and nets of rods costs; generalized-alpha at a fixed step.
//
//   --shape ladder|hinged_ladder|grid   --n 1000  cells along   --m 4  cells across, of a grid
//   (hinged_ladder: with redundant rows, lattice.h)
//   --dt 1e-3  step, s   --T 0.1  time, s   --rho 0.9  at infinity   --newton 1e-9  largest last correction   --repeat
//   5
#include "tools/bench/lattice.h"
#include "tools/bench/scenes.h"

int main(int argument_count, char** words) {
  using namespace lithe::bench;
  return run_program(argument_count, words, [](Arguments& arguments) {
    const std::string shape = arguments.text("shape", "ladder");
    if (shape != "ladder" && shape != "hinged_ladder" && shape != "grid")
      throw std::invalid_argument("no shape '" + shape + "'; known are grid, hinged_ladder, ladder");
    const int cells = arguments.integer("n", 1000), width = arguments.integer("m", 4);
    const int repeats = arguments.integer("repeat", 5);
    const double end = arguments.number("T", 0.1);
    const long steps = std::max(1L, std::lround(end / arguments.number("dt", 1e-3)));
    const Stepping stepping{.step = end / static_cast<double>(steps),
                            .steps = steps,
                            .spectral_radius = arguments.number("rho", 0.9),
                            .newton_tolerance = arguments.number("newton", 1e-9)};
    arguments.finish();

    const Scene scene([&](lithe::SystemGraph& graph) {
      if (shape == "grid")
        draw_grid(graph, cells, width);
      else
        draw_ladder(graph, cells, shape == "ladder" ? RungFoot::slot : RungFoot::hinge);
      return graph.ground().marker();
    });
    const int rods = static_cast<int>(scene.system.layout().bodies().size());
    const Cost cost = least_of(repeats, [&] { return measure(scene, stepping); });
    JsonLine line;
    line.add("program", "structure").add("shape", shape).add("n", cells).add("rods", rods);
    line.add("redundant_rows", scene.system.redundant_rows().size());
    line.add("us_per_rod_step", cost.microseconds_per_step() / rods, 5);
    cost.add_to(line).print();
  });
}
