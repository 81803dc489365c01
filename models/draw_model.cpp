#include "models/draw_model.h"

#include "bodies/rigid_body.h"
#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/base/rotations.h"
#include "engine/model/system_graph.h"
#include "joints/coordinate_coupling.h"
#include "joints/fixed_joint.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/planar_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"
#include "models/adams/draw_adams_internal.h"
#include "models/armature_internal.h"
#include "models/link_graph_internal.h"

namespace lithe {
namespace {

using Type = ModelJoint::Type;

/// A frame's motion in the world: pose, velocity of its origin, angular velocity; world axes.
struct LinkMotion {
  ModelPose pose;
  Vector3 v, w;
  Vector3 velocity_at(const Vector3& point) const { return v + w.cross(point - pose.position); }
};

bool has_coordinate(const ModelJoint& joint) { return joint.type == Type::revolute || joint.type == Type::prismatic; }

ModelPose inverse(const ModelPose& pose) {
  return {-(pose.rotation.transpose() * pose.position), pose.rotation.transpose()};
}

/// One value a joint: as given, by the leader, or zero.
std::vector<double> joint_values(const ModelDescription& model, const std::map<std::string, double>& given,
                                 const char* what, bool rates) {
  std::vector<double> values(model.joints.size(), 0.0);
  for (const auto& [name, value] : given) {
    const int at = model.joint(name);
    const ModelJoint& joint = model.joints[at];
    require::finite(value, std::string(what) + " of '" + name + "'");
    if (!has_coordinate(joint) || joint.mimic || joint.closes_loop)
      throw SceneError("the joint '" + name + "' takes no " + what + ".", model.path,
                       joint.closes_loop ? "it closes a loop: give the joints of the tree."
                       : joint.mimic     ? "it follows '" + model.joints[joint.mimic->leader].name + "': give that one."
                                         : "only revolute and prismatic joints do.");
    values[at] = value;
  }
  for (std::size_t j = 0; j < values.size(); ++j)
    if (const auto& mimic = model.joints[j].mimic)
      values[j] = mimic->multiplier * values[mimic->leader] + (rates ? 0.0 : mimic->offset);
  return values;
}

/// Joints from the root outwards: the parent of each has its motion before it.
std::vector<int> outwards(const ModelDescription& model) {
  std::vector<std::vector<int>> below(model.links.size());
  for (std::size_t j = 0; j < model.joints.size(); ++j)
    if (!model.joints[j].closes_loop) below[model.joints[j].parent].push_back(static_cast<int>(j));
  std::vector<int> order, open = {model.root};
  while (!open.empty()) {
    const int link = open.back();
    open.pop_back();
    for (const int j : below[link]) {
      order.push_back(j);
      open.push_back(model.joints[j].child);
    }
  }
  return order;
}

std::vector<LinkMotion> motions(const ModelDescription& model, const DrawnModel::Options& o) {
  const std::vector<double> x = joint_values(model, o.positions, "position", false);
  const std::vector<double> rate = joint_values(model, o.velocities, "velocity", true);
  std::vector<LinkMotion> all(model.links.size());
  LinkMotion& root = all[model.root];
  root.pose = o.root * model.root_pose;
  root.v = o.floating ? o.velocity : Vector3(Vector3::Zero());
  root.w = o.floating ? Vector3(o.root.rotation * o.angular_velocity) : Vector3(Vector3::Zero());
  for (const int j : outwards(model)) {
    const ModelJoint& joint = model.joints[j];
    const LinkMotion& parent = all[joint.parent];
    LinkMotion& child = all[joint.child];
    ModelPose at = parent.pose * joint.origin;  // the joint's frame on the child
    const Vector3 axis = at.rotation * joint.axis;
    child.w = parent.w;
    if (joint.type == Type::prismatic) at.position += x[j] * axis;
    if (joint.type == Type::revolute) {
      at.rotation = at.rotation * Eigen::AngleAxisd(x[j], joint.axis).toRotationMatrix();
      child.w += rate[j] * axis;
    }
    Vector3 v = parent.velocity_at(at.position);
    if (joint.type == Type::prismatic) v += rate[j] * axis;
    child.pose = at * inverse(joint.child_origin);
    child.v = v + child.w.cross(child.pose.position - at.position);
  }
  return all;
}

/// Mass, centre and inertia of welded links, in the frame of the one that stands for them.
struct Compound {
  double mass = 0;
  Vector3 moment = Vector3::Zero();   // Σ m c
  Matrix3 inertia = Matrix3::Zero();  // about the frame's origin

  void add(const ModelLink& link, const ModelPose& place) {
    const ModelPose at = place * link.inertial;
    const Matrix3 c = skew(at.position);
    mass += link.mass;
    moment += link.mass * at.position;
    inertia += at.rotation * link.inertia * at.rotation.transpose() - link.mass * c * c;
  }
  Vector3 centre() const { return moment / mass; }
  Matrix3 about_centre() const {
    const Matrix3 c = skew(centre());
    const Matrix3 J = inertia + mass * c * c;
    return 0.5 * (J + J.transpose());
  }
};

/// z along the axis; of a universal joint x along the first, y along the second.
Matrix3 axes_of(const ModelJoint& joint) {
  if (joint.type == Type::spherical || joint.type == Type::fixed) return Matrix3::Identity();
  if (joint.type != Type::universal) return axes_along(joint.axis);
  Matrix3 axes;
  axes << joint.axis, joint.second_axis, joint.axis.cross(joint.second_axis);
  return axes;
}

}  // namespace

DrawnModel draw_adams_model(SystemGraph& graph, const ModelDescription& model, const DrawnModel::Options& options) {
  if (options.floating || !options.positions.empty() || !options.velocities.empty() ||
      options.root.position != Vector3::Zero() || options.root.rotation != Matrix3::Identity())
    throw SceneError("an Adams data set takes no other place, positions or velocities than its own.", model.path,
                     "change QG, REULER and the velocities of its parts.");
  adams::Drawn made = adams::draw(graph, model, options.prefix);
  DrawnModel drawn(graph, model);
  drawn.bodies_ = std::move(made.bodies);
  drawn.places_ = std::move(made.places);
  drawn.joints_ = std::move(made.joints);
  drawn.coordinates_ = std::move(made.coordinates);
  drawn.adams_markers_ = std::move(made.markers);
  drawn.outputs_ = std::move(made.outputs);
  return drawn;
}

DrawnModel draw_model(SystemGraph& graph, const ModelDescription& model, const DrawnModel::Options& options) {
  require::finite(options.root.position, "root.position");
  require::rotation(options.root.rotation, "root.rotation");
  require::finite(options.velocity, "velocity");
  require::finite(options.angular_velocity, "angular_velocity");
  if (model.adams) return draw_adams_model(graph, model, options);
  if (options.floating && model.root_is_world)
    throw SceneError("the root of the model is the world: it cannot be free.", model.path,
                     "leave .floating out; what is free in the file is free.");
  const std::vector<LinkMotion> motion = motions(model, options);
  const std::vector<int> welded = model.welded_to();
  const std::size_t n = model.links.size();

  // 1. Bodies: one for each group of welded links, at its centre of mass.
  DrawnModel drawn(graph, model);
  drawn.bodies_.assign(n, nullptr);
  drawn.places_.resize(n);
  std::vector<Compound> compounds(n);
  for (std::size_t i = 0; i < n; ++i)
    compounds[welded[i]].add(model.links[i], seen_from(motion[welded[i]].pose, motion[i].pose));
  for (std::size_t i = 0; i < n; ++i) {
    const bool on_ground = static_cast<int>(i) == model.root && !options.floating;
    if (welded[i] != static_cast<int>(i) || on_ground) continue;
    const Compound& sum = compounds[i];
    if (!(sum.mass > 0))
      throw SceneError("the link '" + model.links[i].name + "' moves and has no mass.",
                       model.path + ":" + std::to_string(model.links[i].line),
                       "give it an <inertial>, or fix it to a link that has one.");
    const LinkMotion& m = motion[i];
    const Vector3 centre = m.pose.position + m.pose.rotation * sum.centre();
    drawn.bodies_[i] = &graph.add<RigidBody>(options.prefix + model.links[i].name,
                                             {.mass = sum.mass,
                                              .inertia = sum.about_centre(),
                                              .position = centre,
                                              .orientation = m.pose.rotation,
                                              .velocity = m.velocity_at(centre),
                                              .angular_velocity = m.pose.rotation.transpose() * m.w});
  }
  for (std::size_t i = 0; i < n; ++i) {
    drawn.bodies_[i] = drawn.bodies_[welded[i]];
    drawn.places_[i] = motion[i].pose;
    if (!drawn.bodies_[i]) continue;
    drawn.places_[i] = seen_from(motion[welded[i]].pose, motion[i].pose);
    drawn.places_[i].position -= compounds[welded[i]].centre();
  }

  const std::vector<double> rates = joint_values(model, options.velocities, "velocity", true);
  // 2. Joints, their z axes along the axis of the file; angles and displacements count from where the file has zero.
  drawn.joints_.assign(model.joints.size(), nullptr);
  drawn.coordinates_.resize(model.joints.size());
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const ModelJoint& joint = model.joints[j];
    if (joint.type == Type::fixed && !joint.closes_loop) continue;
    const Matrix3 axes = axes_of(joint);
    const std::string &parent = model.links[joint.parent].name, &child = model.links[joint.child].name;
    const std::vector<Marker> markers = {
        drawn.marker(parent, joint.origin.position, joint.origin.rotation * axes),
        drawn.marker(child, joint.child_origin.position, joint.child_origin.rotation * axes)};
    const std::string name = options.prefix + joint.name;
    if (markers[0].body == markers[1].body)
      throw SceneError("the joint '" + joint.name + "' joins two links that are fixed to each other.",
                       model.path + ":" + std::to_string(joint.line), "leave it out.");
    if (joint.type == Type::revolute) {
      auto& made = graph.add<RevoluteJoint>(name, markers);
      drawn.joints_[j] = &made;
      drawn.coordinates_[j] = made.angle();
    } else if (joint.type == Type::prismatic) {
      auto& made = graph.add<PrismaticJoint>(name, markers);
      drawn.joints_[j] = &made;
      drawn.coordinates_[j] = made.displacement();
    } else if (joint.type == Type::planar) {
      drawn.joints_[j] = &graph.add<PlanarJoint>(name, markers);
    } else if (joint.type == Type::spherical) {
      drawn.joints_[j] = &graph.add<SphericalJoint>(name, markers);
    } else if (joint.type == Type::universal) {
      drawn.joints_[j] = &graph.add<UniversalJoint>(name, markers);
    } else if (joint.type == Type::fixed) {
      drawn.joints_[j] = &graph.add<FixedJoint>(name, markers);
    }
    if (!has_coordinate(joint)) continue;
    if (options.damping && (joint.damping > 0 || joint.stiffness > 0))
      graph.add<CoordinateSpring>(
          name + (joint.stiffness > 0 ? "_spring" : "_damping"), {drawn.coordinates_[j]},
          {.stiffness = joint.stiffness, .damping = joint.damping, .free_value = joint.spring_reference});
    if (options.armature && joint.armature > 0) {
      const auto& rotor = graph.add<Armature>(name + "_armature", {.inertia = joint.armature, .rate = rates[j]});
      graph.add<CoordinateCoupling>(name + "_armature_gear", {drawn.coordinates_[j], rotor.coordinate()},
                                    {.factors = {1, -1}});
    }
  }

  // 3. Followers: x - multiplier * leader = offset.
  for (std::size_t j = 0; j < model.joints.size(); ++j)
    if (const auto& mimic = model.joints[j].mimic)
      graph.add<CoordinateCoupling>(options.prefix + model.joints[j].name + "_mimic",
                                    {drawn.coordinates_[j], drawn.coordinates_[mimic->leader]},
                                    {.factors = {1, -mimic->multiplier}, .offset = mimic->offset});
  return drawn;
}

RigidBody* DrawnModel::body(const std::string& link) const { return bodies_[model_.link(link)]; }

Marker DrawnModel::marker(const std::string& link, const Vector3& point, const Matrix3& orientation) const {
  const int i = model_.link(link);
  const ModelPose at = places_[i] * ModelPose{point, orientation};
  return bodies_[i] ? bodies_[i]->marker(at.position, at.rotation) : graph_->ground().marker(at.position, at.rotation);
}

std::vector<std::pair<const RigidBody*, DrawnShape>> DrawnModel::shapes() const {
  std::vector<std::pair<const RigidBody*, DrawnShape>> all;
  for (std::size_t i = 0; i < model_.links.size(); ++i)
    for (const DrawnShape& shape : model_.links[i].shapes)
      if (bodies_[i]) all.emplace_back(bodies_[i], shape.at(places_[i].position, places_[i].rotation));
  return all;
}

const Constraint& DrawnModel::joint(const std::string& name) const {
  const Constraint* found = joints_[model_.joint(name)];
  if (!found) throw SceneError("the joint '" + name + "' holds nothing.", model_.path, "it is fixed or floating.");
  return *found;
}

Marker DrawnModel::adams_marker(int id) const {
  const auto found = adams_markers_.find(id);
  if (found == adams_markers_.end())
    throw SceneError("the model has no MARKER/" + std::to_string(id) + ".", model_.path,
                     model_.adams ? "name one of the file's markers." : "only an Adams data set has numbered markers.");
  return found->second;
}

JointCoordinate DrawnModel::coordinate(const std::string& joint) const {
  const int j = model_.joint(joint);
  if (!coordinates_[j].A.body)
    throw SceneError("the joint '" + joint + "' has no coordinate of its own.", model_.path,
                     "only revolute and prismatic joints have; take the markers of its links for others.");
  return coordinates_[j];
}

}  // namespace lithe
