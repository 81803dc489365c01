// A hundred swings or turns: errors of time steps add up, and choosing must cost little beside the run.
#include <cmath>

#include "bodies/shapes.h"
#include "engine/assembly/batch_of.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "joints/revolute_joint.h"
#include "tools/certify/scenes.h"

namespace lithe::certify {
namespace {

ElasticPartParameters clamped(const SolidModel& solid, double damping) {
  const Vector3 size = solid->nodes.rowwise().maxCoeff();
  return {.solid = solid,
          .frame = TangentFrame{solid->node_set("x0")},
          .eigenmodes = 6,
          .loaded = {solid->node_set("x1")},
          .stiffness_damping = damping,
          .position = {0, -size.y() / 2, -size.z() / 2}};
}

std::vector<Sensor> pendulum(SystemGraph& graph, ElasticParts& parts) {
  const SolidModel solid = bar({0.4, 0.02, 0.01}, {6, 1, 2}, {1e8, 0.35, 1150});
  const std::vector<int> edge =
      nodes_where(*solid, [](const Vector3& p) { return p.x() < 1e-9 && std::abs(p.z() - 0.005) < 1e-9; });
  ElasticPart rod = parts.add(graph, "rod",
                              {.solid = solid,
                               .frame = HingeFrame{edge},
                               .eigenmodes = 6,
                               .loaded = {solid->node_set("x1")},
                               .stiffness_damping = 5e-4,
                               .position = {0, -0.01, -0.005}});
  hold(graph, "hinge", on(graph.ground()), rod, edge);
  return {position(rod.average("x1"), "tip")};
}

/// An arm on a hub that a spring holds, let go with a turn.
std::vector<Sensor> rocker(SystemGraph& graph, ElasticParts& parts) {
  auto& hub = graph.add<RigidBody>("hub", {.mass = 1, .inertia = {2e-3, 2e-3, 2e-3}, .angular_velocity = {0, 0, 6}});
  auto& hinge = graph.add<RevoluteJoint>("hinge", {graph.ground().marker(), hub.marker()});
  graph.add<CoordinateSpring>("spring", {hinge.angle()}, {.stiffness = 4});
  const SolidModel solid = bar({0.3, 0.006, 0.02}, {6, 1, 1}, {3e9, 0.35, 1150});
  ElasticPartParameters p = clamped(solid, 2e-4);
  p.angular_velocity = {0, 0, 6};
  p.velocity = Vector3(0, 0, 6).cross(p.position);
  ElasticPart part = parts.add(graph, "arm", p);
  hold(graph, "root", on(hub), part, part.ids("x0"));
  return {position(part.average("x1"), "tip")};
}

std::vector<Sensor> hung(SystemGraph& graph, ElasticParts& parts) {
  const SolidModel solid = bar({0.5, 0.02, 0.01}, {8, 1, 1}, {5e9, 0.35, 1150});
  const std::vector<int> ends[] = {solid->node_set("x0"), solid->node_set("x1")};
  ElasticPart beam = parts.add(
      graph, "bar", {.solid = solid, .eigenmodes = 8, .loaded = {ends[0], ends[1]}, .stiffness_damping = 1e-4});
  for (const auto& end : ends) {
    const Vector3 place = beam.middle(end);
    graph.add<SpringDamper>(place.x() < 0.25 ? "left" : "right",
                            {graph.ground().marker(place + Vector3(0, 0, 0.3)), beam.average(end)},
                            {.stiffness = 300, .damping = 0.02, .preload = 9.81 * beam.mass() / 2});
  }
  graph.add<UserForce>("pull", {beam.average(ends[1])},
                       {[](double t, const MarkerView&) { return force(Vector3(0, 0, 3 * pulse(t, 0, 0.1))); }});
  return {position(beam.average(ends[1]), "end")};
}

/// A crank that turns steadily, and an elastic arm on it with weight.
std::vector<Sensor> wheel(SystemGraph& graph, ElasticParts& parts) {
  auto& hub = graph.add<RigidBody>("hub", {.mass = 1, .inertia = {2e-3, 2e-3, 2e-3}});
  const Matrix3 about_y = axes_along(Vector3::UnitY());
  auto& hinge = graph.add<RevoluteJoint>("hinge", {graph.ground().marker({}, about_y), hub.marker({}, about_y)});
  graph.add<CoordinateDrive>("motor", {hinge.angle()}, {.motion = run_up(10, 1)});
  const SolidModel solid = bar({0.5, 0.02, 0.006}, {6, 1, 1}, {5e9, 0.35, 1150});
  ElasticPart part = parts.add(graph, "arm", clamped(solid, 5e-4));
  hold(graph, "root", on(hub), part, part.ids("x0"));
  return {relative_position(part.average("x1"), hub.marker(), "tip")};
}

}  // namespace

void add_long_runs(std::vector<Scene>& scenes) {
  scenes.push_back({.name = "long_pendulum",
                    .shows = "a hundred swings of a soft rod",
                    .duration = 100,
                    .samples = 2000,
                    .draw = pendulum,
                    .is_long = true});
  scenes.push_back({.name = "long_rocker",
                    .shows = "an elastic arm on a hub with a spring: a hundred swings",
                    .duration = 30,
                    .samples = 2000,
                    .gravity = {0, 0, 0},
                    .draw = rocker,
                    .is_long = true});
  scenes.push_back({.name = "long_hung_bar",
                    .shows = "a bar bounces a hundred times on two springs",
                    .duration = 8,
                    .samples = 2000,
                    .draw = hung,
                    .is_long = true});
  scenes.push_back({.name = "long_wheel",
                    .shows = "a hundred turns of an arm with weight",
                    .duration = 63,
                    .samples = 2000,
                    .draw = wheel,
                    .is_long = true});
}

}  // namespace lithe::certify
