#include "examples/support/pendulum_study.h"

#include <ctime>

namespace pendulum {

using namespace lithe;

namespace {

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// The pendulum as a graph: the body, its hinge, and the sensors of its tip.
struct Scene {
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  FlexibleBody* rod;
  Marker tip;

  Scene(const Variant& variant, const FiniteElementModel& model) {
    rod = &graph.add<FlexibleBody>(
        "rod", {.basis = make_basis(model, variant.frame, variant.modes, {.deflection = variant.deflection})});
    // A hinge turns about the z axes of its markers: here the edge along world y.
    const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
    const std::vector<int>& edge = model.node_set("hinge");
    if (variant.hinge == Hinge::revolute) {
      Vector3 middle = Vector3::Zero();
      for (int id : edge) middle += model.nodes.col(model.node_index(id)) / static_cast<double>(edge.size());
      graph.add<RevoluteJoint>("hinge", {graph.ground().marker(middle, along_y), rod->average(edge, along_y)});
    } else if (edge.size() == 3) {
      graph.add<ThreeNodeFixation>(
          "hinge", {graph.ground().marker(), rod->node(edge[0]), rod->node(edge[1]), rod->node(edge[2])});
    } else {
      for (int id : edge)
        graph.add<SphericalJoint>("hinge node " + std::to_string(id),
                                  {graph.ground().marker(model.nodes.col(model.node_index(id))), rod->node(id)});
    }
    tip = rod->node(model.node_set("tip").front());
  }
};

Trajectory trajectory_of(const Table& table) {
  Trajectory out;
  for (int i = 0; i < table.row_count(); ++i)
    out.push_back({table.at(i, 0),
                   {table.at(i, 1), table.at(i, 2), table.at(i, 3)},
                   {table.at(i, 4), table.at(i, 5), table.at(i, 6)}});
  return out;
}

}  // namespace

FiniteElementModel read_rod(const std::string& body) {
  return read_calculix(std::string(LITHE_EXAMPLE_DATA) + "/pendulum/" + body + "/calculix/matrices");
}

Trajectory read_reference(const std::string& body) {
  return trajectory_of(read_csv(std::string(LITHE_EXAMPLE_DATA) + "/pendulum/" + body + "/trajectory.csv"));
}

Outcome run(const Variant& variant, const FiniteElementModel& model, const Trajectory& reference) {
  Scene scene(variant, model);
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  GeneralizedAlpha integrator({.step = variant.step, .spectral_radius = 0.9});
  Recorder recorder({position(scene.tip, "tip"), velocity(scene.tip, "tip_v"), kinetic_energy("kinetic"),
                     total_energy("energy"), constraint_residual("residual")});
  Simulation simulation(system, integrator);
  simulation.observe(recorder, every(1e-3));
  const double start = cpu_seconds();
  simulation.run(state, 1.0);

  Outcome out{.variant = variant, .trajectory = {}, .frequencies = scene.rod->basis().frequencies};
  out.cpu = cpu_seconds() - start;
  out.trajectory = trajectory_of(recorder.table());
  out.coordinates = scene.rod->mode_count();
  out.statistics = integrator.statistics();
  const auto [dz, dv] = deviation(out.trajectory, reference);
  out.max_dev_z = dz;
  out.max_dev_vz = dv;
  for (std::size_t i = 0; i < out.trajectory.size(); ++i)
    if (std::abs(out.trajectory[i].position.z() - reference[i].position.z()) > 4e-4 ||
        std::abs(out.trajectory[i].velocity.z() - reference[i].velocity.z()) > 4e-2) {
      out.within_bounds = out.trajectory[i].t;
      break;
    }
  double kinetic = 0, drift = 0;
  const std::vector<double> energy = recorder.table().column("energy"), motion = recorder.table().column("kinetic"),
                            residual = recorder.table().column("residual");
  for (std::size_t i = 0; i < energy.size(); ++i) {
    kinetic = std::max(kinetic, motion[i]);
    drift = std::max(drift, std::abs(energy[i] - energy[0]));
    out.residual = std::max(out.residual, residual[i]);
  }
  out.energy_drift = drift / kinetic;
  return out;
}

Trajectory run_exactly(const Variant& variant, const FiniteElementModel& model) {
  Scene scene(variant, model);
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  ExplicitRungeKutta integrator({.tolerance = {.relative = 1e-9, .absolute = 1e-11}});
  Recorder recorder({position(scene.tip, "tip"), velocity(scene.tip, "tip_v")});
  Simulation simulation(system, integrator);
  simulation.observe(recorder, every(1e-3));
  simulation.run(state, 1.0);
  return trajectory_of(recorder.table());
}

void write_deformed_body(const Variant& variant, const FiniteElementModel& model, const std::string& path) {
  Scene scene(variant, model);
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  GeneralizedAlpha integrator({.step = variant.step, .spectral_radius = 0.9});
  DeformationWriter writer(*scene.rod, path);
  Simulation simulation(system, integrator);
  simulation.observe(writer, every(0.02));
  simulation.run(state, 1.0);
}

std::array<double, 2> deviation(const Trajectory& a, const Trajectory& b) {
  std::array<double, 2> most{0, 0};
  for (std::size_t i = 0; i < a.size(); ++i) {
    most[0] = std::max(most[0], std::abs(a[i].position.z() - b.at(i).position.z()));
    most[1] = std::max(most[1], std::abs(a[i].velocity.z() - b.at(i).velocity.z()));
  }
  return most;
}

}  // namespace pendulum
