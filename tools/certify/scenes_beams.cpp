// Slender bodies: rigid, of modes or exact; their references are exact beams of many elements.
#include <cmath>

#include "engine/assembly/batch_of.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/user_force.h"
#include "joints/revolute_joint.h"
#include "tools/certify/scenes.h"

namespace lithe::certify {
namespace {

constexpr int kFinest = 128;

/// Along x from the origin, clamped at `root` or hinged there about y; drawn with eight elements.
struct Slender {
  SlenderBody& body;
  Marker tip;
};
Slender slender(SystemGraph& graph, ElasticParts& parts, const std::string& name, double length,
                const BeamSection& section) {
  auto& body = parts.add_beam(graph, name,
                              {.beam = {.axis = BeamAxis::straight({0, 0, 0}, {length, 0, 0}, {0, 1, 0}),
                                        .sections = {{0, section}},
                                        .elements = 8},
                               .mode_count = 12});
  return {body, body.marker(length)};
}
void clamp(SystemGraph& graph, const Places& holder, Slender& beam) {
  const Matrix3 axes = beam.body.parameters().beam.axis.pose(0).axes;
  graph.add<FixedJoint>(beam.body.name() + "_root", {holder(Vector3::Zero(), axes), beam.body.marker(0)});
}
/// 1 kg/m and so stiff in bending, N m^2.
BeamSection section_of(double bending, double damping) {
  const double EA = 1e4 * bending;
  return BeamSection::diagonal({EA, EA / 3, EA / 3, bending, bending, bending}, 1, {2e-4, 1e-4, 1e-4}).damped(damping);
}
struct Turned {
  RigidBody& body;
};
Turned driven(SystemGraph& graph, MotionLaw motion) {
  auto& hub = graph.add<RigidBody>("hub", {.mass = 5, .inertia = {0.05, 0.05, 0.05}});
  auto& bearing = graph.add<RevoluteJoint>("bearing", {graph.ground().marker(), hub.marker()});
  graph.add<CoordinateDrive>("drive", {bearing.angle()}, {.motion = std::move(motion)});
  return {hub};
}

std::vector<Sensor> swung(SystemGraph& graph, ElasticParts& parts) {
  Slender rod = slender(graph, parts, "rod", 1, section_of(60, 1e-3));
  const Matrix3 about_y = axes_along(Vector3::UnitY());
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, about_y), rod.body.marker_at_world({0, 0, 0}, about_y)});
  return {position(rod.tip, "tip")};
}

std::vector<Sensor> spun(SystemGraph& graph, ElasticParts& parts) {
  Turned hub = driven(graph, run_up(8, 1));
  Slender blade = slender(graph, parts, "blade", 2, section_of(400, 1e-3));
  clamp(graph, on(hub.body), blade);
  return {relative_position(blade.tip, hub.body.marker(), "tip")};
}

std::vector<Sensor> pushed(SystemGraph& graph, ElasticParts& parts) {
  Slender rod = slender(graph, parts, "rod", 1, section_of(30, 2e-3));
  clamp(graph, on(graph.ground()), rod);
  graph.add<UserForce>("push", {rod.tip},
                       {[](double t, const MarkerView&) { return force(Vector3(0, 2, 12) * pulse(t, 0, 0.3)); }});
  return {position(rod.tip, "tip")};
}

std::vector<Sensor> slewed(SystemGraph& graph, ElasticParts& parts) {
  Turned hub = driven(graph, smooth_step(0, 1.2, 0, 1));
  Slender boom = slender(graph, parts, "boom", 1.5, section_of(500, 1e-3));
  clamp(graph, on(hub.body), boom);
  auto& load = graph.add<RigidBody>("load", {.mass = 1, .inertia = {1e-3, 1e-3, 1e-3}, .position = {1.5, 0, 0}});
  const Matrix3 axes = boom.body.parameters().beam.axis.pose(1.5).axes;
  graph.add<FixedJoint>("grip", {boom.tip, load.marker({}, axes)});
  return {position(load.marker(), "load")};
}

}  // namespace

void add_beams(std::vector<Scene>& scenes) {
  const Vector3 weightless(0, 0, 0);
  scenes.push_back({.name = "beam_pendulum",
                    .shows = "a slender rod swings from a pin and bends",
                    .duration = 0.8,
                    .samples = 80,
                    .draw = swung,
                    .beam_elements = kFinest});
  scenes.push_back({.name = "beam_blade",
                    .shows = "a blade brought to speed lags",
                    .duration = 2,
                    .samples = 100,
                    .gravity = weightless,
                    .draw = spun,
                    .beam_elements = kFinest});
  scenes.push_back({.name = "beam_pushed",
                    .shows = "a clamped rod pushed aside by a tenth of its length, out of plane too",
                    .duration = 1,
                    .samples = 100,
                    .gravity = weightless,
                    .draw = pushed,
                    .beam_elements = kFinest});
  scenes.push_back({.name = "beam_boom",
                    .shows = "a boom with a load at its end slews and swings out",
                    .duration = 1.6,
                    .samples = 100,
                    .gravity = weightless,
                    .draw = slewed,
                    .beam_elements = kFinest});
}

}  // namespace lithe::certify
