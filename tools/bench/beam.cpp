// beam: what a step of the falling cantilever costs in Lithe; limit_beam.cpp is the same without an engine.
//
//   --n 100  elements   --as lumped|consistent|cable   beam with lumped or consistent mass, or a cable on a pin
//   --dt 1e-3  step, s  --T 1  time, s   --rho 0.9  at infinity   --newton 1e-9  largest last correction
//   --repeat 5  runs, the cheapest counts
#include "bodies/beam/beam.h"

#include "bodies/cable/cable.h"
#include "joints/fixed_joint.h"
#include "joints/spherical_joint.h"
#include "tools/bench/beam_scene.h"
#include "tools/bench/scenes.h"

namespace lithe::bench {
namespace {

Marker draw_beam(SystemGraph& graph, int elements, Beam::Mass mass) {
  const BeamSection section = BeamSection::diagonal(BeamScene::stiffness(), BeamScene::kMass, BeamScene::inertia());
  auto& beam = graph.add<Beam>("beam", {.axis = BeamAxis::straight({0, 0, 0}, {BeamScene::kLength, 0, 0}, {0, 1, 0}),
                                        .sections = {{0, section}},
                                        .elements = elements,
                                        .mass = mass});
  graph.add<FixedJoint>("clamp", {graph.ground().marker(), beam.marker(0)});
  return beam.marker(BeamScene::kLength);
}

Marker draw_cable(SystemGraph& graph, int elements) {
  auto& cable = graph.add<Cable>("cable", {.to = {BeamScene::kLength, 0, 0},
                                           .elements = elements,
                                           .mass_per_length = BeamScene::kMass,
                                           .axial_stiffness = BeamScene::stiffness()[0],
                                           .bending_stiffness = BeamScene::stiffness()[4]});
  graph.add<SphericalJoint>("pin", {graph.ground().marker(), cable.start()});
  return cable.end();
}

}  // namespace
}  // namespace lithe::bench

int main(int argument_count, char** words) {
  using namespace lithe::bench;
  using lithe::Beam;
  return run_program(argument_count, words, [](Arguments& arguments) {
    const int count = arguments.integer("n", 100), repeats = arguments.integer("repeat", 5);
    const std::string as = arguments.text("as", "lumped");
    const double end = arguments.number("T", 1);
    const long steps = std::max(1L, std::lround(end / arguments.number("dt", 1e-3)));
    const Stepping stepping{.step = end / static_cast<double>(steps),
                            .steps = steps,
                            .spectral_radius = arguments.number("rho", 0.9),
                            .newton_tolerance = arguments.number("newton", 1e-9)};
    arguments.finish();
    if (as != "lumped" && as != "consistent" && as != "cable")
      throw std::invalid_argument("--as " + as + " is unknown; lumped, consistent and cable are");

    const Scene scene([&](lithe::SystemGraph& graph) {
      if (as == "cable") return draw_cable(graph, count);
      return draw_beam(graph, count, as == "lumped" ? Beam::Mass::lumped : Beam::Mass::consistent);
    });
    const Cost cost = least_of(repeats, [&] { return measure(scene, stepping); });
    JsonLine line;
    line.add("program", "beam").add("as", as).add("n", count);
    line.add("us_per_element_step", cost.microseconds_per_step() / count, 5);
    cost.add_to(line).print();
  });
}
