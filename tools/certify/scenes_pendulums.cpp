// Pendulums and chains: what swings under its weight.
#include <cmath>

#include "bodies/flexible/readers/calculix.h"
#include "bodies/shapes.h"
#include "engine/assembly/batch_of.h"
#include "engine/output/csv.h"
#include "joints/fixed_joint.h"
#include "joints/revolute_joint.h"
#include "tools/certify/scenes.h"

namespace lithe::certify {
namespace {

const std::string kData = std::string(LITHE_EXAMPLE_DATA) + "/pendulum/";

/// The rod of examples/02, against the nonlinear solution that came with its mesh (CalculiX 2.20).
Scene known_pendulum(const std::string& body, double duration, const std::string& shows) {
  return {.name = "pendulum_" + body,
          .shows = shows,
          .duration = duration,
          .samples = 100,
          .draw = [body](SystemGraph& graph, ElasticParts& parts) -> std::vector<Sensor> {
            const auto solid =
                std::make_shared<const FiniteElementModel>(read_calculix(kData + body + "/calculix/matrices"));
            const std::vector<int> hinge = solid->node_set("hinge");
            ElasticPart rod = parts.add(graph, "rod", {.solid = solid, .frame = HingeFrame{hinge}, .eigenmodes = 16});
            hold(graph, "hinge", on(graph.ground()), rod, hinge);
            return {position(rod.node(solid->node_set("tip").front()), "tip")};
          },
          .known =
              [body, duration] {
                const Table all = read_csv(kData + body + "/trajectory.csv");  // every millisecond
                Table table{.columns = {"t", "tip_x", "tip_y", "tip_z"}};
                const int every = static_cast<int>(std::round(10 * duration));
                for (int row = 0; row <= 100 * every; row += every)
                  table.add_row({all.at(row, 0), all.at(row, 1), all.at(row, 2), all.at(row, 3)});
                return table;
              }};
}

constexpr double kWidth = 0.02, kHeight = 0.01;  // m, along y and z

/// A link along x of 8 bricks by one across y and two over its height; hinges turn about y at half height.
SolidModel link(double length, double young, int along = 8) {
  return bar({length, kWidth, kHeight}, {along, 1, 2}, {young, 0.35, 1150});
}
std::vector<int> root_edge(const FiniteElementModel& solid) {
  return nodes_where(solid, [](const Vector3& p) { return p.x() < 1e-9 && std::abs(p.z() - kHeight / 2) < 1e-9; });
}
ElasticPartParameters hinged(const SolidModel& solid, double damping, const Vector3& middle_of_root) {
  return {.solid = solid,
          .frame = HingeFrame{root_edge(*solid)},
          .eigenmodes = 8,
          .loaded = {solid->node_set("x1")},
          .stiffness_damping = damping,
          .position = middle_of_root - Vector3(0, kWidth / 2, kHeight / 2)};
}

std::vector<Sensor> tip_mass(SystemGraph& graph, ElasticParts& parts) {
  const SolidModel solid = link(0.4, 1e9);
  ElasticPart rod = parts.add(graph, "rod", hinged(solid, 2e-4, {0, 0, 0}));
  hold(graph, "hinge", on(graph.ground()), rod, root_edge(*solid));
  auto& disc = graph.add<RigidBody>("disc", {.mass = 0.3, .inertia = {1e-3, 2e-3, 1e-3}, .position = {0.4, 0, 0}});
  graph.add<FixedJoint>("weld", {rod.average("x1"), disc.marker()});
  return {position(disc.marker(), "disc")};
}

std::vector<Sensor> rigid_and_elastic(SystemGraph& graph, ElasticParts& parts) {
  const MassProperties shape = box({0.3, 0.03, 0.03}, 1150);
  auto& upper = graph.add<RigidBody>("upper", {.mass = shape.mass, .inertia = shape.inertia, .position = {0.15, 0, 0}});
  const Matrix3 axes = axes_along(Vector3::UnitY());
  graph.add<RevoluteJoint>("shoulder", {graph.ground().marker({}, axes), on(upper)(Vector3::Zero(), axes)});
  const SolidModel solid = link(0.4, 5e7);
  ElasticPart lower = parts.add(graph, "lower", hinged(solid, 1e-3, {0.3, 0, 0}));
  hold(graph, "elbow", on(upper), lower, root_edge(*solid));
  return {position(lower.average("x1"), "tip"), position(upper.marker({0.15, 0, 0}), "elbow")};
}

/// Elastic links in a row, each hinged to a small pin that is welded to the end of the one before.
std::vector<Sensor> chain(SystemGraph& graph, ElasticParts& parts, int links, double length, double young,
                          double damping) {
  const SolidModel solid = link(length, young, 6);
  Places holder = on(graph.ground());
  std::vector<Sensor> watched;
  for (int i = 0; i < links; ++i) {
    const std::string number = std::to_string(i + 1);
    ElasticPart part = parts.add(graph, "link" + number, hinged(solid, damping, {length * i, 0, 0}));
    hold(graph, "hinge" + number, holder, part, root_edge(*solid));
    if (i + 1 == links) {
      watched.push_back(position(part.average("x1"), "tip"));
      break;
    }
    auto& pin = graph.add<RigidBody>(
        "pin" + number, {.mass = 0.01, .inertia = {1e-6, 1e-6, 1e-6}, .position = {length * (i + 1), 0, 0}});
    graph.add<FixedJoint>("weld" + number, {part.average("x1"), pin.marker()});
    holder = on(pin);
    if (i == 0) watched.push_back(position(pin.marker(), "pin"));
  }
  return watched;
}

}  // namespace

void add_pendulums(std::vector<Scene>& scenes) {
  scenes.push_back(known_pendulum("hex8i", 1, "soft rod, 3.6 Hz: 0.8 mm from linear elasticity to the truth"));
  scenes.push_back(known_pendulum("hex20", 1, "the same rod in bricks of second order"));
  scenes.push_back(known_pendulum("paper", 1, "the same rod, skewed: it bends out of the plane"));
  scenes.push_back(known_pendulum("stiff", 0.5, "the same rod of steel"));
  scenes.push_back({.name = "tip_mass_pendulum",
                    .shows = "a disc at the end: the rod hardly bends, rigid serves",
                    .duration = 2,
                    .samples = 100,
                    .draw = tip_mass});
  scenes.push_back({.name = "double_pendulum_half_rigid",
                    .shows = "a rigid link, then a soft one",
                    .duration = 1,
                    .samples = 100,
                    .draw = rigid_and_elastic});
  scenes.push_back(
      {.name = "double_pendulum",
       .shows = "two soft links",
       .duration = 0.8,
       .samples = 80,
       .draw = [](SystemGraph& graph, ElasticParts& parts) { return chain(graph, parts, 2, 0.3, 5e7, 1e-3); }});
  scenes.push_back(
      {.name = "chain_3",
       .shows = "three links that bend much",
       .duration = 0.6,
       .samples = 60,
       .draw = [](SystemGraph& graph, ElasticParts& parts) { return chain(graph, parts, 3, 0.25, 2e7, 2e-3); }});
  scenes.push_back(
      {.name = "chain_4",
       .shows = "four stiff links: rigid serves at 1 %",
       .duration = 0.6,
       .samples = 60,
       .draw = [](SystemGraph& graph, ElasticParts& parts) { return chain(graph, parts, 4, 0.2, 5e8, 1e-4); }});
}

}  // namespace lithe::certify
