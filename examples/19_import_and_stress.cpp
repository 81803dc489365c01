// 19_import_and_stress: a wall bracket from a gmsh mesh carries an instrument; where and when is it stressed most?
//
// Shows: read_flexible_body() and its sheet, reduction to two rigid interfaces (Craig-Bampton), a reduced body saved
// and
//        loaded, stresses as an animation, extrema, HDF5 results, loads back for the finite-element code.
// Expect: a weight put on suddenly stresses the bracket twice as much as at rest, most at the rim of the nearer bolt
// hole.
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  const std::string mesh = LITHE_EXAMPLE_DATA "/bracket/bracket.msh", folder = "results/import_and_stress/";

  // 1. Read the body; the sheet proves that it was understood: mass, rigid motions, frequencies. A mesh knows no
  // material.
  const FlexibleBodyFile file = read_flexible_body(mesh, {.materials = {{"bracket", {7e10, 0.33, 2700}}}});
  std::printf("%s\n", file.sheet().c_str());
  const FiniteElementModel& model = *file.model;

  // 2. Reduce it to what moves its two interfaces, each rigid: the bolt holes of the base, and the eye.
  std::vector<int> bolts = model.node_set("bolt_1");
  bolts.insert(bolts.end(), model.node_set("bolt_2").begin(), model.node_set("bolt_2").end());
  const std::vector<int>& eye = model.node_set("eye");
  write_modal_basis(
      *make_basis(model, MeanAxisFrame{}, 4, {.rigid = {bolts, eye}, .interface_modes = InterfaceModes::craig_bampton}),
      folder + "bracket.h5");
  const auto basis = read_modal_basis(folder + "bracket.h5");
  std::printf("%d degrees of freedom became %d modes, up to %.0f Hz\n", model.dof_count(), basis->mode_count(),
              basis->frequencies.maxCoeff());

  // 3. Bolt it to a wall (x is up), and weld an instrument of 2 kg to the eye, its centre 20 mm off.
  SystemGraph graph{{.gravity = {-9.81, 0, 0}}};
  auto& bracket = graph.add<FlexibleBody>("bracket", {.basis = basis, .damping = {.modal_ratios = {1e-4}}});
  auto& instrument =
      graph.add<RigidBody>("instrument", {.mass = 2, .inertia = {1e-3, 1e-3, 1e-3}, .position = {0.024, 0.02, 0.05}});
  const auto middle = [&](const std::vector<int>& ids) {
    Vector3 sum = Vector3::Zero();
    for (int id : ids) sum += model.nodes.col(model.node_index(id));
    return Vector3(sum / static_cast<double>(ids.size()));
  };
  const auto& clamp = graph.add<FixedJoint>("bolts", {graph.ground().marker(middle(bolts)), bracket.rigid(bolts)});
  graph.add<FixedJoint>("weld", {bracket.rigid(eye), instrument.marker(middle(eye) - Vector3(0.024, 0.02, 0.05))});
  const System system = assemble(graph);

  // 4. The stress at rest under the weight, and the loads that make it, for the finite-element code.
  Snapshot at_rest(system, find_equilibrium(system, system.initial_state()).state);
  const double still = von_mises(BodyStress(bracket).stress(at_rest)).maxCoeff();
  write_calculix_loads(folder + "loads_at_rest.inp", model, nodal_loads(bracket, at_rest));

  // 5. Let the weight go from the undeformed state, and watch.
  State state = system.initial_state();
  GeneralizedAlpha integrator{{.step = 5e-5, .spectral_radius = 0.8}};
  Simulation simulation{system, integrator};
  StressObserver stress(bracket);
  DeformationWriter animation(bracket, folder + "bracket", {.stress = true});
  ResultWriter results(bracket, folder + "results.h5", {.stress = true, .stress_nodes = model.node_set("back")});
  simulation.observe(stress, every_step());
  simulation.observe(animation, every(1e-3));
  simulation.observe(results, every(2e-4));
  simulation.run(state, 0.02);
  stress.write_vtu(folder + "largest.vtu");
  std::printf("%s", stress.report().c_str());

  // 6. Check the answer: the load factor of an undamped oscillator; the place; the weight in the bolts at rest.
  const double factor = stress.extrema().value / still, weight = 9.81 * (2 + file.check.mass);
  const double borne = reaction(clamp, 1).value(at_rest);
  const Vector3 place = model.nodes.col(stress.extrema().node);
  std::printf("at rest %.4e Pa; let go %.3f times as much; the bolts bear %.6f N of %.6f N\n", still, factor, borne,
              weight);
  const bool at_rim = std::abs(std::hypot(place.x() - 0.04, place.y() - 0.02) - 0.0045) < 1e-4;
  return std::abs(factor - 2) < 0.1 && at_rim && std::abs(borne / weight - 1) < 1e-8 ? 0 : 1;
}
