#include "bodies/integral_state.h"
#include "bodies/rigid_body.h"
#include "engine/model/motion_law.h"
#include "joints/contact/contact.h"
#include "joints/contact/shapes.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/bushing.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/coordinate_stop.h"
#include "joints/forces/first_order_states.h"
#include "joints/forces/joint_bristles.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/pid_controller.h"
#include "joints/forces/point_force.h"
#include "joints/forces/spring_damper.h"
#include "tools/differential/drawing.h"

namespace lithe::differential {
namespace {

/// One that acts on coordinates: of metres or radians, its sizes follow.
template <class Add>
void on_coordinate(Drawing& drawing, const char* kind, const DrawnCoordinate& x, Add&& add,
                   std::vector<int> more_needs = {}) {
  more_needs.push_back(x.element);
  const int element = drawing.add({.kind = kind, .needs = std::move(more_needs), .add = {}});
  drawing.scene.elements.back().add = [=, name = drawing.name(element)](SystemGraph& graph, double) {
    add(graph, name);
  };
}

void draw_spring(Drawing& drawing) {
  Dice& dice = drawing.dice;
  const Units& unit = drawing.scene.units;
  const Place A = drawing.any_place(), B = drawing.any_place();
  const double distance = (A.point - B.point).norm();
  if (A.element == B.element || distance < 0.1 * unit.length) return;
  const SpringDamper::Parameters parameters{.stiffness = unit.stiffness() * dice.magnitude(1, 50),
                                            .damping = dice.chance(0.5) ? 0 : unit.damping() * dice.number(0, 2),
                                            .natural_length = distance * dice.number(0.7, 1.3)};
  const int element = drawing.add({.kind = "spring", .needs = Drawing::bodies_of({&A, &B}), .add = {}});
  drawing.scene.elements.back().add = [=, name = drawing.name(element)](SystemGraph& graph, double) {
    graph.add<SpringDamper>(name, {A.marker(graph, Matrix3::Identity()), B.marker(graph, Matrix3::Identity())},
                            parameters);
  };
}

void draw_bushing(Drawing& drawing) {
  Dice& dice = drawing.dice;
  const Units& unit = drawing.scene.units;
  const std::vector<int> rigid = drawing.rigid_bodies();
  if (rigid.empty()) return;
  const DrawnBody& body = drawing.scene.bodies[static_cast<std::size_t>(dice.one_of(rigid))];
  const Place A = dice.one_of(drawing.ground), B = drawing.place_on(body, A.point);
  const Matrix3 axes = drawing.axes();
  Bushing::Parameters parameters;
  const double L = unit.length;
  Matrix6 root = Matrix6::Zero();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) root(i, j) = (i == j ? dice.number(1, 4) : dice.number(-0.3, 0.3)) * (i < 3 ? 1 : L);
  parameters.stiffness = unit.stiffness() * root * root.transpose();
  if (dice.chance(0.5)) parameters.damping = 0.1 * unit.time * parameters.stiffness;
  const int element = drawing.add({.kind = "bushing", .needs = {B.element}, .add = {}});
  drawing.scene.elements.back().add = [=, name = drawing.name(element)](SystemGraph& graph, double) {
    graph.add<Bushing>(name, {A.marker(graph, axes), B.marker(graph, axes)}, parameters);
  };
}

void draw_point_force(Drawing& drawing) {
  Dice& dice = drawing.dice;
  const DrawnBody body = dice.one_of(drawing.scene.bodies);
  const Place place = dice.one_of(body.places);
  PointForce::Parameters parameters;
  parameters.force = dice.vector(drawing.scene.units.force());
  if (body.axes) parameters.torque = dice.vector(drawing.scene.units.energy() * 0.3);
  if (body.axes && dice.chance(0.5)) parameters.axes = PointForce::Axes::marker;
  const int element = drawing.add({.kind = "point force", .needs = {place.element}, .add = {}});
  drawing.scene.elements.back().add = [=, name = drawing.name(element)](SystemGraph& graph, double) {
    graph.add<PointForce>(name, {place.marker(graph, Matrix3::Identity())}, parameters);
  };
}

void draw_friction(Drawing& drawing, const DrawnCoordinate& x, bool bristles) {
  Dice& dice = drawing.dice;
  const Units& unit = drawing.scene.units;
  const double coefficient = dice.number(0.05, 0.4), radius = 0.05 * unit.length;
  const double creep = 0.05 * unit.speed(), time = 1e-2 * unit.time;
  const auto joint = [element = drawing.name(x.element)](SystemGraph& graph) {
    return graph.find<Constraint>(element);
  };
  if (!bristles)
    return on_coordinate(drawing, "joint friction", x, [=](SystemGraph& graph, const std::string& name) {
      graph.add<JointFriction>(
          name, {x.of(graph)},
          {.joint = joint(graph), .coefficient = coefficient, .creep_speed = creep, .radius = radius});
    });
  const int states = drawing.add({.kind = "states", .add = {}});
  const std::string states_name = drawing.name(states);
  drawing.scene.elements.back().add = [=](SystemGraph& graph, double) {
    graph.add<FirstOrderStates>(states_name, {.start = JointBristles::start()});
  };
  on_coordinate(drawing, "joint bristles", x,
                [=](SystemGraph& graph, const std::string& name) {
                  add_joint_bristles(graph, name, {x.of(graph)}, *graph.find<FirstOrderStates>(states_name),
                                     {.joint = joint(graph),
                                      .coefficient = coefficient,
                                      .breakaway_deflection = 1e-3 * unit.length,
                                      .damping_time = time,
                                      .load_time = time,
                                      .radius = radius});
                },
                {states});
  drawing.scene.stiff = true;
}

void draw_controller(Drawing& drawing, const DrawnCoordinate& x) {
  const Units& unit = drawing.scene.units;
  const double size = x.angle ? unit.energy() : unit.stiffness(), rate = drawing.dice.number(-1, 1) / unit.time;
  const double start = x.value;
  const int state = drawing.add({.kind = "integral", .add = {}});
  const std::string state_name = drawing.name(state);
  drawing.scene.elements.back().add = [=](SystemGraph& graph, double) { graph.add<IntegralState>(state_name); };
  on_coordinate(drawing, "controller", x,
                [=](SystemGraph& graph, const std::string& name) {
                  graph.add<PidController>(name, {x.of(graph), graph.find<IntegralState>(state_name)->coordinate()},
                                           {.target = ramp(start, rate * (x.angle ? 1 : unit.length)),
                                            .proportional = 5 * size,
                                            .integral = size / unit.time,
                                            .derivative = size * unit.time});
                },
                {state});
}

}  // namespace

void draw_force(Drawing& drawing) {
  Dice& dice = drawing.dice;
  const Units unit = drawing.scene.units;
  if (drawing.coordinates.empty() || dice.chance(0.45)) {
    switch (dice.pick(3)) {
      case 0:
        return draw_spring(drawing);
      case 1:
        return draw_bushing(drawing);
      default:
        return draw_point_force(drawing);
    }
  }
  const DrawnCoordinate x = dice.one_of(drawing.coordinates);
  const double size = x.angle ? 1 : unit.length, torque = x.angle ? unit.energy() : unit.force();
  const double a = dice.magnitude(0.3, 30), b = dice.number(0, 1);
  switch (dice.pick(6)) {
    case 0:
      return on_coordinate(drawing, "coordinate spring", x, [=](SystemGraph& graph, const std::string& name) {
        graph.add<CoordinateSpring>(
            name, {x.of(graph)},
            {.stiffness = a * torque / size, .damping = b * torque / size * unit.time, .free_value = x.value});
      });
    case 1:
      return on_coordinate(drawing, "motor", x, [=](SystemGraph& graph, const std::string& name) {
        graph.add<CoordinateMotor>(name, {x.of(graph)}, {.effort = [=](double t, double, double rate) {
                                     return torque * (std::sin(3 * t / unit.time) - b * rate * unit.time / size);
                                   }});
      });
    case 2:
      return on_coordinate(drawing, "stop", x, [=](SystemGraph& graph, const std::string& name) {
        graph.add<CoordinateStop>(name, {x.of(graph)},
                                  {.lower = x.value - (0.1 + b) * size,
                                   .upper = x.value + (0.1 + b) * size,
                                   .stiffness = 100 * torque / std::pow(size, 1.5),
                                   .dissipation = 0.3 * unit.time / size});
      });
    case 3:
      return on_coordinate(drawing, "drive", x, [=](SystemGraph& graph, const std::string& name) {
        graph.add<CoordinateDrive>(name, {x.of(graph)},
                                   {.motion = harmonic(0.3 * size, (1 + b) / unit.time, 0, x.value)});
      });
    case 4:
      return draw_controller(drawing, x);
    default:
      if (x.rubs) draw_friction(drawing, x, dice.chance(0.3));
  }
}

void draw_contact(Drawing& drawing) {
  Dice& dice = drawing.dice;
  const Units& unit = drawing.scene.units;
  const double radius = unit.length * dice.number(0.1, 0.3);
  const bool boxes = dice.chance(0.3);
  std::vector<Place> held;
  std::vector<int> needs;
  double lowest = std::numeric_limits<double>::infinity();
  for (const int i : drawing.rigid_bodies()) {
    const Place place = dice.one_of(drawing.scene.bodies[static_cast<std::size_t>(i)].places);
    held.push_back(place), needs.push_back(place.element);
    lowest = std::min(lowest, place.point.z());
  }
  if (held.empty()) return;
  const Vector3 floor(0, 0, lowest - (boxes ? 1.8 : 1) * radius - dice.number(0.01, 0.5) * unit.length);
  const double exponent = dice.chance(0.5) ? 1 : 1.5, coefficient = dice.chance(0.3) ? 0 : dice.number(0.1, 0.6);
  Contact::Parameters parameters;
  parameters.friction = {.coefficient = coefficient, .creep_speed = 0.05 * unit.speed()};
  if (drawing.scene.impacts)
    parameters.law =
        RigidSurfaces{.restitution = dice.chance(0.4) ? 0 : dice.number(0, 0.8), .rest_speed = 1e-3 * unit.speed()};
  else
    parameters.law = Compliance{.stiffness = 300 * unit.force() / std::pow(unit.length, exponent),
                                .exponent = exponent,
                                .restitution = dice.number(0.2, 1),
                                .least_speed = 1e-2 * unit.speed()};
  const int element =
      drawing.add({.kind = drawing.scene.impacts ? "rigid contact" : "compliant contact", .needs = needs, .add = {}});
  drawing.scene.elements.back().add = [=, name = drawing.name(element)](SystemGraph& graph, double) {
    // The floor meets the bodies, which do not meet each other: they may be drawn within each other.
    std::vector<Collider> colliders{{graph.ground().marker(floor), shape::half_space(), 0, groups({1})}};
    for (const Place& place : held)
      colliders.push_back({place.marker(graph, Matrix3::Identity()),
                           boxes ? shape::box(Vector3::Constant(2 * radius)) : shape::sphere(radius), 1, groups({0})});
    graph.add<Contact>(name, colliders, parameters);
  };
}

}  // namespace lithe::differential
