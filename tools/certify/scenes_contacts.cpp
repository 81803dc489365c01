// Compliant contacts: stops, bounces, a pair of balls.
#include <cmath>

#include "bodies/shapes.h"
#include "engine/assembly/batch_of.h"
#include "joints/contact/contact.h"
#include "joints/fixed_joint.h"
#include "joints/revolute_joint.h"
#include "tools/certify/scenes.h"

namespace lithe::certify {
namespace {

constexpr double kBall = 0.03;  // m, radius

RigidBody& ball(SystemGraph& graph, const std::string& name, double mass, const Vector3& place,
                const Vector3& velocity = {0, 0, 0}) {
  const double inertia = 0.4 * mass * kBall * kBall;
  return graph.add<RigidBody>(
      name, {.mass = mass, .inertia = {inertia, inertia, inertia}, .position = place, .velocity = velocity});
}
void touch(SystemGraph& graph, const std::string& name, const Marker& a, const Shape& shape_a, const Marker& b,
           double stiffness, double restitution) {
  graph.add<Contact>(name, {{a, shape_a}, {b, shape::sphere(kBall)}},
                     {.law = Compliance{.stiffness = stiffness, .restitution = restitution}});
}

/// A bar of plastic along x, clamped at its root to the ground.
ElasticPart arm(SystemGraph& graph, ElasticParts& parts, double length, double young) {
  const SolidModel solid = bar({length, 0.02, 0.008}, {10, 1, 1}, {young, 0.35, 1150});
  ElasticPart part = parts.add(graph, "arm",
                               {.solid = solid,
                                .frame = TangentFrame{solid->node_set("x0")},
                                .eigenmodes = 8,
                                .loaded = {solid->node_set("x1")},
                                .stiffness_damping = 3e-4,
                                .position = {0, -0.01, -0.004}});
  hold(graph, "root", on(graph.ground()), part, part.ids("x0"));
  return part;
}

std::vector<Sensor> stopped(SystemGraph& graph, ElasticParts& parts) {
  ElasticPart part = arm(graph, parts, 0.4, 3e9);
  RigidBody& tip = ball(graph, "tip", 0.2, {0.4, 0, 0});
  graph.add<FixedJoint>("weld", {part.average("x1"), tip.marker()});
  touch(graph, "stop", graph.ground().marker({0.4, 0, -kBall - 0.01}), shape::half_space(), tip.marker(), 2e4, 0.8);
  return {position(tip.marker(), "tip")};
}

std::vector<Sensor> bounced(SystemGraph& graph, ElasticParts& parts) {
  const SolidModel solid = bar({0.5, 0.02, 0.01}, {10, 1, 1}, {3e9, 0.35, 1150});
  ElasticPart rod = parts.add(graph, "rod",
                              {.solid = solid,
                               .eigenmodes = 10,
                               .loaded = {solid->node_set("x0"), solid->node_set("x1")},
                               .stiffness_damping = 2e-4,
                               .position = {0, -0.01, 0.1}});
  std::vector<Sensor> watched;
  for (const char* end : {"x0", "x1"}) {
    RigidBody& foot = ball(graph, std::string("foot_") + end, 0.1, rod.middle(end));
    graph.add<FixedJoint>(std::string("weld_") + end, {rod.average(end), foot.marker()});
    touch(graph, std::string("floor_") + end, graph.ground().marker({0, 0, end[1] == '1' ? 0.0 : 0.03}),
          shape::half_space(), foot.marker(), 1e5, 0.7);
    watched.push_back(position(foot.marker(), end));
  }
  return watched;
}

std::vector<Sensor> cradle(SystemGraph& graph, ElasticParts&) {
  const Matrix3 about_y = axes_along(Vector3::UnitY());
  std::vector<Sensor> watched;
  Marker before{};
  for (int i = 0; i < 2; ++i) {
    const std::string name = i == 0 ? "first" : "second";
    const Vector3 pin(2.02 * kBall * i, 0, 0);
    const Vector3 place =
        i == 0 ? Vector3(pin + 0.3 * Vector3(-std::sin(0.8), 0, -std::cos(0.8))) : Vector3(pin + Vector3(0, 0, -0.3));
    RigidBody& each = ball(graph, name, 0.3, place);
    graph.add<RevoluteJoint>(name + "_pin", {graph.ground().marker(pin, about_y), on(each)(pin, about_y)});
    if (i > 0) touch(graph, "touch", before, shape::sphere(kBall), each.marker(), 1e6, 0.9);
    before = each.marker();
    watched.push_back(position(each.marker(), name));
  }
  return watched;
}

std::vector<Sensor> caught(SystemGraph& graph, ElasticParts& parts) {
  ElasticPart part = arm(graph, parts, 0.3, 5e9);
  const MassProperties shape = box({0.08, 0.08, 0.01}, 1500);
  auto& tray = graph.add<RigidBody>("tray", {.mass = shape.mass, .inertia = shape.inertia, .position = {0.34, 0, 0}});
  graph.add<FixedJoint>("weld", {part.average("x1"), on(tray)(part.middle("x1"), Matrix3::Identity())});
  RigidBody& dropped = ball(graph, "ball", 0.1, {0.34, 0, 0.1});
  touch(graph, "catch", tray.marker({0, 0, 0.005}), shape::half_space(), dropped.marker(), 2e4, 0.6);
  return {position(tray.marker(), "tray"), height(dropped.marker(), "ball")};
}

}  // namespace

void add_contacts(std::vector<Scene>& scenes) {
  scenes.push_back({.name = "contact_stop",
                    .shows = "an arm falls with a mass at its end onto a compliant stop, again and again",
                    .duration = 0.6,
                    .samples = 120,
                    .draw = stopped});
  scenes.push_back({.name = "contact_bounce",
                    .shows = "a bar with feet falls onto two floors, one higher",
                    .duration = 0.4,
                    .samples = 120,
                    .draw = bounced});
  scenes.push_back({.name = "contact_cradle",
                    .shows = "a ball on a rod swings into another: rigid bodies alone",
                    .duration = 1.2,
                    .samples = 120,
                    .draw = cradle});
  scenes.push_back({.name = "contact_tray",
                    .shows = "a ball drops onto a tray at the end of an elastic arm",
                    .duration = 0.5,
                    .samples = 120,
                    .draw = caught});
}

}  // namespace lithe::certify
