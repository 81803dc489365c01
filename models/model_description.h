#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/base/math.h"
#include "engine/model/appearance.h"
#include "models/adams/adams_model.h"

namespace lithe {

/// A frame seen from another: its origin there (m), and the rotation that takes its axes to those of the other.
struct ModelPose {
  Vector3 position{0, 0, 0};
  Matrix3 rotation = Matrix3::Identity();

  /// A frame seen from this one, seen from where this one is seen.
  ModelPose operator*(const ModelPose& inner) const {
    return {position + rotation * inner.position, rotation * inner.rotation};
  }
};

/// A body as a model file describes it. Its frame is the file's; the centre of mass lies elsewhere.
struct ModelLink {
  std::string name;
  double mass = 0;                    // kg; 0: none
  ModelPose inertial{};               // the frame of the inertia, at the centre of mass, in the link's frame
  Matrix3 inertia = Matrix3::Zero();  // about the centre of mass, axes of `inertial`, kg m²
  std::vector<DrawnShape> shapes{};   // in the link's frame
  int line = 0;                       // of the file
};

/// A joint as a model file describes it. The joint's frame on the child lies on that of the parent, moved by the
/// motion; z, x ... of both are the same axes where the coordinates are zero.
struct ModelJoint {
  enum class Type { fixed, revolute, prismatic, planar, floating, spherical, universal, other };
  /// The joint follows another one: its value is multiplier * that of the leader + offset.
  struct Mimic {
    int leader = 0;  // place in ModelDescription::joints
    double multiplier = 1, offset = 0;
  };
  std::string name;
  Type type = Type::fixed;
  int parent = 0, child = 0;     // places in ModelDescription::links
  ModelPose origin{};            // of the joint in the parent's frame
  ModelPose child_origin{};      // of the joint in the child's frame
  Vector3 axis{1, 0, 0};         // unit vector in the joint's frame: of rotation, of translation, normal of a plane
  Vector3 second_axis{0, 1, 0};  // likewise: of a universal joint, fixed in the child
  double damping = 0;            // N m s/rad or N s/m
  double stiffness = 0;          // N m/rad or N/m
  double spring_reference = 0;   // rad or m: where the spring is free of force
  double armature = 0;           // inertia of a rotor that turns with the coordinate, kg m² or kg
  bool closes_loop = false;      // beside the tree of the others
  std::optional<Mimic> mimic{};
  int line = 0;
  std::string kind{};  // of type `other`: the file's own word
};

/// Something in the file that does not act, and why.
struct ModelNote {
  int line = 0;  // first place; 0: none
  int count = 1;
  std::string what, why;
};

/// A model as its file describes it: links, joints, and what was left out. SI units.
struct ModelDescription {
  std::string name, format, path;
  std::vector<ModelLink> links;
  std::vector<ModelJoint> joints;
  std::vector<ModelNote> notes;

  int root = 0;                       // the link that is no joint's child: `world`, ground, or the base of a robot
  bool root_is_world = false;         // it cannot be free
  ModelPose root_pose{};              // of the root link in the world
  Vector3 gravity{0, 0, -9.81};       // m/s², world axes; the file's, or the earth's where it has none
  std::optional<double> tolerance{};  // of the file's integrator
  std::optional<double> duration{};   // s, of the file's simulation
  std::optional<double> every{};      // s, between its outputs
  std::optional<AdamsModel>
      adams{};  // what only an Adams data set has; its links are parts, its joints all that ties them

  /// Places of links and joints by name; SceneError that lists what there is.
  int link(const std::string& name) const;
  int joint(const std::string& name) const;
  /// For each link, the link that it is welded to by fixed joints and that stands for all of them: the one nearest to
  /// the root.
  std::vector<int> welded_to() const;
  /// One page of text: bodies, joints, freedoms, mass, what was merged, what does not act and why.
  std::string sheet() const;
  /// Every link with its mass and centre, every joint with its kind and links: one line each.
  std::string table() const;
};

}  // namespace lithe
