#include <map>

#include "bodies/beam/beam.h"
#include "bodies/cable/cable.h"
#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/reduction.h"
#include "bodies/point_mass.h"
#include "bodies/rigid_body.h"
#include "tools/differential/drawing.h"

namespace lithe::differential {
namespace {

/// Markers of rigid bodies, at any point.
auto rigid_marker(std::string name, Vector3 point) {
  return [name, point](SystemGraph& graph, const Matrix3& axes) {
    return graph.find<RigidBody>(name)->marker_at_world(point, axes);
  };
}

/// By which a disturbance turns a body that it also shifts. A shift alone leaves a free body's turn and deformation as
/// they were, however sensitive these are.
Vector3 turn_with(const Vector3& shift, const Units& units) {
  return Vector3(shift.y(), -shift.z(), shift.x()) / units.length;
}

int keep(Drawing& drawing, DrawnBody body) {
  drawing.scene.bodies.push_back(std::move(body));
  return static_cast<int>(drawing.scene.bodies.size()) - 1;
}

int draw_rigid(Drawing& drawing, const Vector3& point) {
  Dice& dice = drawing.dice;
  const Units& unit = drawing.scene.units;
  const double L = unit.length, mass = unit.mass * dice.magnitude(0.1, 10);
  const Matrix3 A = drawing.axes(), principal = drawing.planar ? Matrix3(Matrix3::Identity()) : dice.rotation();
  const Vector3 edges = L * Vector3{dice.number(0.2, 1.5), dice.number(0.2, 1), dice.number(0.2, 1)},
                squares = edges.cwiseAbs2();
  const Vector3 moments = mass / 12 * (Vector3::Constant(squares.sum()) - squares);
  const Vector3 center = point + drawing.shift(0.7);
  const RigidBody::Parameters parameters{.mass = mass,
                                         .inertia = Matrix3(principal * moments.asDiagonal() * principal.transpose()),
                                         .position = center,
                                         .orientation = A,
                                         .velocity = drawing.velocity(center, drawing.planar ? 0 : 0.3),
                                         .angular_velocity = A.transpose() * drawing.spin};
  const Vector3 disturbed = unit.speed() * dice.vector();
  const int element = drawing.add({.kind = "rigid body", .add = {}});
  const std::string name = drawing.name(element);
  drawing.scene.elements.back().add = [=, units = unit](SystemGraph& graph, double nudge) {
    RigidBody::Parameters p = parameters;
    p.velocity += nudge * disturbed;
    p.angular_velocity += nudge * turn_with(disturbed, units);
    graph.add<RigidBody>(name, p);
  };
  DrawnBody body{.element = element, .axes = true, .rigid = true};
  for (const Vector3& at : {point, Vector3(center + drawing.shift(0.7)), Vector3(center + drawing.shift(0.7))})
    body.places.push_back({element, at, rigid_marker(name, at)});
  body.watched = [name, L](SystemGraph& graph) {
    return graph.find<RigidBody>(name)->marker(Vector3(0.3, 0.2, 0.1) * L);
  };
  return keep(drawing, std::move(body));
}

int draw_point(Drawing& drawing, const Vector3& point) {
  const PointMass::Parameters parameters{.mass = drawing.scene.units.mass * drawing.dice.magnitude(0.1, 10),
                                         .position = point,
                                         .velocity = drawing.velocity(point, drawing.planar ? 0 : 0.3)};
  const Vector3 disturbed = drawing.scene.units.speed() * drawing.dice.vector();
  const int element = drawing.add({.kind = "point mass", .add = {}});
  const std::string name = drawing.name(element);
  drawing.scene.elements.back().add = [=](SystemGraph& graph, double nudge) {
    PointMass::Parameters p = parameters;
    p.velocity += nudge * disturbed;
    graph.add<PointMass>(name, p);
  };
  const auto marker = [name](SystemGraph& graph, const Matrix3& axes) {
    return graph.find<PointMass>(name)->marker(axes);
  };
  DrawnBody body{.element = element, .axes = false, .rigid = false};
  body.places = {{element, point, marker}};
  body.watched = [marker](SystemGraph& graph) { return marker(graph, Matrix3::Identity()); };
  return keep(drawing, std::move(body));
}

/// Elastic bars are of `length` by a tenth of it; their lowest mode has `stiffness` / time.
Material bar_material(const Drawing& drawing, double length, double mass, double stiffness) {
  const double density = mass / (length * 0.01 * length * length);  // ω = 22.4 / L² √(EI / μ), I / A = L² / 1200
  const double omega = stiffness / drawing.scene.units.time, speed = omega * length / 0.647;
  return {speed * speed * density, 0.3, density};
}

enum class Reduced { mean_axis, three_node, tangent, mean_tangent, hinge, quadratic, stiffened, nodal, count };
constexpr const char* kReducedNames[] = {"mean-axis", "three-node",        "tangent",           "mean-tangent",
                                         "hinge",     "quadratic tangent", "stiffened tangent", "nodal"};

struct Bar {
  std::shared_ptr<const ModalBasis> basis;
  std::vector<int> near_end, far_end;  // labels of the nodes of the end faces
};

Bar make_bar(const Material& material, double length, Reduced kind, int modes) {
  const FiniteElementModel model = brick_mesh({.size = {length, 0.1 * length, 0.1 * length},
                                               .divisions = {3, 1, 1},
                                               .type = "C3D8I",
                                               .material = material,
                                               .name = "bar"});
  Bar bar;
  for (Eigen::Index i = 0; i < model.nodes.cols(); ++i) {
    const int label = model.node_ids.begin()[i];
    if (model.nodes(0, i) < 1e-6 * length) bar.near_end.push_back(label);
    if (model.nodes(0, i) > (1 - 1e-6) * length) bar.far_end.push_back(label);
  }
  const std::vector<int>& held = bar.near_end;
  const Deflection deflection = kind == Reduced::quadratic   ? Deflection::quadratic
                                : kind == Reduced::stiffened ? Deflection::stiffened
                                                             : Deflection::linear;
  BodyFrame frame = TangentFrame{held};
  if (kind == Reduced::mean_axis) frame = MeanAxisFrame{};
  if (kind == Reduced::three_node || kind == Reduced::nodal) frame = ThreeNodeFrame{held[0], held[1], held[2]};
  if (kind == Reduced::mean_tangent) frame = MeanTangentFrame{{held}};
  if (kind == Reduced::hinge) frame = HingeFrame{{held[0], held[1]}};
  bar.basis = make_basis(model, frame, kind == Reduced::nodal ? kAllNodal : modes, {.deflection = deflection});
  return bar;
}

int draw_flexible(Drawing& drawing, const Vector3& point) {
  Dice& dice = drawing.dice;
  const Units& unit = drawing.scene.units;
  auto kind = static_cast<Reduced>(dice.pick(static_cast<int>(Reduced::count)));
  // Of all nodes also those modes vibrate that cost a scene seconds: of one seed in four alone, and damped.
  if (kind == Reduced::nodal && drawing.scene.seed % 4 != 0) kind = Reduced::tangent;
  const double length = unit.length * dice.number(0.7, 1.5), mass = unit.mass * dice.magnitude(0.2, 5);
  const Matrix3 A = dice.rotation();
  const Material material = bar_material(drawing, length, mass, dice.magnitude(8, 40));
  const Bar bar = make_bar(material, length, kind, 2 + dice.pick(4));
  const Vector3 near_middle(0, 0.05 * length, 0.05 * length), far_middle = near_middle + Vector3(length, 0, 0);
  const Vector3 first = dice.chance(0.5) ? near_middle : far_middle, origin = point - A * first;
  const bool undamped = dice.chance(0.5) && kind != Reduced::nodal;
  const FlexibleBody::Parameters parameters{.basis = bar.basis,
                                            .damping = {.stiffness_proportional = undamped ? 0 : 1e-3 * unit.time},
                                            .position = origin,
                                            .orientation = A,
                                            .velocity = drawing.velocity(origin, 0.1),
                                            .angular_velocity = A.transpose() * drawing.spin};
  const Vector3 disturbed = unit.speed() * dice.vector();
  const int element = drawing.add({.kind = std::string(kReducedNames[static_cast<int>(kind)]) + " body", .add = {}});
  const std::string name = drawing.name(element);
  drawing.scene.elements.back().add = [=, units = unit](SystemGraph& graph, double nudge) {
    FlexibleBody::Parameters p = parameters;
    p.velocity += nudge * disturbed;
    p.angular_velocity += nudge * turn_with(disturbed, units);
    graph.add<FlexibleBody>(name, p);
  };
  const auto mean = [name, A](std::vector<int> ids) {
    return [=](SystemGraph& graph, const Matrix3& axes) {
      return graph.find<FlexibleBody>(name)->average(ids, A.transpose() * axes);
    };
  };
  DrawnBody body{.element = element, .axes = true, .rigid = false};
  body.places = {{element, origin + A * near_middle, mean(bar.near_end)},
                 {element, origin + A * far_middle, mean(bar.far_end)}};
  if (first == far_middle) std::swap(body.places[0], body.places[1]);
  body.watched = [watch = mean(bar.far_end)](SystemGraph& graph) { return watch(graph, Matrix3::Identity()); };
  // Nodes that the frame holds: of others the modes would strain the triangle by a little, and be locked by it.
  const bool held = kind == Reduced::tangent || kind == Reduced::quadratic || kind == Reduced::stiffened;
  for (std::size_t i = 0; held && first == near_middle && i < 3; ++i)
    body.nodes.push_back(
        [name, id = bar.near_end[i]](SystemGraph& graph) { return graph.find<FlexibleBody>(name)->node(id); });
  drawing.scene.stiff = true;
  return keep(drawing, std::move(body));
}

int draw_beam(Drawing& drawing, const Vector3& point) {
  Dice& dice = drawing.dice;
  const Units& unit = drawing.scene.units;
  const double length = unit.length * dice.number(0.8, 2), mass = unit.mass * dice.magnitude(0.2, 5);
  const Matrix3 A = dice.rotation();
  const BeamSection section =
      BeamSection::rectangle(0.1 * length, 0.1 * length, bar_material(drawing, length, mass, dice.magnitude(5, 30)))
          .damped(dice.chance(0.5) ? 0 : 1e-3 * unit.time);
  const double arc = length * (dice.chance(0.3) ? 0.4 : dice.pick(2));
  const Vector3 start = point - arc * A.col(0);
  const Beam::Parameters parameters{.axis = BeamAxis::straight(start, start + length * A.col(0), A.col(1)),
                                    .sections = {{0, section}},
                                    .elements = 2 + dice.pick(2),
                                    .mass = dice.chance(0.5) ? Beam::Mass::lumped : Beam::Mass::consistent,
                                    .velocity = drawing.velocity(start, 0.1),
                                    .angular_velocity = drawing.spin};
  const Vector3 disturbed = unit.speed() * dice.vector();
  const int element = drawing.add({.kind = "beam", .add = {}});
  const std::string name = drawing.name(element);
  drawing.scene.elements.back().add = [=, units = unit](SystemGraph& graph, double nudge) {
    Beam::Parameters p = parameters;
    p.velocity += nudge * disturbed;
    p.angular_velocity += nudge * turn_with(disturbed, units);
    graph.add<Beam>(name, p);
  };
  const auto at = [=](double s) {
    return Place{element, start + s * A.col(0), [=](SystemGraph& graph, const Matrix3& axes) {
                   return graph.find<Beam>(name)->marker(s, {}, A.transpose() * axes);
                 }};
  };
  DrawnBody body{.element = element, .axes = true, .rigid = false};
  body.places = {at(arc), at(0), at(length), at(0.6 * length)};
  body.watched = [=](SystemGraph& graph) { return graph.find<Beam>(name)->marker(0.9 * length); };
  drawing.scene.stiff = true;
  return keep(drawing, std::move(body));
}

int draw_cable(Drawing& drawing, const Vector3& point) {
  Dice& dice = drawing.dice;
  const Units& unit = drawing.scene.units;
  const double length = unit.length * dice.number(0.8, 2);
  const Vector3 along = dice.rotation().col(0);
  const Cable::Parameters parameters{.from = point,
                                     .to = point + length * along,
                                     .elements = 3 + dice.pick(3),
                                     .mass_per_length = unit.mass * dice.magnitude(0.1, 1) / length,
                                     .axial_stiffness = unit.force() * dice.magnitude(30, 1000),
                                     .bending_stiffness = dice.chance(0.5) ? 0.05 * unit.energy() * unit.length : 0,
                                     .axial_damping = dice.chance(0.5) ? 0 : unit.force() * unit.time,
                                     .velocity = drawing.velocity(point, 0.1)};
  const Vector3 disturbed = unit.speed() * dice.vector();
  const int element = drawing.add({.kind = "cable", .add = {}});
  const std::string name = drawing.name(element);
  drawing.scene.elements.back().add = [=](SystemGraph& graph, double nudge) {
    Cable::Parameters p = parameters;
    p.velocity += nudge * disturbed;
    graph.add<Cable>(name, p);
  };
  const auto at = [=](double share) {
    return Place{element, point + share * length * along, [=](SystemGraph& graph, const Matrix3& axes) {
                   auto& cable = *graph.find<Cable>(name);
                   return cable.marker(share * cable.length(), axes);
                 }};
  };
  DrawnBody body{.element = element, .axes = false, .rigid = false};
  body.places = {at(0), at(1)};
  body.watched = [watch = at(1).marker](SystemGraph& graph) { return watch(graph, Matrix3::Identity()); };
  drawing.scene.stiff = true;
  return keep(drawing, std::move(body));
}

}  // namespace

Place Drawing::place_on(const DrawnBody& body, const Vector3& point) const {
  return {body.element, point, rigid_marker(name(body.element), point)};
}

int draw_body(Drawing& drawing, BodyKind kind, const Vector3& point) {
  switch (kind) {
    case BodyKind::point:
      return draw_point(drawing, point);
    case BodyKind::flexible:
      return draw_flexible(drawing, point);
    case BodyKind::beam:
      return draw_beam(drawing, point);
    case BodyKind::cable:
      return draw_cable(drawing, point);
    default:
      return draw_rigid(drawing, point);
  }
}

}  // namespace lithe::differential
