#include "joints/constant_velocity_joint.h"
#include "joints/cylindrical_joint.h"
#include "joints/distance_joint.h"
#include "joints/fixed_joint.h"
#include "joints/forces/bushing.h"
#include "joints/orientation_joint.h"
#include "joints/parallel_axes_joint.h"
#include "joints/perpendicular_axes_joint.h"
#include "joints/planar_joint.h"
#include "joints/planar_pin_joint.h"
#include "joints/point_on_line_joint.h"
#include "joints/point_on_plane_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/revolute_spherical_joint.h"
#include "joints/screw_joint.h"
#include "joints/spherical_joint.h"
#include "joints/three_node_fixation.h"
#include "joints/universal_joint.h"
#include "tools/differential/drawing.h"

namespace lithe::differential {
namespace {

/// Marker B seen from marker A.
struct Offset {
  Vector3 position = Vector3::Zero();
  Matrix3 turn = Matrix3::Identity();
};
struct Free {  // what a joint leaves free, as drawn
  double angle = 0, displacement = 0;
};

struct JointKind {
  const char* name;
  bool axes_A, axes_B;  // it holds directions of that body
  double weight;
  Offset (*offset)(Dice&, double size, Free&);
  void (*add)(SystemGraph&, const std::string&, const std::vector<Marker>&, double size, const Units&);
  std::vector<DrawnCoordinate> (*coordinates)(const std::string& joint, const Free&);
  bool planar = false;  // may hold the bodies of a planar scene
};

Matrix3 about_z(double angle) { return rotation_about({0, 0, 1}, angle); }
Vector3 along_z(double s) { return {0, 0, s}; }

Offset none(Dice&, double, Free&) { return {}; }
Offset turned(Dice& dice, double, Free&) { return {.turn = dice.rotation()}; }
Offset hinged(Dice& dice, double, Free& free) {
  free.angle = dice.number(-2.5, 2.5);
  return {.turn = about_z(free.angle)};
}
Offset slid(Dice& dice, double size, Free& free) {
  free.displacement = dice.number(-1, 1) * size;
  return {.position = along_z(free.displacement)};
}
Offset slid_and_hinged(Dice& dice, double size, Free& free) {
  return {.position = slid(dice, size, free).position, .turn = hinged(dice, size, free).turn};
}
Offset in_plane(Dice& dice, double size, Free& free) {
  const Vector3 d = dice.vector(size);
  return {.position = {d.x(), d.y(), 0}, .turn = hinged(dice, size, free).turn};
}
Offset apart(Dice& dice, double size, Free& free) {
  return {.position = dice.vector(size) + Vector3(size, 0, 0), .turn = hinged(dice, size, free).turn};
}

std::vector<DrawnCoordinate> no_coordinates(const std::string&, const Free&) { return {}; }
template <class T>
std::vector<DrawnCoordinate> angle_of(const std::string& joint, const Free& free) {
  return {{-1, [joint](SystemGraph& graph) { return graph.find<T>(joint)->angle(); }, true,
           std::is_same_v<T, RevoluteJoint>, free.angle}};
}
template <class T>
std::vector<DrawnCoordinate> displacement_of(const std::string& joint, const Free& free) {
  return {{-1, [joint](SystemGraph& graph) { return graph.find<T>(joint)->displacement(); }, false,
           std::is_same_v<T, PrismaticJoint>, free.displacement}};
}
template <class T>
std::vector<DrawnCoordinate> both_of(const std::string& joint, const Free& free) {
  auto out = angle_of<T>(joint, free);
  out.push_back(displacement_of<T>(joint, free).front());
  return out;
}
template <class T>
void add(SystemGraph& graph, const std::string& name, const std::vector<Marker>& markers, double, const Units&) {
  graph.add<T>(name, markers);
}

/// With a rotational spring, which keeps the bend within the joint's limit of a right angle.
template <class T>
void add_sprung(SystemGraph& graph, const std::string& name, const std::vector<Marker>& markers, double,
                const Units& units) {
  graph.add<T>(name, markers);
  Bushing::Parameters spring;
  spring.stiffness.diagonal().tail<3>().setConstant(60 * units.energy());
  spring.damping = 0.1 * units.time * spring.stiffness;
  graph.add<Bushing>(name + " spring", markers, spring);
}

const std::vector<JointKind>& kinds() {
  static const std::vector<JointKind> all = {
      {"revolute", true, true, 6, hinged, add<RevoluteJoint>, angle_of<RevoluteJoint>, true},
      {"spherical", false, false, 4, turned, add<SphericalJoint>, no_coordinates},
      {"fixed", true, true, 2, none, add<FixedJoint>, no_coordinates, true},
      {"prismatic", true, true, 2, slid, add<PrismaticJoint>, displacement_of<PrismaticJoint>, true},
      {"cylindrical", true, true, 2, slid_and_hinged, add<CylindricalJoint>, both_of<CylindricalJoint>},
      {"universal", true, true, 2,
       [](Dice& dice, double, Free&) {
         const double about_x = dice.number(-1, 1), about_y = dice.number(-1, 1);
         return Offset{.turn = rotation_about({1, 0, 0}, about_x) * rotation_about({0, 1, 0}, about_y)};
       },
       add<UniversalJoint>, no_coordinates},
      {"constant-velocity", true, true, 1,
       [](Dice& dice, double, Free&) {
         return Offset{.turn = rotation_exp(Vector3{dice.number(-0.6, 0.6), dice.number(-0.6, 0.6), 0})};
       },
       add_sprung<ConstantVelocityJoint>, no_coordinates},
      {"screw", true, true, 1, slid_and_hinged,
       [](SystemGraph& graph, const std::string& name, const std::vector<Marker>& markers, double size, const Units&) {
         graph.add<ScrewJoint>(name, markers, {.lead = size});
       },
       both_of<ScrewJoint>},
      {"planar", true, true, 1, in_plane, add<PlanarJoint>, angle_of<PlanarJoint>, true},
      {"planar pin", true, true, 0.5, slid_and_hinged, add<PlanarPinJoint>, angle_of<PlanarPinJoint>},
      {"point-on-line", true, false, 1,
       [](Dice& dice, double size, Free& free) {
         return Offset{.position = slid(dice, size, free).position, .turn = dice.rotation()};
       },
       add<PointOnLineJoint>, displacement_of<PointOnLineJoint>},
      {"point-on-plane", true, false, 1,
       [](Dice& dice, double size, Free& free) {
         return Offset{.position = in_plane(dice, size, free).position, .turn = dice.rotation()};
       },
       add<PointOnPlaneJoint>, no_coordinates},
      {"parallel-axes", true, true, 0.5, apart, add<ParallelAxesJoint>, angle_of<ParallelAxesJoint>},
      {"perpendicular-axes", true, true, 0.5,
       [](Dice& dice, double size, Free&) {
         return Offset{.position = dice.vector(size),
                       .turn = about_z(dice.number(-3, 3)) * rotation_about({1, 0, 0}, M_PI / 2)};
       },
       add<PerpendicularAxesJoint>, no_coordinates},
      {"orientation", true, true, 0.5,
       [](Dice& dice, double size, Free&) { return Offset{.position = dice.vector(size)}; }, add<OrientationJoint>,
       no_coordinates},
      {"revolute-spherical", true, false, 1,
       [](Dice& dice, double size, Free&) {
         return Offset{.position = about_z(dice.number(-3, 3)) * Vector3(size, 0, 0), .turn = dice.rotation()};
       },
       add<RevoluteSphericalJoint>, no_coordinates},
      {"distance", false, false, 1.5, apart, add<DistanceJoint>, no_coordinates},
  };
  return all;
}

const JointKind& pick_kind(Drawing& drawing, bool axes_A, bool axes_B) {
  const auto fits = [&](const JointKind& kind) {
    return (axes_A || !kind.axes_A) && (axes_B || !kind.axes_B) && (kind.planar || !drawing.planar);
  };
  double sum = 0;
  for (const JointKind& kind : kinds()) sum += fits(kind) ? kind.weight : 0;
  double left = drawing.dice.number(0, sum);
  const JointKind* last = nullptr;
  for (const JointKind& kind : kinds())
    if (fits(kind)) {
      last = &kind;
      if ((left -= kind.weight) < 0) break;
    }
  return *last;
}

/// The joint's element; A and B have markers with these axes of the world.
void tie(Drawing& drawing, const JointKind& kind, const Place& A, const Matrix3& axes_A, const Place& B,
         const Matrix3& axes_B, const Free& free, double size) {
  const int element = drawing.add({.kind = kind.name, .needs = Drawing::bodies_of({&A, &B}), .add = {}});
  const std::string name = drawing.name(element);
  drawing.scene.elements.back().add = [=, add_joint = kind.add, units = drawing.scene.units](SystemGraph& graph,
                                                                                             double) {
    add_joint(graph, name, {A.marker(graph, axes_A), B.marker(graph, axes_B)}, size, units);
  };
  drawing.scene.joints.push_back(name);
  for (DrawnCoordinate& coordinate : kind.coordinates(name, free)) {
    coordinate.element = element;
    drawing.coordinates.push_back(std::move(coordinate));
  }
}

/// Of a planar scene a prismatic joint slides within the plane.
Matrix3 joint_axes(Drawing& drawing, const JointKind& kind) {
  const Matrix3 axes = drawing.axes();
  return drawing.planar && std::string(kind.name) == "prismatic" ? Matrix3(axes * rotation_about({0, 1, 0}, M_PI / 2))
                                                                 : axes;
}

}  // namespace

void grow(Drawing& drawing, BodyKind kind, const Place& parent, bool parent_axes) {
  Dice& dice = drawing.dice;
  const bool axes = kind != BodyKind::point && kind != BodyKind::cable;
  const double size = drawing.scene.units.length * dice.number(0.2, 1);
  if (kind == BodyKind::flexible && parent_axes && dice.chance(0.2)) {
    const DrawnBody body = drawing.scene.bodies[static_cast<std::size_t>(draw_body(drawing, kind, parent.point))];
    if (body.nodes.empty()) return;  // it stays free
    const Place& place = body.places.front();
    const int element =
        drawing.add({.kind = "three-node fixation", .needs = Drawing::bodies_of({&parent, &place}), .add = {}});
    drawing.scene.elements.back().add = [parent, nodes = body.nodes, name = drawing.name(element)](SystemGraph& graph,
                                                                                                   double) {
      std::vector<Marker> markers{parent.marker(graph, Matrix3::Identity())};
      for (const auto& node : nodes) markers.push_back(node(graph));
      graph.add<ThreeNodeFixation>(name, markers);
    };
    return;
  }
  const JointKind& joint = pick_kind(drawing, parent_axes, axes);
  Free free;
  const Matrix3 axes_A = joint_axes(drawing, joint);
  const Offset offset = joint.offset(dice, size, free);
  const int body = draw_body(drawing, kind, parent.point + axes_A * offset.position);
  tie(drawing, joint, parent, axes_A, drawing.scene.bodies[static_cast<std::size_t>(body)].places.front(),
      axes_A * offset.turn, free, size);
}

void close_loop(Drawing& drawing) {
  Dice& dice = drawing.dice;
  const std::vector<int> rigid = drawing.rigid_bodies();
  if (rigid.size() < 2) return;
  const int a = dice.one_of(rigid), b = dice.one_of(rigid);
  if (a == b) return;
  const JointKind& joint = pick_kind(drawing, true, true);
  const double size = drawing.scene.units.length * dice.number(0.2, 1);
  Free free;
  const Matrix3 axes_A = joint_axes(drawing, joint);
  const Offset offset = joint.offset(dice, size, free);
  const DrawnBody &A = drawing.scene.bodies[static_cast<std::size_t>(a)],
                  &B = drawing.scene.bodies[static_cast<std::size_t>(b)];
  const Vector3 point = (A.places[0].point + B.places[0].point) / 2 + drawing.shift(0.5);
  tie(drawing, joint, drawing.place_on(A, point), axes_A, drawing.place_on(B, point + axes_A * offset.position),
      axes_A * offset.turn, free, size);
}

}  // namespace lithe::differential
