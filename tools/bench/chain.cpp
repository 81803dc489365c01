// chain: what a step of the falling chain costs in Lithe; limit_chain.cpp is the same without an engine.
//
//   --n 1000  rods   --joint spherical|revolute   --dt 1e-3  step, s   --T 1  time, s
//   --rho 0.9  at infinity   --newton 1e-9  largest last correction   --repeat 5  runs, the cheapest counts
#include "tools/bench/scenes.h"

int main(int argument_count, char** words) {
  using namespace lithe::bench;
  return run_program(argument_count, words, [](Arguments& arguments) {
    const int count = arguments.integer("n", 1000), repeats = arguments.integer("repeat", 5);
    const std::string joint = arguments.text("joint", "spherical");
    const ChainJoint kind = chain_joint(joint);
    const double end = arguments.number("T", 1);
    const long steps = std::max(1L, std::lround(end / arguments.number("dt", 1e-3)));
    const Stepping stepping{.step = end / static_cast<double>(steps),
                            .steps = steps,
                            .spectral_radius = arguments.number("rho", 0.9),
                            .newton_tolerance = arguments.number("newton", 1e-9)};
    arguments.finish();

    const Scene scene([&](lithe::SystemGraph& graph) { return draw_chain(graph, count, kind); });
    const Cost cost = least_of(repeats, [&] { return measure(scene, stepping); });
    JsonLine line;
    line.add("program", "chain").add("joint", joint).add("n", count);
    line.add("us_per_link_step", cost.microseconds_per_step() / count, 5);
    line.add("peak_bytes", peak_memory());
    cost.add_to(line).print();
  });
}
