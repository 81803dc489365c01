// 21_page: the pendulum, rigid and flexible, as one page that any browser opens.
//
// Shows: Run, the observer that keeps a simulation to be looked at; a run file that outlives a kill; variants laid over
//        each other by write_page().
// Expect: results/page/pendulum.html: both rods swing, the bent one coloured by its stress, with charts of their tips
//         and of the difference; results/page/flexible.h5, of which `lithe view` makes the same page.
#include <cstdio>
#include <filesystem>

#include "lithe/lithe.h"

using namespace lithe;

namespace {

const std::string kFolder = "results/page/";

/// Two seconds of a rod of so many modes.
Run swing(const FiniteElementModel& model, const std::string& name, int modes) {
  // 1. The pendulum of example 02: a hinge along world y at one end.
  SystemGraph graph;
  const std::vector<int> hinge = model.node_set("hinge");
  auto& rod = graph.add<FlexibleBody>(
      "rod", {.basis = make_basis(model, HingeFrame{hinge}, modes, {.deflection = Deflection::stiffened})});
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  auto& pin =
      graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0.005, 0}, along_y), rod.average(hinge, along_y)});
  const Marker tip = rod.node(model.node_set("tip").front());
  const System system = assemble(graph);
  State state = system.initial_state();
  Automatic integrator{{.tolerance = {1e-6, 1e-9}}};
  Simulation simulation{system, integrator};

  // 2. Keep the run to be looked at. Bodies, joints, energies and residuals are kept by themselves; sensors add what
  //    the charts begin with, positions among them leave traces. A stream survives whatever ends the program.
  Run run{system, {position(tip, "tip"), coordinate(pin.angle(), "angle")}, {.name = name}};
  run.stream(kFolder + name + ".h5");
  simulation.observe(run, every(0.01));
  simulation.run(state, 2);
  run.add(simulation.events());
  return run;
}

/// Largest distance of what two runs recorded under one name.
double largest_difference(const Run& a, const Run& b, const std::string& channel) {
  const std::vector<double> x = a.channel(channel), y = b.channel(channel);
  double most = 0;
  for (std::size_t i = 0; i < x.size(); ++i) most = std::max(most, std::abs(x[i] - y.at(i)));
  return most;
}

}  // namespace

int main() {
  const FiniteElementModel model = read_calculix(LITHE_EXAMPLE_DATA "/pendulum/hex8i/calculix/matrices");
  const Run rigid = swing(model, "rigid", 0), flexible = swing(model, "flexible", 9);

  // 3. One page of both. (Of one: write_page(flexible, "flexible.html").)
  const std::string page = kFolder + "pendulum.html";
  write_page({rigid, flexible}, page, {.title = "A pendulum, rigid and flexible"});

  // 4. Check the answer: nothing was lost on the way through the file, and the rod bends as far as it should.
  const Run again = Run::read(kFolder + "flexible.h5");
  const double bend = largest_difference(rigid, flexible, "tip_z"), size = 1e-6 * std::filesystem::file_size(page);
  std::printf("%d states; the tips are up to %.2f mm apart\npage: %s (%.2f MB)\n", again.frame_count(), 1e3 * bend,
              page.c_str(), size);
  return again.frame_count() == 201 && std::abs(bend / 7.8e-3 - 1) < 0.05 && size < 3 ? 0 : 1;
}
