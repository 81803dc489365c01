#include <algorithm>
#include <cmath>
#include <optional>

#include "bodies/rigid_body.h"
#include "engine/base/error.h"
#include "engine/model/system_graph.h"
#include "joints/constant_velocity_joint.h"
#include "joints/coordinate_coupling.h"
#include "joints/cylindrical_joint.h"
#include "joints/fixed_joint.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/spring_damper.h"
#include "joints/orientation_joint.h"
#include "joints/parallel_axes_joint.h"
#include "joints/perpendicular_axes_joint.h"
#include "joints/planar_joint.h"
#include "joints/point_on_line_joint.h"
#include "joints/point_on_plane_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/rack_and_pinion.h"
#include "joints/revolute_joint.h"
#include "joints/screw_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"
#include "models/adams/adams_elements_internal.h"
#include "models/adams/adams_scene.h"
#include "models/adams/draw_adams_internal.h"

namespace lithe::adams {
namespace {

/// An element that loads its markers, for outputs.
struct Acting {
  std::string name;
  int i = 0, j = 0;
  const Constraint* constraint = nullptr;
  const ForceElement* force = nullptr;
  int at_i = 0, at_j = 0;    // places in its list; at_j -1: the opposite of I
  std::vector<int> markers;  // of a GCON, in its order
};

Vector6 load_of(Snapshot& now, const Acting& a, int place) {
  Vector6 w;
  const Sensor sensor = a.constraint ? reaction(*a.constraint, place, kWorldAxes, "load")
                                     : applied_force(*a.force, place, kWorldAxes, "load");
  sensor.evaluate(now, {w.data(), 6});
  return w;
}

/// Of all elements, what the measure asks for, on its marker I; world axes.
Vector6 load(Snapshot& now, const std::vector<Acting>& all, const AdamsMeasure& m) {
  Vector6 sum = Vector6::Zero();
  const auto on = [&](const Acting& a, bool j) -> Vector6 {
    if (!j) return load_of(now, a, a.at_i);
    return a.at_j < 0 ? Vector6(-load_of(now, a, a.at_i)) : load_of(now, a, a.at_j);
  };
  for (const Acting& a : all) {
    if (m.kind == AdamsMeasure::Kind::of_element) {
      if (a.name == m.element) sum += on(a, m.on_j);
      continue;
    }
    if (!a.markers.empty()) {
      const auto i = std::find(a.markers.begin(), a.markers.end(), m.i);
      if (i != a.markers.end() && std::find(a.markers.begin(), a.markers.end(), m.j) != a.markers.end())
        sum += load_of(now, a, static_cast<int>(i - a.markers.begin()));
    } else if (a.i == m.i && a.j == m.j) {
      sum += on(a, false);
    } else if (a.i == m.j && a.j == m.i) {
      sum += on(a, true);
    }
  }
  return sum;
}

class Drawing {
 public:
  Drawing(SystemGraph& graph, const ModelDescription& model, const std::string& prefix)
      : graph_(graph), model_(model), m_(*model.adams), prefix_(prefix) {}

  Drawn draw() {
    drawn_.joints.assign(model_.joints.size(), nullptr);
    drawn_.coordinates.resize(model_.joints.size());
    add_bodies();
    for (const auto& [id, frame] : m_.markers)
      drawn_.markers[id] = world_[static_cast<std::size_t>(frame.part)](frame.position, frame.orientation);
    drawn_.markers[0] = graph_.ground().marker();
    elements_.emplace(graph_, m_.units, drawn_.markers);
    for (const auto& [id, joint] : m_.joints) at(joint, [&] { add_joint(id, joint.name, joint.what); });
    for (const auto& motion : m_.motions) at(motion, [&] { add_motion(motion.name, motion.what); });
    for (const auto& coupler : m_.couplers) at(coupler, [&] { add_coupler(coupler.name, coupler.what); });
    for (const auto& gear : m_.gears) at(gear, [&] { add_gear(gear.name, gear.what); });
    for (const auto& gcon : m_.constraints) at(gcon, [&] { add_constraint(gcon.name, gcon.what); });
    for (const auto& load : m_.loads) at(load, [&] { add_load(load.name, load.what); });
    for (const auto& spring : m_.springs) at(spring, [&] { add_spring(spring.name, spring.what); });
    for (const auto& field : m_.fields)
      at(field, [&] {
        const ForceElement& made = elements_->add(prefix_ + field.name, field.what);
        acting_.push_back(
            {.name = field.name, .i = field.what.i, .j = field.what.j, .force = &made, .at_i = 1, .at_j = 0});
      });
    for (const auto& request : m_.requests) at(request, [&] { add_request(request.name, request.what); });
    for (const auto& variable : m_.variables) at(variable, [&] { add_output(variable.name, {{"", variable.what}}); });
    return std::move(drawn_);
  }

 private:
  /// Errors name the place in the file.
  template <class Element, class Add>
  void at(const Element& element, Add&& add) {
    try {
      add();
    } catch (const SceneError& error) {
      throw FileError(error.problem(), model_.path + ":" + std::to_string(element.line), error.fix());
    }
  }

  Marker marker(int id) const { return drawn_.markers.at(id); }
  /// Where a marker is drawn, in the world.
  ModelPose pose(int id) const {
    if (id == 0) return {};
    const AdamsModel::MarkerFrame& frame = m_.markers.at(id);
    const AdamsModel::Part& part = m_.parts[static_cast<std::size_t>(frame.part)];
    return ModelPose{part.position, part.orientation} * ModelPose{frame.position, frame.orientation};
  }
  Marker at_world(int id, const Vector3& point, const Matrix3& axes) {
    const int part = m_.markers.at(id).part;
    RigidBody* body = drawn_.bodies[static_cast<std::size_t>(part)];
    return body ? body->marker_at_world(point, axes) : graph_.ground().marker(point, axes);
  }

  void add_bodies() {
    for (std::size_t p = 0; p < m_.parts.size(); ++p) {
      const AdamsModel::Part& part = m_.parts[p];
      const ModelLink& link = model_.links[p];
      const Vector3& centre = link.inertial.position;
      if (part.ground) {
        drawn_.bodies.push_back(nullptr);
        drawn_.places.push_back({});
        world_.push_back([this](const Vector3& r, const Matrix3& R) { return graph_.ground().marker(r, R); });
        continue;
      }
      at(link, [&] {
        RigidBody* body = &graph_.add<RigidBody>(
            prefix_ + link.name, {.mass = link.mass,
                                  .inertia = link.inertia,
                                  .position = part.position + part.orientation * centre,
                                  .orientation = part.orientation,
                                  .velocity = part.velocity,
                                  .angular_velocity = part.orientation.transpose() * part.angular_velocity});
        drawn_.bodies.push_back(body);
        drawn_.places.push_back({-centre, Matrix3::Identity()});
        world_.push_back([body, centre](const Vector3& r, const Matrix3& R) { return body->marker(r - centre, R); });
      });
    }
  }

  int listed(const std::string& name) const {
    for (std::size_t k = 0; k < model_.joints.size(); ++k)
      if (model_.joints[k].name == name) return static_cast<int>(k);
    return -1;
  }
  void keep(const std::string& name, const Constraint& made, int i, int j, int at_i, int at_j) {
    acting_.push_back({.name = name, .i = i, .j = j, .constraint = &made, .at_i = at_i, .at_j = at_j});
    if (const int place = listed(name); place >= 0) drawn_.joints[static_cast<std::size_t>(place)] = &made;
  }

  /// Most of ours measure the second marker from the first, Adams I from J.
  template <class T>
  T& add_from_j(const std::string& name, const AdamsModel::Joint& joint) {
    T& made = graph_.add<T>(prefix_ + name, {marker(joint.j), marker(joint.i)});
    keep(name, made, joint.i, joint.j, 1, 0);
    return made;
  }
  void coordinate(int id, const std::string& name, const JointCoordinate& x, bool rotation) {
    (rotation ? angles_ : displacements_)[id] = x;
    const std::size_t place = static_cast<std::size_t>(listed(name));
    if (!drawn_.coordinates[place].A.body) drawn_.coordinates[place] = x;
  }

  void add_joint(int id, const std::string& name, const AdamsModel::Joint& joint) {
    const std::string& kind = joint.kind;
    if (kind == "REVOLUTE") {
      coordinate(id, name, add_from_j<RevoluteJoint>(name, joint).angle(), true);
    } else if (kind == "TRANSLATIONAL") {
      coordinate(id, name, add_from_j<PrismaticJoint>(name, joint).displacement(), false);
    } else if (kind == "CYLINDRICAL") {
      const auto& made = add_from_j<CylindricalJoint>(name, joint);
      coordinate(id, name, made.angle(), true);
      coordinate(id, name, made.displacement(), false);
    } else if (kind == "SPHERICAL" || kind == "ATPOINT") {
      add_from_j<SphericalJoint>(name, joint);
    } else if (kind == "FIXED") {
      add_from_j<FixedJoint>(name, joint);
    } else if (kind == "PLANAR") {
      add_from_j<PlanarJoint>(name, joint);
    } else if (kind == "INLINE") {
      add_from_j<PointOnLineJoint>(name, joint);
    } else if (kind == "INPLANE") {
      add_from_j<PointOnPlaneJoint>(name, joint);
    } else if (kind == "ORIENTATION") {
      add_from_j<OrientationJoint>(name, joint);
    } else if (kind == "PARALLEL_AXES") {
      add_from_j<ParallelAxesJoint>(name, joint);
    } else if (kind == "PERPENDICULAR") {
      add_from_j<PerpendicularAxesJoint>(name, joint);
    } else if (kind == "SCREW") {
      const auto& made =
          graph_.add<ScrewJoint>(prefix_ + name, {marker(joint.j), marker(joint.i)}, {.lead = joint.value});
      keep(name, made, joint.i, joint.j, 1, 0);
    } else if (kind == "HOOKE") {  // x of I at right angles to y of J
      keep(name, graph_.add<UniversalJoint>(prefix_ + name, {marker(joint.i), marker(joint.j)}), joint.i, joint.j, 0,
           1);
    } else if (kind == "UNIVERSAL") {  // z of I at right angles to z of J
      const Matrix3 x_to_z = rotation_about(Vector3::UnitY(), -M_PI / 2),
                    y_to_z = rotation_about(Vector3::UnitX(), M_PI / 2);
      const ModelPose I = pose(joint.i), J = pose(joint.j);
      const auto& made = graph_.add<UniversalJoint>(
          prefix_ + name,
          {at_world(joint.i, I.position, I.rotation * x_to_z), at_world(joint.j, J.position, J.rotation * y_to_z)});
      keep(name, made, joint.i, joint.j, 0, 1);
    } else if (kind == "CONVEL") {
      // z of both point away from the joint; ours point along the shafts in one direction.
      const ModelPose I = pose(joint.i), J = pose(joint.j);
      const bool apart = I.rotation.col(2).dot(J.rotation.col(2)) < 0;
      const Matrix3 turn = apart ? rotation_about(Vector3::UnitX(), M_PI) : Matrix3(Matrix3::Identity());
      const auto& made = graph_.add<ConstantVelocityJoint>(
          prefix_ + name, {marker(joint.j), at_world(joint.i, I.position, I.rotation * turn)});
      keep(name, made, joint.i, joint.j, 1, 0);
    } else {
      add_rack(name, joint);
    }
  }

  /// The pinion (I) turns about its z and rolls on the rack (J), which runs along its z. Ours wants the rack along x,
  /// the pinion's axis along z, and the pinion on the side of +y.
  void add_rack(const std::string& name, const AdamsModel::Joint& joint) {
    const ModelPose I = pose(joint.i), J = pose(joint.j);
    const Vector3 along = J.rotation.col(2), axis = I.rotation.col(2);
    if (std::abs(along.dot(axis)) > 1e-6)
      throw SceneError(name + " has a pinion whose axis (z of I) is not at right angles to the rack (z of J).", "",
                       "turn the markers: x of I along z of J.");
    Matrix3 axes;
    axes << along, axis.cross(along), axis;
    const double side = (I.position - J.position).dot(axes.col(1)), radius = 0.5 * joint.value;
    const bool below = side < -0.1 * std::abs(radius);  // the pinion is on the side of -y
    const auto& made = graph_.add<RackAndPinion>(
        prefix_ + name, {at_world(joint.i, I.position, axes), at_world(joint.j, J.position, axes)},
        {.radius = below ? -radius : radius});
    keep(name, made, joint.i, joint.j, 0, 1);
  }

  void add_motion(const std::string& name, const AdamsModel::Motion& motion) {
    keep(name, elements_->add(prefix_ + name, motion), motion.i, motion.j, 1, 0);
  }

  void add_coupler(const std::string& name, const AdamsModel::Coupler& coupler) {
    std::vector<JointCoordinate> all;
    for (std::size_t k = 0; k < coupler.joints.size(); ++k)
      all.push_back((coupler.rotation[k] ? angles_ : displacements_).at(coupler.joints[k]));
    graph_.add<CoordinateCoupling>(prefix_ + name, all, {.factors = coupler.factors});
  }

  /// Both gears have the velocity of the contact marker along its z, seen from the carrier that bears it.
  void add_gear(const std::string& name, const AdamsModel::Gear& gear) {
    const ModelPose contact = pose(gear.contact);
    const int carrier = m_.markers.at(gear.contact).part;
    std::vector<JointCoordinate> all;
    std::vector<double> factors;
    for (const int id : {gear.first, gear.second}) {
      const AdamsModel::Joint& joint = m_.joints.at(id).what;
      const ModelPose J = pose(joint.j);
      const Vector3 z = J.rotation.col(2);
      const bool turns = angles_.count(id) > 0;
      if (!turns && !displacements_.count(id))
        throw SceneError(name + " joins a joint that has no rotation or translation of its own.", "",
                         "join REVOLUTE, CYLINDRICAL and TRANSLATIONAL joints.");
      const int i_part = m_.markers.at(joint.i).part, j_part = m_.markers.at(joint.j).part;
      if (i_part != carrier && j_part != carrier)
        throw SceneError(
            name + ": the joint JOINT/" + std::to_string(id) + " does not join its gear to the part of CV.", "",
            "put CV on the part that carries both gears.");
      // Of the gear at the contact, by the rate of the coordinate (I against J).
      const Vector3 rate = turns ? Vector3(z.cross(contact.position - J.position)) : z;
      const double along = rate.dot(contact.rotation.col(2));
      all.push_back(turns ? angles_.at(id) : displacements_.at(id));
      factors.push_back((j_part == carrier ? along : -along) * (factors.empty() ? 1 : -1));
      if (std::abs(factors.back()) < 1e-12)
        throw SceneError(name + ": z of CV is not along the motion of its gears.", "",
                         "turn CV: z along the teeth's motion.");
    }
    graph_.add<CoordinateCoupling>(prefix_ + name, all, {.factors = factors});
  }

  void add_load(const std::string& name, const AdamsModel::Load& load) {
    const ForceElement& made = elements_->add(prefix_ + name, load);
    using enum AdamsModel::Load::Kind;
    const bool floating = load.kind == components;
    const bool alone = load.kind == on_i_along_z || load.kind == on_i_about_z;  // FX(i) asks for these
    acting_.push_back(
        {.name = name, .i = load.i, .j = alone ? 0 : load.j, .force = &made, .at_i = 0, .at_j = floating ? -1 : 1});
  }

  void add_constraint(const std::string& name, const AdamsModel::Constraint& gcon) {
    std::vector<int> ids;
    keep(name, elements_->add(prefix_ + name, gcon, &ids), 0, 0, 0, 1);
    acting_.back().markers = ids;
  }

  void add_spring(const std::string& name, const AdamsModel::Spring& spring) {
    const ForceElement* made = nullptr;
    if (spring.rotation)
      made = &graph_.add<CoordinateSpring>(prefix_ + name, {angle_between(marker(spring.j), marker(spring.i))},
                                           {.stiffness = spring.stiffness,
                                            .damping = spring.damping,
                                            .free_value = spring.free_value,
                                            .preload = -spring.preload});
    else
      made = &graph_.add<SpringDamper>(prefix_ + name, {marker(spring.j), marker(spring.i)},
                                       {.stiffness = spring.stiffness,
                                        .damping = spring.damping,
                                        .natural_length = spring.free_value,
                                        .preload = -spring.preload});
    acting_.push_back({.name = name, .i = spring.i, .j = spring.j, .force = made, .at_i = 1, .at_j = 0});
  }

  // ---- outputs ----

  void add_request(const std::string& name, const AdamsModel::Request& r) {
    std::vector<std::pair<std::string, AdamsFunction>> columns;
    if (!r.kind) {
      for (const auto& [column, f] : r.functions) columns.emplace_back("_f" + std::to_string(column), f);
      return add_output(name, columns);
    }
    const auto column = [&](const char* ending, AdamsMeasure m) {
      m.i = r.i, m.j = r.j, m.k = r.axes;
      AdamsFunction f;
      f.nodes.push_back({.operation = AdamsFunction::Operation::measure});
      f.measures.push_back(std::move(m));
      columns.emplace_back(ending, std::move(f));
    };
    using enum AdamsMeasure::Kind;
    const auto all = [&](std::initializer_list<std::pair<const char*, AdamsMeasure::Kind>> list) {
      for (const auto& [ending, kind] : list) column(ending, {.kind = kind});
    };
    if (r.kind == 'D')
      all({{"_m", DM}, {"_x", DX}, {"_y", DY}, {"_z", DZ}, {"_psi", PSI}, {"_theta", THETA}, {"_phi", PHI}});
    else if (r.kind == 'V')
      all({{"_m", VM}, {"_x", VX}, {"_y", VY}, {"_z", VZ}, {"_wm", WM}, {"_wx", WX}, {"_wy", WY}, {"_wz", WZ}});
    else if (r.kind == 'A')
      all({{"_m", ACCM},
           {"_x", ACCX},
           {"_y", ACCY},
           {"_z", ACCZ},
           {"_wdm", WDTM},
           {"_wdx", WDTX},
           {"_wdy", WDTY},
           {"_wdz", WDTZ}});
    else
      for (int c = 1; c <= 8; ++c) {
        constexpr const char* kEndings[] = {"_fm", "_fx", "_fy", "_fz", "_tm", "_tx", "_ty", "_tz"};
        column(kEndings[c - 1], {.kind = between, .component = c});
      }
    add_output(name, columns);
  }

  /// A sensor of functions; it keeps the markers and elements that they read.
  void add_output(const std::string& name, const std::vector<std::pair<std::string, AdamsFunction>>& columns) {
    struct Output {
      std::vector<AdamsFunction> functions;
      std::map<int, Marker> markers;
      std::vector<Acting> acting;
      AdamsUnits units;
    } output{.units = m_.units};
    std::vector<std::string> names;
    bool loads = false;
    for (const auto& [ending, f] : columns) {
      names.push_back(prefix_ + name + ending);
      output.functions.push_back(f);
      for (const AdamsMeasure& m : f.measures) {
        loads |= m.of_load();
        for (const int id : {m.i, m.j, m.k, m.l}) output.markers[id] = marker(id);
      }
    }
    if (loads) output.acting = acting_;
    drawn_.outputs.push_back(Sensor{
        prefix_ + name, names, [output](Snapshot& now, std::span<double> values) {
          const AdamsUnits& u = output.units;
          Observed from;
          from.marker = [&](int id) { return now.marker(output.markers.at(id)); };
          from.acceleration = [&](int id) -> Vector6 {
            return id == 0 ? Vector6(Vector6::Zero()) : now.acceleration(output.markers.at(id));
          };
          from.angle = [&](const AdamsMeasure& m) {
            const int axis = static_cast<int>(m.kind) - static_cast<int>(AdamsMeasure::Kind::AX);
            const JointCoordinate x = angle_between(output.markers.at(m.j), output.markers.at(m.i), axis);
            return coordinate_value(now, x);
          };
          from.load = [&](const AdamsMeasure& m) {
            const Vector6 w = lithe::adams::load(now, output.acting, m);
            const bool torque = m.component > 4;
            const Vector3 part = torque ? w.tail<3>() : w.head<3>();
            const int c = (m.component - 1) % 4;
            const double value = c == 0 ? part.norm() : part.dot(now.marker(output.markers.at(m.k)).R.col(c - 1));
            return value / (torque ? u.torque() : u.force);
          };
          for (std::size_t k = 0; k < output.functions.size(); ++k)
            values[k] = observed_value(output.functions[k], u, now.time(), from);
        }});
  }

  static double coordinate_value(Snapshot& now, const JointCoordinate& x) {
    double value = 0;
    lithe::coordinate(x, "angle").evaluate(now, {&value, 1});
    return value;
  }

  SystemGraph& graph_;
  const ModelDescription& model_;
  const AdamsModel& m_;
  const std::string prefix_;
  Drawn drawn_;
  std::vector<std::function<Marker(const Vector3&, const Matrix3&)>> world_;  // markers of each part, by its frame
  std::map<int, JointCoordinate> angles_, displacements_;                     // of joints
  std::vector<Acting> acting_;
  std::optional<AdamsScene> elements_;  // by functions
};

}  // namespace

Drawn draw(SystemGraph& graph, const ModelDescription& model, const std::string& prefix) {
  return Drawing(graph, model, prefix).draw();
}

}  // namespace lithe::adams
