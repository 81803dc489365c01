// Structures under loads: struck, pressed, spun.
#include <cmath>

#include "bodies/flexible/readers/read_flexible_body.h"
#include "engine/assembly/batch_of.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/user_force.h"
#include "joints/point_on_line_joint.h"
#include "joints/revolute_joint.h"
#include "tools/certify/scenes.h"

namespace lithe::certify {
namespace {

/// A cantilever in the x direction, the middle of its root at `place`; interfaces: its end and `more`.
ElasticPart cantilever(SystemGraph& graph, ElasticParts& parts, const SolidModel& solid, double damping,
                       int eigenmodes = 8, std::vector<std::vector<int>> more = {}, const std::string& name = "beam",
                       const Vector3& place = {0, 0, 0}) {
  const Vector3 size = solid->nodes.rowwise().maxCoeff();
  more.push_back(solid->node_set("x1"));
  ElasticPart beam = parts.add(graph, name,
                               {.solid = solid,
                                .frame = TangentFrame{solid->node_set("x0")},
                                .eigenmodes = eigenmodes,
                                .loaded = std::move(more),
                                .stiffness_damping = damping,
                                .position = place - Vector3(0, size.y() / 2, size.z() / 2)});
  hold(graph, name + "_root", on(graph.ground()), beam, beam.ids("x0"));
  return beam;
}

std::vector<Sensor> struck(SystemGraph& graph, ElasticParts& parts) {
  ElasticPart beam = cantilever(graph, parts, bar({0.5, 0.02, 0.005}, {12, 1, 1}, {7e10, 0.33, 2700}), 2e-4);
  auto& mass = graph.add<RigidBody>("mass", {.mass = 0.2, .inertia = {1e-4, 1e-4, 1e-4}, .position = {0.5, 0, 0}});
  graph.add<FixedJoint>("weld", {beam.average("x1"), mass.marker()});
  graph.add<UserForce>("blow", {mass.marker()},
                       {[](double t, const MarkerView&) { return force(Vector3(0, 4, 15) * pulse(t, 0, 0.06)); }});
  return {position(mass.marker(), "mass")};
}

std::vector<Sensor> hammered(SystemGraph& graph, ElasticParts& parts) {
  const SolidModel solid = bar({0.6, 0.02, 0.01}, {24, 1, 1}, {3e9, 0.35, 1150});
  const std::vector<int> section = nodes_where(*solid, [](const Vector3& p) { return std::abs(p.x() - 0.3) < 1e-9; });
  ElasticPart beam = cantilever(graph, parts, solid, 2e-6, 14, {section});
  const Marker middle = beam.average(section);
  graph.add<UserForce>("hammer", {middle},
                       {[](double t, const MarkerView&) { return force(Vector3(0, 0, 60 * pulse(t, 0, 0.002))); }});
  return {position(beam.average("x1"), "tip"), position(middle, "middle")};
}

std::vector<Sensor> neighbours(SystemGraph& graph, ElasticParts& parts) {
  std::vector<Sensor> watched = hammered(graph, parts);
  ElasticPart other = cantilever(graph, parts, bar({0.3, 0.02, 0.003}, {10, 1, 1}, {7e10, 0.33, 2700}), 1e-5, 8, {},
                                 "other", {0, 0.5, 0});
  graph.add<UserForce>("gust", {other.average("x1")},
                       {[](double t, const MarkerView&) { return force(Vector3(0, 0, 4 * pulse(t, 0.01, 0.03))); }});
  watched.pop_back();
  return watched;
}

/// The bracket of examples/19 in plastic, with its bolts on a hub that a drive turns, and an instrument at its eye.
std::vector<Sensor> bracket(SystemGraph& graph, ElasticParts& parts) {
  const SolidModel solid =
      read_flexible_body(LITHE_EXAMPLE_DATA "/bracket/bracket.msh", {.materials = {{"bracket", {3e9, 0.35, 1150}}}})
          .model;
  std::vector<int> bolts = solid->node_set("bolt_1");
  bolts.insert(bolts.end(), solid->node_set("bolt_2").begin(), solid->node_set("bolt_2").end());
  const std::vector<int>& eye = solid->node_set("eye");
  ElasticPart part = parts.add(graph, "bracket",
                               {.solid = solid,
                                .eigenmodes = 8,
                                .loaded = {bolts, eye},
                                .finest = Deflection::linear,
                                .stiffness_damping = 2e-6});
  auto& hub = graph.add<RigidBody>("hub", {.mass = 0.2, .inertia = {1e-4, 1e-4, 1e-4}, .position = part.middle(bolts)});
  const Matrix3 about_y = axes_along(Vector3::UnitY());
  auto& hinge =
      graph.add<RevoluteJoint>("hinge", {on(graph.ground())(part.middle(bolts), about_y), hub.marker({}, about_y)});
  graph.add<CoordinateDrive>("motor", {hinge.angle()}, {.motion = smooth_step(0, 0.3, 0, 0.06)});
  graph.add<FixedJoint>("bolts", {hub.marker(), part.average(bolts)});
  const Vector3 place = part.middle(eye) + Vector3(0, 0.03, 0);
  auto& instrument =
      graph.add<RigidBody>("instrument", {.mass = 0.1, .inertia = {4e-5, 4e-5, 4e-5}, .position = place});
  graph.add<FixedJoint>("weld", {part.average(eye), on(instrument)(part.middle(eye), Matrix3::Identity())});
  graph.add<UserForce>("blow", {instrument.marker()},
                       {[](double t, const MarkerView&) { return force(Vector3(5, 2, 0) * pulse(t, 0.02, 0.022)); }});
  return {position(instrument.marker(), "instrument"), relative_position(part.average(eye), hub.marker(), "eye")};
}

std::vector<Sensor> pressed(SystemGraph& graph, ElasticParts& parts) {
  ElasticPart beam = cantilever(graph, parts, bar({0.4, 0.02, 0.01}, {12, 1, 1}, {3e9, 0.35, 1150}), 5e-4);
  const MotionLaw press = smooth_step(0, 50, 0, 0.6), side = smooth_step(0, 0.5, 0, 0.2);  // N
  graph.add<UserForce>("load", {beam.average("x1")}, {[=](double t, const MarkerView&) {
                         return force(Vector3(-press(t).value, 0, side(t).value));
                       }});
  return {position(beam.average("x1"), "tip")};
}

std::vector<Sensor> rotor(SystemGraph& graph, ElasticParts& parts) {
  const double length = 0.6, side = 0.012;
  const SolidModel solid = bar({length, side, side}, {12, 1, 1}, {2.1e11, 0.3, 7800});
  const std::vector<int> seat =
      nodes_where(*solid, [=](const Vector3& p) { return std::abs(p.x() - length / 2) < 1e-9; });
  auto& hub = graph.add<RigidBody>("hub", {.mass = 0.3, .inertia = {1e-4, 1e-4, 1e-4}});
  const Matrix3 along_x = axes_along(Vector3::UnitX());
  auto& bearing = graph.add<RevoluteJoint>("bearing", {graph.ground().marker({}, along_x), hub.marker({}, along_x)});
  graph.add<CoordinateDrive>("motor", {bearing.angle()}, {.motion = run_up(200, 0.25)});
  ElasticPart shaft = parts.add(graph, "shaft",
                                {.solid = solid,
                                 .frame = TangentFrame{solid->node_set("x0")},
                                 .eigenmodes = 8,
                                 .loaded = {seat, solid->node_set("x1")},
                                 .stiffness_damping = 2e-5,
                                 .position = {0, -side / 2, -side / 2}});
  hold(graph, "coupling", on(hub), shaft, shaft.ids("x0"));
  auto& far_bearing =
      graph.add<PointOnLineJoint>("far_bearing", {graph.ground().marker({}, along_x), shaft.average("x1")});
  // Half a millimetre out of balance.
  const Vector3 center(length / 2, 0.0005, 0);
  auto& disc = graph.add<RigidBody>("disc", {.mass = 1.5, .inertia = {3e-3, 1.6e-3, 1.6e-3}, .position = center});
  const Vector3 on_axis(length / 2, 0, 0);
  graph.add<FixedJoint>("shrink_fit", {shaft.average(seat), on(disc)(on_axis, Matrix3::Identity())});
  return {position(on(disc)(on_axis, Matrix3::Identity()), "disc"), multipliers(far_bearing, "bearing_force")};
}

}  // namespace

void add_structures(std::vector<Scene>& scenes) {
  const Vector3 weightless(0, 0, 0);
  scenes.push_back({.name = "struck_cantilever",
                    .shows = "a mass at the tip struck by a pulse: it bends by a tenth of its length",
                    .duration = 0.8,
                    .samples = 100,
                    .gravity = weightless,
                    .draw = struck});
  scenes.push_back({.name = "hammered_beam",
                    .shows = "a short blow at the middle: many modes",
                    .duration = 0.15,
                    .samples = 100,
                    .gravity = weightless,
                    .draw = hammered});
  scenes.push_back({.name = "neighbours",
                    .shows = "the same beside another beam, which nothing ties to it and nobody watches",
                    .duration = 0.15,
                    .samples = 100,
                    .gravity = weightless,
                    .draw = neighbours});
  scenes.push_back({.name = "bracket",
                    .shows = "tetrahedra of second order, 6354 degrees of freedom, swung by a drive and struck; its "
                             "reference is linear: 60 more modes",
                    .duration = 0.1,
                    .samples = 100,
                    .gravity = weightless,
                    .draw = bracket,
                    .linear_reference = true});
  scenes.push_back({.name = "pressed_column",
                    .shows = "a side force, then a load that grows to two thirds of buckling",
                    .duration = 1.2,
                    .samples = 100,
                    .gravity = weightless,
                    .draw = pressed});
  scenes.push_back({.name = "rotor",
                    .shows = "an elastic shaft with an unbalanced disc runs up below its critical speed",
                    .duration = 0.5,
                    .samples = 100,
                    .gravity = weightless,
                    .draw = rotor});
}

}  // namespace lithe::certify
