// The pages that the documentation shows: pages [FOLDER].
#include <cstdio>
#include <string>

#include "bodies/flexible/surface_mesh.h"
#include "examples/studies/andrews_squeezer.cpp"
#include "integrators/moreau_jean.h"
#include "joints/contact/contact.h"
#include "lithe/lithe.h"

namespace {

/// To `end` (s), a state every `interval` (s); the page bears the run's name.
void move_and_write(Run& run, const System& system, Integrator& integrator, double interval, double end,
                    const std::string& folder, const std::string& title) {
  State state = system.initial_state();
  Simulation simulation{system, integrator};
  simulation.observe(run, every(interval));
  simulation.run(state, end);
  write_page(run, folder + "/" + run.name() + ".html", {.title = title});
}

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
  GeneralizedAlpha integrator{{.step = 5e-5, .spectral_radius = 0.8}};
  move_and_write(run, system, integrator, 2e-4, 0.04, folder, "A wall bracket, 2 kg put on suddenly");
}

void write_squeezer(const std::string& folder) {
  const StudyScene study = scene();
  SystemGraph graph{{.gravity = study.gravity}};
  std::vector<Sensor> sensors = study.draw(graph);
  const System system = assemble(graph);
  Run run{system, std::move(sensors), {.name = "squeezer"}};
  ExplicitRungeKutta integrator{{.tolerance = {.relative = 1e-8, .absolute = 1e-10}}};
  move_and_write(run, system, integrator, 1e-4, study.duration, folder, "Andrews' squeezing mechanism");
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
  MoreauJean stepping{{.step = 2e-3, .contact = {.tolerance = 1e-5}}};
  move_and_write(run, system, stepping, 0.01, 1.5, folder, "Balls and cubes in a box");
}

/// A strip of spring steel as an exact beam and a rigid rod, let go level: example 24.
void write_beams(const std::string& folder) {
  const double length = 1;
  const BeamSection strip = BeamSection::rectangle(0.02, 0.0005, {2.1e11, 0.3, 7850});
  SystemGraph graph;
  auto& beam = graph.add<Beam>(
      "strip", {.axis = BeamAxis::straight({0, 0, 0}, {length, 0, 0}, {0, 1, 0}), .sections = {{0, strip}}});
  const MassProperties m = box({length, 0.02, 0.0005}, 7850);
  auto& rod = graph.add<RigidBody>("rod", {.mass = m.mass, .inertia = m.inertia, .position = {length / 2, 0, 0}});
  const Matrix3 hinge = rotation_about({1, 0, 0}, M_PI / 2);  // its z along -y
  graph.add<RevoluteJoint>("hinge of the strip", {graph.ground().marker({}, hinge), beam.marker(0, {}, hinge)});
  graph.add<RevoluteJoint>("hinge of the rod",
                           {graph.ground().marker({}, hinge), rod.marker({-length / 2, 0, 0}, hinge)});
  const System system = assemble(graph);
  Run run{system,
          {position(beam.marker(length), "strip"), position(rod.marker({length / 2, 0, 0}), "rod")},
          {.name = "beams"}};
  Radau radau{{.tolerance = {.relative = 1e-5, .absolute = 1e-6}}};
  move_and_write(run, system, radau, 1e-2, 1.0, folder, "A strip of spring steel and a rigid rod, let go level");
}

/// A flexible rod dropped on a table by one end, and a box that slides to rest, with compliant surfaces: example 20.
void write_contact(const std::string& folder) {
  const Vector3 size(0.4, 0.02, 0.02);
  const double tilt = 0.1;
  SystemGraph graph;
  const FiniteElementModel model =
      brick_mesh({.size = size, .divisions = {8, 1, 1}, .type = "C3D8I", .material = {2e9, 0.3, 1200}});
  auto& rod = graph.add<FlexibleBody>("rod", {.basis = make_basis(model, MeanAxisFrame{}, 6),
                                              .damping = {.modal_ratios = {0.01}},
                                              .position = {0, 0, 0.02 + size[0] * std::sin(tilt)},
                                              .orientation = rotation_about({0, 1, 0}, tilt)});
  auto& block = graph.add<RigidBody>(
      "block", {.mass = 0.5, .inertia = {2e-4, 2e-4, 2e-4}, .position = {0, -0.2, 0.03}, .velocity = {0.6, 0, 0}});
  const SurfaceMesh skin = surface(rod);
  const Collider table{graph.ground().marker(), shape::half_space()};
  const Contact::Parameters law{.law = Compliance{.stiffness = 1e7, .restitution = 0.5},
                                .friction = {.coefficient = 0.3, .creep_speed = 1e-3}};
  graph.add<Contact>("rod on table",
                     {table, {skin.frame, shape::surface(skin.nodes, skin.points, skin.triangles, skin.reach)}}, law);
  graph.add<Contact>("block on table", {table, {block.marker(), shape::box({0.06, 0.06, 0.06})}}, law);
  const System system = assemble(graph);
  Run run{system,
          {position(rod.node(model.node_set("x_max").front()), "tip"), position(block.marker(), "block")},
          {.name = "contact"}};
  Radau radau{{.tolerance = {.relative = 1e-5, .absolute = 1e-7}}};
  move_and_write(run, system, radau, 1e-3, 0.4, folder, "A flexible rod and a block on a table");
}

}  // namespace

int main(int argc, char** argv) {
  const std::string folder = argc > 1 ? argv[1] : "results/pages";
  try {
    write_bracket(folder);
    write_squeezer(folder);
    write_pile(folder);
    write_beams(folder);
    write_contact(folder);
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
