// pendulum: what a step of the flexible pendulum costs in Lithe; limit_flexible.cpp is the same without an engine.
//
//   --mesh coarse|fine  16 or 4,320 bricks, reduced to as many modes: the same cost   --modes 9
//   --dt 1e-3  step, s   --T 20  time, s   --rho 0.9  at infinity   --newton 1e-10  largest last correction   --repeat
//   5
#include "tools/bench/scenes.h"

int main(int argument_count, char** words) {
  using namespace lithe::bench;
  return run_program(argument_count, words, [](Arguments& arguments) {
    const int modes = arguments.integer("modes", 9), repeats = arguments.integer("repeat", 5);
    const std::string mesh = arguments.text("mesh", "coarse");
    if (mesh != "coarse" && mesh != "fine")
      throw std::invalid_argument("no mesh '" + mesh + "'; known are coarse, fine");
    const double end = arguments.number("T", 20);
    const long steps = std::max(1L, std::lround(end / arguments.number("dt", 1e-3)));
    const Stepping stepping{.step = end / static_cast<double>(steps),
                            .steps = steps,
                            .spectral_radius = arguments.number("rho", 0.9),
                            .newton_tolerance = arguments.number("newton", 1e-10)};
    arguments.finish();

    const Scene scene([&](lithe::SystemGraph& graph) {
      return draw_pendulum(graph, mesh == "coarse" ? rod_model() : fine_rod_model(), {.modes = modes});
    });
    const Cost cost = least_of(repeats, [&] { return measure(scene, stepping); });
    JsonLine line;
    line.add("program", "pendulum").add("mesh", mesh).add("modes", modes);
    cost.add_to(line).print();
  });
}
