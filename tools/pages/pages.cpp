// The pages that the documentation shows: pages [FOLDER].
#include <cstdio>
#include <string>

#include "examples/studies/andrews_squeezer.cpp"
#include "integrators/moreau_jean.h"
#include "joints/contact/contact.h"
#include "lithe/lithe.h"

namespace {

/// Craig-Bampton bracket under a weight that is put on suddenly: example 19.
void write_bracket(const std::string& folder) {
  const FlexibleBodyFile file =
      read_flexible_body(LITHE_EXAMPLE_DATA "/bracket/bracket.msh", {.materials = {{"bracket", {7e10, 0.33, 2700}}}});
  const FiniteElementModel& model = *file.model;
  std::vector<int> bolts = model.node_set("bolt_1");
  bolts.insert(bolts.end(), model.node_set("bolt_2").begin(), model.node_set("bolt_2").end());
  const std::vector<int>& eye = model.node_set("eye");
  const auto basis =
      make_basis(model, MeanAxisFrame{}, 4, {.rigid = {bolts, eye}, .interface_modes = InterfaceModes::craig_bampton});
  SystemGraph graph{{.gravity = {-9.81, 0, 0}}};
  auto& bracket = graph.add<FlexibleBody>("bracket", {.basis = basis, .damping = {.modal_ratios = {0.01}}});
  const Vector3 at(0.024, 0.02, 0.05);
  auto& instrument = graph.add<RigidBody>("instrument", {.mass = 2, .inertia = {1e-3, 1e-3, 1e-3}, .position = at});
  const auto middle = [&](const std::vector<int>& ids) {
    Vector3 sum = Vector3::Zero();
    for (int id : ids) sum += model.nodes.col(model.node_index(id));
    return Vector3(sum / static_cast<double>(ids.size()));
  };
  graph.add<FixedJoint>("bolts", {graph.ground().marker(middle(bolts)), bracket.rigid(bolts)});
  const Marker held = instrument.marker(middle(eye) - at);
  graph.add<FixedJoint>("weld", {bracket.rigid(eye), held});
  const System system = assemble(graph);
  Run run{system, {position(held, "eye")}, {.name = "bracket"}};
  run.draw(instrument, visual::box({0.03, 0.03, 0.02}));
  State state = system.initial_state();
  GeneralizedAlpha integrator{{.step = 5e-5, .spectral_radius = 0.8}};
  Simulation simulation{system, integrator};
  simulation.observe(run, every(2e-4));
  simulation.run(state, 0.04);
  write_page(run, folder + "/bracket.html", {.title = "A wall bracket, 2 kg put on suddenly"});
}

void write_squeezer(const std::string& folder) {
  const StudyScene study = scene();
  SystemGraph graph{{.gravity = study.gravity}};
  std::vector<Sensor> sensors = study.draw(graph);
  const System system = assemble(graph);
  Run run{system, std::move(sensors), {.name = "squeezer"}};
  State state = system.initial_state();
  ExplicitRungeKutta integrator{{.tolerance = {.relative = 1e-8, .absolute = 1e-10}}};
  Simulation simulation{system, integrator};
  simulation.observe(run, every(1e-4));
  simulation.run(state, study.duration);
  write_page(run, folder + "/squeezer.html", {.title = "Andrews' squeezing mechanism"});
}

/// Balls and cubes thrown into a box of four walls.
void write_pile(const std::string& folder) {
  constexpr double kRadius = 0.05, kWall = 0.18;
  SystemGraph graph;
  std::vector<Collider> colliders{{graph.ground().marker(), shape::half_space()}};
  const auto wall = [&](const Vector3& at, const Vector3& edges) {
    colliders.push_back({graph.ground().marker(at), shape::box(edges)});
  };
  for (const double side : {-1.0, 1.0}) {
    wall({side * (kWall + 0.01), 0, 0.1}, {0.02, 2 * kWall, 0.2});
    wall({0, side * (kWall + 0.01), 0.1}, {2 * kWall, 0.02, 0.2});
  }
  for (int i = 0; i < 24; ++i) {
    const Vector3 at(0.12 * (i % 2 - 0.5) + 0.01 * std::sin(3 * i), 0.12 * (i / 2 % 2 - 0.5) + 0.01 * std::cos(5 * i),
                     0.1 + 0.13 * (i / 4));
    const bool cube = i % 2 == 1;
    const double mass = cube ? 1.0 : 0.5,
                 inertia = cube ? mass / 6 * std::pow(1.6 * kRadius, 2) : 0.4 * mass * kRadius * kRadius;
    auto& body = graph.add<RigidBody>((cube ? "cube " : "ball ") + std::to_string(i),
                                      {.mass = mass,
                                       .inertia = Vector3(Vector3::Constant(inertia)),
                                       .position = at,
                                       .orientation = rotation_about({1, 2, 0.5}, 0.3 * i)});
    colliders.push_back({body.marker(), cube ? shape::box(Vector3::Constant(1.6 * kRadius)) : shape::sphere(kRadius)});
  }
  graph.add<Contact>("pile", std::move(colliders), {.friction = {.coefficient = 0.4}});
  const System system = assemble(graph);
  Run run{system, {total_energy("energy")}, {.name = "pile", .detailed = 10}};
  State state = system.initial_state();
  MoreauJean stepping{{.step = 2e-3, .contact = {.tolerance = 1e-5}}};
  Simulation simulation{system, stepping};
  simulation.observe(run, every(0.01));
  simulation.run(state, 1.5);
  write_page(run, folder + "/pile.html", {.title = "Balls and cubes in a box"});
}

}  // namespace

int main(int argc, char** argv) {
  const std::string folder = argc > 1 ? argv[1] : "results/pages";
  try {
    write_bracket(folder);
    write_squeezer(folder);
    write_pile(folder);
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
