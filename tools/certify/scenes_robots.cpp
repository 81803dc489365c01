// What drives turn: arms, booms, hubs. Elastic parts are clamped to rigid hubs.

#include "bodies/shapes.h"
#include "engine/assembly/batch_of.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/user_force.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tools/certify/scenes.h"

namespace lithe::certify {
namespace {

/// A bar clamped at its root, its other end an interface; `place`: of the middle of its root.
ElasticPartParameters clamped(const SolidModel& solid, const Vector3& place, double damping, int eigenmodes = 8) {
  const Vector3 size = solid->nodes.rowwise().maxCoeff();
  return {.solid = solid,
          .frame = TangentFrame{solid->node_set("x0")},
          .eigenmodes = eigenmodes,
          .loaded = {solid->node_set("x1")},
          .stiffness_damping = damping,
          .position = place - Vector3(0, size.y() / 2, size.z() / 2)};
}

/// A rigid hub that a drive turns about an axis through its centre.
struct Hub {
  RigidBody& body;
  CoordinateDrive& drive;
};
Hub driven_hub(SystemGraph& graph, const std::string& name, const Places& base, const Vector3& place,
               const Vector3& axis, MotionLaw motion) {
  auto& body = graph.add<RigidBody>(name, {.mass = 0.5, .inertia = {1e-3, 1e-3, 1e-3}, .position = place});
  const Matrix3 axes = axes_along(axis);
  auto& hinge = graph.add<RevoluteJoint>(name + "_hinge", {base(place, axes), body.marker({}, axes)});
  return {body, graph.add<CoordinateDrive>(name + "_drive", {hinge.angle()}, {.motion = std::move(motion)})};
}

/// Kane, Ryan & Banerjee 1987: a beam on a hub that is brought to speed.
std::vector<Sensor> spin_up(SystemGraph& graph, ElasticParts& parts, double speed, double run_up_time) {
  Hub hub = driven_hub(graph, "hub", on(graph.ground()), {0, 0, 0}, {0, 0, 1}, run_up(speed, run_up_time));
  const SolidModel solid = bar({0.8, 0.004, 0.03}, {16, 1, 1}, {7e10, 0.33, 2700});
  ElasticPart beam = parts.add(graph, "beam", clamped(solid, {0.05, 0, 0}, 3e-4));
  hold(graph, "root", on(hub.body), beam, beam.ids("x0"));
  return {relative_position(beam.average("x1"), hub.body.marker(), "tip")};
}

/// Two links in a horizontal plane (no weight on the drives), driven at shoulder and elbow; a mass at the end.
std::vector<Sensor> robot(SystemGraph& graph, ElasticParts& parts, double young, double damping, bool both) {
  const double length = 0.5;
  Hub shoulder = driven_hub(graph, "shoulder", on(graph.ground()), {0, 0, 0}, {0, 0, 1}, smooth_step(0, 1, 0, 0.6));
  const Vector3 elbow_place(length, 0, 0), hand_place(2 * length, 0, 0);
  Places upper_end = on(shoulder.body);
  if (both) {
    const SolidModel solid = bar({length, 0.04, 0.03}, {10, 1, 1}, {young, 0.3, 2700});
    ElasticPart upper = parts.add(graph, "upper", clamped(solid, {0, 0, 0}, damping));
    hold(graph, "upper_root", on(shoulder.body), upper, upper.ids("x0"));
    auto& motor = graph.add<RigidBody>("motor", {.mass = 0.5, .inertia = {1e-3, 1e-3, 1e-3}, .position = elbow_place});
    graph.add<FixedJoint>("upper_end", {upper.average("x1"), motor.marker()});
    upper_end = on(motor);
  } else {
    const MassProperties shape = box({length, 0.04, 0.03}, 2700);
    auto& upper =
        graph.add<RigidBody>("upper", {.mass = shape.mass, .inertia = shape.inertia, .position = {length / 2, 0, 0}});
    graph.add<FixedJoint>("upper_root", {shoulder.body.marker(), on(upper)(Vector3::Zero(), Matrix3::Identity())});
    upper_end = on(upper);
  }
  Hub elbow = driven_hub(graph, "elbow", upper_end, elbow_place, {0, 0, 1}, smooth_step(0, -1.2, 0.1, 0.8));
  const SolidModel solid = bar({length, 0.02, 0.03}, {10, 1, 1}, {young, 0.3, 2700});
  ElasticPart fore = parts.add(graph, "fore", clamped(solid, elbow_place, damping));
  hold(graph, "fore_root", on(elbow.body), fore, fore.ids("x0"));
  auto& load = graph.add<RigidBody>("load", {.mass = 0.5, .inertia = {5e-4, 5e-4, 5e-4}, .position = hand_place});
  graph.add<FixedJoint>("grip", {fore.average("x1"), load.marker()});
  return {position(load.marker(), "load"), multipliers(shoulder.drive, "shoulder")};
}

std::vector<Sensor> satellite(SystemGraph& graph, ElasticParts& parts) {
  auto& hub = graph.add<RigidBody>("hub", {.mass = 10, .inertia = {0.3, 0.3, 0.3}});
  const SolidModel solid = bar({1, 0.3, 0.01}, {8, 2, 1}, {1e9, 0.3, 1000});
  ElasticPartParameters right = clamped(solid, {0.2, 0, 0}, 2e-3, 10), left = right;
  left.orientation = rotation_about({0, 0, 1}, M_PI);
  left.position = left.orientation * right.position;
  ElasticPart one = parts.add(graph, "right", right), two = parts.add(graph, "left", left);
  hold(graph, "right_root", on(hub), one, one.ids("x0"));
  hold(graph, "left_root", on(hub), two, two.ids("x0"));
  graph.add<UserForce>("wheel", {hub.marker()},
                       {[](double t, const MarkerView&) { return torque(Vector3(0.02, 1, 0.2) * pulse(t, 0, 0.4)); }});
  return {position(one.average("x1"), "panel"), pointing(hub.marker(), "hub")};
}

std::vector<Sensor> crane(SystemGraph& graph, ElasticParts& parts) {
  Hub column = driven_hub(graph, "column", on(graph.ground()), {0, 0, 0}, {0, 0, 1}, smooth_step(0, 1, 0, 1));
  const SolidModel solid = bar({2, 0.03, 0.05}, {12, 1, 1}, {2.1e11, 0.3, 7800});
  ElasticPart boom = parts.add(graph, "boom", clamped(solid, {0.1, 0, 0}, 1e-3));
  hold(graph, "root", on(column.body), boom, boom.ids("x0"));
  const Vector3 end(2.1, 0, 0);
  auto& load = graph.add<RigidBody>("load", {.mass = 30, .inertia = {0.5, 0.5, 0.5}, .position = {2.1, 0, -0.8}});
  graph.add<SphericalJoint>("hook", {boom.average("x1"), on(load)(end, Matrix3::Identity())});
  return {position(load.marker(), "load"), height(boom.average("x1"), "boom")};
}

}  // namespace

void add_robots(std::vector<Scene>& scenes) {
  const Vector3 weightless(0, 0, 0);
  scenes.push_back({.name = "spin_up_slow",
                    .shows = "a beam brought to a tenth of its frequency: linear serves",
                    .duration = 3,
                    .samples = 100,
                    .gravity = weightless,
                    .draw = [](SystemGraph& graph, ElasticParts& parts) { return spin_up(graph, parts, 3, 1); }});
  scenes.push_back({.name = "spin_up_fast",
                    .shows = "the same to beyond its frequency: without stiffening it bends away",
                    .duration = 2.4,
                    .samples = 100,
                    .gravity = weightless,
                    .draw = [](SystemGraph& graph, ElasticParts& parts) { return spin_up(graph, parts, 36, 1.5); }});
  scenes.push_back(
      {.name = "robot_soft",
       .shows = "two driven joints, the second link soft, a mass at the end",
       .duration = 1.5,
       .samples = 100,
       .gravity = weightless,
       .draw = [](SystemGraph& graph, ElasticParts& parts) { return robot(graph, parts, 2e9, 5e-4, false); }});
  scenes.push_back(
      {.name = "robot_stiff",
       .shows = "links of aluminium: rigid serves for the load, not for the moment of the drive",
       .duration = 1,
       .samples = 100,
       .gravity = weightless,
       .draw = [](SystemGraph& graph, ElasticParts& parts) { return robot(graph, parts, 7e10, 1e-4, true); }});
  scenes.push_back({.name = "satellite",
                    .shows = "a free hub with two panels, turned by a pulse",
                    .duration = 6,
                    .samples = 100,
                    .gravity = weightless,
                    .draw = satellite});
  scenes.push_back(
      {.name = "crane", .shows = "a boom slews with a hanging load", .duration = 3, .samples = 100, .draw = crane});
}

}  // namespace lithe::certify
