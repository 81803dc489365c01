// 20_contact: a flexible rod is dropped on a table, beside a rigid one and a box that slides to rest.
//
// Shows: shapes on bodies, the skin of a flexible body, compliant surfaces (any integrator) and rigid ones (time
//        stepping), what contacts do read off by sensors.
// Expect: results/contact/ with the tips' height and the tables' forces: the flexible rod is in touch longer and more
//         softly, and keeps a part of the energy as vibration; the box stops where Coulomb says.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bodies/flexible/surface_mesh.h"
#include "engine/observe/contact_sensors.h"
#include "integrators/moreau_jean.h"
#include "joints/contact/contact.h"
#include "lithe/lithe.h"

using namespace lithe;

namespace {

constexpr double kGravity = 9.81, kFriction = 0.3, kThrown = 0.6;  // m/s², -, m/s

/// One scene, drawn under either law.
struct Scene {
  SystemGraph graph{{.gravity = {0, 0, -kGravity}}};
  Marker flexible_tip, rigid_tip, box;
  const Contact *flexible_contact = nullptr, *rigid_contact = nullptr, *box_contact = nullptr;
};

void draw(Scene& scene, const Contact::Parameters& law) {
  // 1. Two rods of plastic, alike but that one bends, each with its far end down; their lowest edges are 20 mm up.
  const Vector3 size(0.4, 0.02, 0.02);
  const double tilt = 0.1, density = 1200, mass = size.prod() * density;
  const Matrix3 turned = rotation_about({0, 1, 0}, tilt);
  const Vector3 corner(0, 0, 0.02 + size[0] * std::sin(tilt));
  const FiniteElementModel model =
      brick_mesh({.size = size, .divisions = {8, 1, 1}, .type = "C3D8I", .material = {2e9, 0.3, density}});
  auto& flexible = scene.graph.add<FlexibleBody>("flexible rod", {.basis = make_basis(model, MeanAxisFrame{}, 6),
                                                                  .damping = {.modal_ratios = {0.01}},
                                                                  .position = corner,
                                                                  .orientation = turned});
  const Vector3 across = size.cwiseProduct(size);
  auto& rigid = scene.graph.add<RigidBody>(
      "rigid rod", {.mass = mass,
                    .inertia = {mass / 12 * (across[1] + across[2]), mass / 12 * (across[0] + across[2]),
                                mass / 12 * (across[0] + across[1])},
                    .position = Vector3(0, 0.1, 0) + corner + turned * (size / 2),
                    .orientation = turned});
  // 2. A box of 0.5 kg on the table, thrown along it.
  auto& box = scene.graph.add<RigidBody>(
      "box", {.mass = 0.5, .inertia = {2e-4, 2e-4, 2e-4}, .position = {0, -0.2, 0.03}, .velocity = {kThrown, 0, 0}});

  // 3. What touches what: the table with the skin of the flexible rod, with the rigid one, with the box.
  const SurfaceMesh skin = surface(flexible);
  const Collider table{scene.graph.ground().marker(), shape::half_space()};
  scene.flexible_contact = &scene.graph.add<Contact>(
      "flexible contact", {table, {skin.frame, shape::surface(skin.nodes, skin.points, skin.triangles, skin.reach)}},
      law);
  scene.rigid_contact = &scene.graph.add<Contact>("rigid contact", {table, {rigid.marker(), shape::box(size)}}, law);
  scene.box_contact =
      &scene.graph.add<Contact>("box contact", {table, {box.marker(), shape::box({0.06, 0.06, 0.06})}}, law);
  scene.flexible_tip = flexible.node(model.node_set("x_max").front());
  scene.rigid_tip = rigid.marker(Vector3(size[0] / 2, -size[1] / 2, -size[2] / 2));
  scene.box = box.marker();
}

/// Where the box has come to, m; what the tables bear at the end over the weights; the charts' lines.
struct Outcome {
  double slid = 0, bears = 0, deepest = 0;
  Table table;
};
Outcome run(const Contact::Parameters& law, Integrator& integrator) {
  Scene scene;
  draw(scene, law);
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  Simulation simulation{system, integrator};
  Recorder record{{height(scene.flexible_tip, "flexible"), height(scene.rigid_tip, "rigid"), position(scene.box, "box"),
                   contact_force(*scene.flexible_contact, 1, "on_flexible"),
                   contact_force(*scene.rigid_contact, 1, "on_rigid"), contact_force(*scene.box_contact, 1, "on_box")}};
  simulation.observe(record, every(5e-4));
  simulation.run(state, 0.4);
  const Table& t = record.table();
  const std::vector<double> x = t.column("box_x"), f = t.column("on_box_force_z"), edge = t.column("flexible");
  return {x.back() - x.front(), f.back() / (0.5 * kGravity), -*std::min_element(edge.begin(), edge.end()), t};
}

}  // namespace

int main() {
  // 4. Compliant surfaces with an adaptive integrator; rigid ones by time stepping.
  Radau radau{{.tolerance = {.relative = 1e-5, .absolute = 1e-7}}};
  const Outcome soft = run({.law = Compliance{.stiffness = 1e7, .restitution = 0.5},
                            .friction = {.coefficient = kFriction, .creep_speed = 1e-3}},
                           radau);
  MoreauJean stepping{{.step = 1e-4}};
  const Outcome hard = run({.law = RigidSurfaces{}, .friction = {.coefficient = kFriction}}, stepping);

  // 5. Tips and forces over time.
  Chart tips{.title = "Rods dropped on a table", .x_label = "time (s)", .y_label = "height of the lower edge (m)"};
  Chart forces{.title = "What the table does to them", .x_label = "time (s)", .y_label = "force (N)"};
  for (const auto& [name, outcome] : {std::pair("compliant", &soft), {"rigid surfaces", &hard}})
    for (const char* rod : {"flexible", "rigid"}) {
      const std::string title = std::string(rod) + " rod, " + name;
      const LineStyle style = outcome == &soft ? LineStyle::solid : LineStyle::dashed;
      tips.lines.push_back({title, outcome->table.column("t"), outcome->table.column(rod), style});
      if (outcome == &soft)
        forces.lines.push_back(
            {title, outcome->table.column("t"), outcome->table.column(std::string("on_") + rod + "_force_z"), style});
    }
  write_chart(tips, "results/contact/tips");
  write_chart(forces, "results/contact/forces");

  // 6. Check the answer: the box slides v²/(2 μ g) and then weighs what it weighs; nothing has sunk in.
  const double expected = kThrown * kThrown / (2 * kFriction * kGravity);
  const auto most = [](const Outcome& o, const char* c) {
    const std::vector<double> f = o.table.column(c);
    return *std::max_element(f.begin(), f.end());
  };
  const double flexible = most(soft, "on_flexible_force_z"), rigid = most(soft, "on_rigid_force_z");
  std::printf("the box slid %.5f m (compliant, %ld steps) and %.5f m (rigid surfaces, %ld steps); Coulomb: %.5f m\n",
              soft.slid, radau.statistics().steps, hard.slid, stepping.statistics().steps, expected);
  std::printf(
      "it weighs %.8f and %.8f of its weight; largest force on the flexible rod %.1f N, on the rigid one %.1f N\n",
      soft.bears, hard.bears, flexible, rigid);
  std::printf("the flexible rod's edge went %.2e and %.2e m into the table\n", soft.deepest, hard.deepest);
  return std::abs(hard.slid / expected - 1) < 1e-3 && std::abs(soft.slid / expected - 1) < 0.02 &&
                 std::abs(hard.bears - 1) < 1e-8 && std::abs(soft.bears - 1) < 1e-3 && flexible < 0.8 * rigid &&
                 hard.deepest < 1e-6
             ? 0
             : 1;
}
