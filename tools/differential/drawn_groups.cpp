#include <algorithm>

#include "bodies/rigid_body.h"
#include "joints/coordinate_coupling.h"
#include "joints/gear_pair.h"
#include "joints/prismatic_joint.h"
#include "joints/rack_and_pinion.h"
#include "joints/revolute_joint.h"
#include "joints/rolling_disc.h"
#include "tools/differential/drawing.h"

namespace lithe::differential {
namespace {

/// A rigid body on a hinge or a slide, along z of `axes`, at a place of the ground.
template <class Joint>
Place hold(Drawing& drawing, const char* kind, const Vector3& point, const Matrix3& axes) {
  const DrawnBody body = drawing.scene.bodies[static_cast<std::size_t>(draw_body(drawing, BodyKind::rigid, point))];
  const int element = drawing.add({.kind = kind, .needs = {body.element}, .add = {}});
  const std::string name = drawing.name(element);
  drawing.scene.elements.back().add = [=, place = body.places[0]](SystemGraph& graph, double) {
    graph.add<Joint>(name, {graph.ground().marker(point, axes), place.marker(graph, axes)});
  };
  drawing.scene.joints.push_back(name);
  return body.places[0];
}

void mesh(Drawing& drawing, const char* kind, const Place& a, const Place& b,
          const std::function<void(SystemGraph&, const std::string&, const std::vector<Marker>&)>& add,
          const Matrix3& axes) {
  const int element = drawing.add({.kind = kind, .needs = Drawing::bodies_of({&a, &b}), .add = {}});
  const std::string name = drawing.name(element);
  drawing.scene.elements.back().add = [=](SystemGraph& graph, double) {
    add(graph, name, {a.marker(graph, axes), b.marker(graph, axes)});
  };
  drawing.scene.joints.push_back(name);
}

void draw_gears(Drawing& drawing) {
  Dice& dice = drawing.dice;
  const double r_A = drawing.scene.units.length * dice.number(0.2, 1),
               r_B = drawing.scene.units.length * dice.number(0.2, 1);
  const Matrix3 axes = dice.rotation();
  const Vector3 point = drawing.shift(2);
  const Place A = hold<RevoluteJoint>(drawing, "revolute", point, axes),
              B = hold<RevoluteJoint>(drawing, "revolute", point + axes * Vector3(r_A + r_B, 0, 0), axes);
  mesh(
      drawing, "gear pair", A, B,
      [=](SystemGraph& graph, const std::string& name, const std::vector<Marker>& markers) {
        graph.add<GearPair>(name, markers, {.radius_A = r_A, .radius_B = r_B});
      },
      axes);
}

void draw_rack(Drawing& drawing) {
  Dice& dice = drawing.dice;
  const double radius = drawing.scene.units.length * dice.number(0.2, 1);
  const Matrix3 axes = dice.rotation(), along = axes * rotation_about({0, 1, 0}, M_PI / 2);
  const Vector3 point = drawing.shift(2);
  const Place pinion = hold<RevoluteJoint>(drawing, "revolute", point, axes),
              rack = hold<PrismaticJoint>(drawing, "prismatic", point - radius * axes.col(1), along);
  mesh(
      drawing, "rack and pinion", pinion, rack,
      [=](SystemGraph& graph, const std::string& name, const std::vector<Marker>& markers) {
        graph.add<RackAndPinion>(name, markers, {.radius = radius});
      },
      axes);
}

void draw_disc(Drawing& drawing) {
  Dice& dice = drawing.dice;
  const double radius = drawing.scene.units.length * dice.number(0.3, 1), lean = dice.number(0.9, 2.2),
               heading = dice.number(-3, 3);
  const Matrix3 plane = dice.rotation(),
                axle = plane * rotation_about({0, 0, 1}, heading) * rotation_about({1, 0, 0}, lean);
  const Vector3 foot = drawing.shift(2), center = foot + radius * std::sin(lean) * plane.col(2);
  const double mass = drawing.scene.units.mass * dice.magnitude(0.1, 10), across = mass * radius * radius / 4;
  const Units unit = drawing.scene.units;
  const Vector3 velocity = dice.vector(unit.speed()), disturbed = unit.speed() * dice.vector();
  const int element = drawing.add({.kind = "rigid body", .add = {}});
  const std::string name = drawing.name(element);
  drawing.scene.elements.back().add = [=](SystemGraph& graph, double nudge) {
    graph.add<RigidBody>(name, {.mass = mass,
                                .inertia = {across, across, 2 * across},
                                .position = center,
                                .orientation = axle,
                                .velocity = velocity + nudge * disturbed,
                                .angular_velocity = Vector3(0.2, 0.3, 2) / unit.time});
  };
  DrawnBody body{.element = element, .axes = true, .rigid = true};
  body.places = {drawing.place_on(body, center)};
  body.watched = [name, radius](SystemGraph& graph) {
    return graph.find<RigidBody>(name)->marker(Vector3(0.5 * radius, 0, 0.1 * radius));
  };
  drawing.scene.bodies.push_back(body);
  const int joint = drawing.add({.kind = "rolling disc", .needs = {element}, .add = {}});
  drawing.scene.elements.back().add = [=, joint_name = drawing.name(joint)](SystemGraph& graph, double) {
    graph.add<RollingDisc>(joint_name, {graph.ground().marker(foot, plane), graph.find<RigidBody>(name)->marker()},
                           {.radius = radius});
  };
  drawing.scene.joints.push_back(drawing.name(joint));
}

void draw_coupling(Drawing& drawing) {
  if (drawing.coordinates.size() < 2) return;
  Dice& dice = drawing.dice;
  const DrawnCoordinate a = dice.one_of(drawing.coordinates), b = dice.one_of(drawing.coordinates);
  if (a.element == b.element) return;
  const auto scale = [&](const DrawnCoordinate& x) { return x.angle ? 1 : 1 / drawing.scene.units.length; };
  const double ratio = dice.number(0.3, 3);
  const std::vector<double> factors = {scale(a), scale(b) * (dice.chance(0.5) ? ratio : -ratio)};
  const int element = drawing.add({.kind = "coupling", .needs = {a.element, b.element}, .add = {}});
  drawing.scene.elements.back().add = [=, name = drawing.name(element)](SystemGraph& graph, double) {
    graph.add<CoordinateCoupling>(name, {a.of(graph), b.of(graph)}, {.factors = factors});
  };
}

}  // namespace

void draw_group(Drawing& drawing) {
  switch (drawing.dice.pick(4)) {
    case 0:
      return draw_gears(drawing);
    case 1:
      return draw_rack(drawing);
    case 2:
      return draw_disc(drawing);
    default:
      return draw_coupling(drawing);
  }
}

}  // namespace lithe::differential
