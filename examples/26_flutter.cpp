// 26_flutter: a column under a thrust that follows it, spread along its length: it does not buckle, it flutters.
//
// Shows: a load along a beam that turns with its sections; small motions under it, whose frequencies meet; what becomes
// of
//        a disturbance below the critical thrust and above it.
// Expect: frequencies meet at 40.05 EI/L³ (Leipholz 1962), found within 0.1 % by two meshes; above it a motion grows,
//         below it none does.
#include <algorithm>
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. A strip of spring steel, clamped upright, without weight; a thrust along it that follows it down.
  const double length = 1;
  const BeamSection strip = BeamSection::rectangle(0.02, 0.001, {2.1e11, 0.3, 7850});
  const double unit = strip.stiffness(4, 4) / (length * length * length);  // EI/L³, N/m
  const auto draw = [&](SystemGraph& graph, int elements, double thrust) -> Beam& {
    auto& beam = graph.add<Beam>("column", {.axis = BeamAxis::straight({0, 0, 0}, {0, 0, length}, {0, 1, 0}),
                                            .sections = {{0, strip}},
                                            .elements = elements});
    graph.add<FixedJoint>("clamp", {graph.ground().marker({}, beam.axes(0)), beam.marker(0)});
    add_line_load(graph, "thrust", beam,
                  {.density = {{0, force({-thrust * unit, 0, 0})}}, .axes = LineLoad::Axes::section});
    return beam;
  };

  // 2. Its two slowest motions: frequencies come together, then one grows.
  const auto slowest = [&](int elements, double thrust) {
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    draw(graph, elements, thrust);
    const System system = assemble(graph);
    std::vector<Mode> modes = linearize(system, find_equilibrium(system, system.initial_state()).state).modes;
    std::partial_sort(modes.begin(), modes.begin() + 2, modes.end(),
                      [](const Mode& a, const Mode& b) { return std::abs(a.eigenvalue) < std::abs(b.eigenvalue); });
    modes.resize(2);
    return modes;
  };
  for (const double thrust : {0.0, 20.0, 38.0, 40.0, 42.0}) {
    const auto modes = slowest(10, thrust);
    std::printf("thrust %4.1f EI/L³: %.4f and %.4f Hz, growth %7.4f 1/s\n", thrust, modes[0].frequency(),
                modes[1].frequency(), std::max(modes[0].growth(), modes[1].growth()));
  }

  // 3. Where they meet: (s₁² - s₂²)² passes zero.
  const auto critical = [&](int elements) {
    const auto apart = [&](double thrust) {
      const auto modes = slowest(elements, thrust);
      const auto difference = modes[0].eigenvalue * modes[0].eigenvalue - modes[1].eigenvalue * modes[1].eigenvalue;
      return (difference * difference).real();
    };
    double low = 39, high = 42;
    for (int i = 0; i < 10; ++i) (apart(0.5 * (low + high)) > 0 ? low : high) = 0.5 * (low + high);
    return low;
  };
  const double coarse = critical(10), fine = critical(20), found = (4 * fine - coarse) / 3;
  std::printf("they meet at %.3f, with 10 elements, %.3f with 20; extrapolated %.3f EI/L³\n", coarse, fine, found);

  // 4. Pressed and at rest, then knocked from the side for a tenth of a second and left alone.
  const auto farthest = [&](double thrust) {
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    Beam& beam = draw(graph, 10, thrust);
    graph.add<UserForce>("knock", {beam.marker(length)}, {[](double t, const MarkerView&) {
                           return force({t < 0.1 ? 0.02 * std::sin(M_PI * t / 0.1) : 0, 0, 0});
                         }});
    const System system = assemble(graph);
    State state = find_equilibrium(system, system.initial_state()).state;
    Recorder recorder{{position(beam.marker(length), "tip")}};
    Radau radau{{.tolerance = {.relative = 1e-5, .absolute = 1e-6}}};
    Simulation simulation{system, radau};
    simulation.observe(recorder, every(1e-2));
    simulation.run(state, 2.0);
    double most = 0;
    for (const double x : recorder.table().column("tip_x")) most = std::max(most, std::abs(x));
    return most;
  };
  const double below = farthest(0.97 * coarse), above = farthest(1.03 * coarse);
  std::printf("knocked: up to %.4f m at 0.97 of the first, %.4f m at 1.03 of it\n", below, above);

  // 5. Check the answer.
  return std::abs(found / 40.0537 - 1) < 1e-3 && above > 3 * below ? 0 : 1;
}
