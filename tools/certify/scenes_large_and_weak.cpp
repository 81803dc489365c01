// Deflections at which modes end, and parts that hardly feel each other.
#include <cmath>

#include "engine/assembly/batch_of.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "joints/revolute_joint.h"
#include "tools/certify/scenes.h"

namespace lithe::certify {
namespace {

ElasticPart cantilever(SystemGraph& graph, ElasticParts& parts, const std::string& name, const Vector3& size,
                       const Material& material, double damping, const Vector3& place = {0, 0, 0}) {
  const SolidModel solid = bar(size, {10, 1, 1}, material);
  ElasticPart beam = parts.add(graph, name,
                               {.solid = solid,
                                .frame = TangentFrame{solid->node_set("x0")},
                                .eigenmodes = 8,
                                .loaded = {solid->node_set("x1")},
                                .stiffness_damping = damping,
                                .position = place - Vector3(0, size.y() / 2, size.z() / 2)});
  hold(graph, name + "_root", on(graph.ground()), beam, beam.ids("x0"));
  return beam;
}

std::vector<Sensor> bent(SystemGraph& graph, ElasticParts& parts) {
  ElasticPart beam = cantilever(graph, parts, "strip", {0.4, 0.02, 0.004}, {2e9, 0.35, 1150}, 2e-3);
  const MotionLaw push = smooth_step(0, 1.2, 0, 0.4);  // N
  graph.add<UserForce>("push", {beam.average("x1")},
                       {[=](double t, const MarkerView&) { return force(Vector3(0, 0, push(t).value)); }});
  return {position(beam.average("x1"), "tip")};
}

std::vector<Sensor> limp(SystemGraph& graph, ElasticParts& parts) {
  const SolidModel solid = bar({0.4, 0.02, 0.01}, {10, 1, 2}, {4e6, 0.35, 1150});
  const std::vector<int> edge =
      nodes_where(*solid, [](const Vector3& p) { return p.x() < 1e-9 && std::abs(p.z() - 0.005) < 1e-9; });
  ElasticPart rod = parts.add(graph, "rod",
                              {.solid = solid,
                               .frame = HingeFrame{edge},
                               .eigenmodes = 8,
                               .loaded = {solid->node_set("x1")},
                               .stiffness_damping = 5e-3,
                               .position = {0, -0.01, -0.005}});
  hold(graph, "hinge", on(graph.ground()), rod, edge);
  return {position(rod.average("x1"), "tip")};
}

/// One is struck; a weak spring takes it to the other, which is watched.
std::vector<Sensor> coupled(SystemGraph& graph, ElasticParts& parts) {
  const Material plastic{3e9, 0.35, 1150};
  ElasticPart struck = cantilever(graph, parts, "struck", {0.3, 0.02, 0.006}, plastic, 3e-4);
  ElasticPart watched = cantilever(graph, parts, "watched", {0.3, 0.02, 0.006}, plastic, 3e-4, {0, 0, 0.1});
  graph.add<SpringDamper>("spring", {struck.average("x1"), watched.average("x1")}, {.stiffness = 4});
  graph.add<UserForce>("blow", {struck.average("x1")},
                       {[](double t, const MarkerView&) { return force(Vector3(0, 0, 2 * pulse(t, 0, 0.04))); }});
  return {position(watched.average("x1"), "tip")};
}

/// A rigid pendulum pulls at an elastic arm by a soft spring.
std::vector<Sensor> pulled(SystemGraph& graph, ElasticParts& parts) {
  ElasticPart arm = cantilever(graph, parts, "arm", {0.3, 0.02, 0.006}, {3e9, 0.35, 1150}, 3e-4, {0, 0, 0.2});
  const Matrix3 about_y = axes_along(Vector3::UnitY());
  auto& bob = graph.add<RigidBody>("bob", {.mass = 0.5, .inertia = {1e-3, 1e-3, 1e-3}, .position = {0.5, 0, -0.1}});
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({0.3, 0, 0}, about_y), on(bob)({0.3, 0, 0}, about_y)});
  graph.add<SpringDamper>("spring", {arm.average("x1"), bob.marker()}, {.stiffness = 3});
  return {position(arm.average("x1"), "tip"), position(bob.marker(), "bob")};
}

}  // namespace

void add_large_and_weak(std::vector<Scene>& scenes) {
  const Vector3 weightless(0, 0, 0);
  scenes.push_back({.name = "large_strip",
                    .shows = "a strip pushed aside by more than a third of its length",
                    .duration = 1,
                    .samples = 100,
                    .gravity = weightless,
                    .draw = bent});
  scenes.push_back({.name = "large_pendulum",
                    .shows = "a limp rod swings and hangs behind",
                    .duration = 0.6,
                    .samples = 60,
                    .draw = limp});
  scenes.push_back({.name = "weak_beams",
                    .shows = "two cantilevers and a weak spring: one is struck, the other watched",
                    .duration = 1,
                    .samples = 200,
                    .gravity = weightless,
                    .draw = coupled});
  scenes.push_back({.name = "weak_pendulum",
                    .shows = "a pendulum pulls at an elastic arm by a soft spring",
                    .duration = 2,
                    .samples = 200,
                    .draw = pulled});
}

}  // namespace lithe::certify
