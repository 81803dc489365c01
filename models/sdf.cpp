#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "engine/base/error.h"
#include "engine/base/rotations.h"
#include "models/link_graph_internal.h"
#include "models/notes_internal.h"
#include "models/read_model.h"
#include "models/xml_file_internal.h"

namespace lithe {
namespace {

class SdfReader {
 public:
  explicit SdfReader(const XmlFile& file) : file_(file) {
    if (std::string(file_.root().name()) != "sdf")
      file_.fail(file_.root(), "the root element is <" + std::string(file_.root().name()) + ">, not <sdf>.",
                 "give an SDF file.");
    file_.text(file_.root(), "version");
    version_ = file_.root().attribute("version").as_double();
    model_.format = "SDF";
    model_.path = file.path();
    model_.root_is_world = true;
    model_.links.push_back({.name = "world", .line = file_.line(file_.root())});
    poses_.emplace_back();
  }

  ModelDescription read() {
    pugi::xml_node holder = file_.root();
    if (const pugi::xml_node world = holder.child("world")) {
      if (const pugi::xml_node second = world.next_sibling("world"))
        file_.fail(second, "the file has two worlds.", "give one.");
      holder = world;
      model_.gravity = Vector3(0, 0, -9.8);  // SDF's own default
      if (const pugi::xml_node gravity = world.child("gravity"))
        model_.gravity = Eigen::Map<const Vector3>(file_.content(gravity, 3).data());
      note_others(world, {"model", "gravity"});
    } else {
      note_others(holder, {"model"});
    }
    const auto found = holder.children("model");
    const auto models = std::distance(found.begin(), found.end());
    if (models == 0) file_.fail(holder, "the file has no model.", "give at least one <model>.");
    for (const pugi::xml_node& node : found) {
      const std::string name = file_.text(node, "name");
      if (model_.name.empty()) model_.name = models == 1 ? name : holder.attribute("name").as_string("world");
      add_model(node, models == 1 ? "" : name + "::");
    }
    for (const auto& [joint, node] : mimics_) add_mimic(joint, node);
    make_tree(model_, poses_);
    model_.notes = notes_.take();
    return std::move(model_);
  }

 private:
  void note_others(const pugi::xml_node& node, const std::set<std::string>& known) {
    static const std::map<std::string, std::string> reasons = {
        {"include", "other files are not read: put the model into this one"},
        {"plugin", "a program for one simulator"},
        {"collision", "contact is given by add<Contact>() with shapes of your choice"},
        {"limit", "limits do not act: add a CoordinateStop"},
        {"sensor", "ask for sensors of markers and joints"},
        {"light", "pictures"},
        {"scene", "pictures"},
        {"physics", "the method and its step are those of the run"},
        {"gui", "a program's own"},
        {"self_collide", "contact is given by add<Contact>()"},
        {"gravity", "gravity acts on all bodies alike"},
        {"wind", "add a UserForce"},
        {"enable_wind", "add a UserForce"},
        {"battery", "no mechanics"},
        {"magnetic_field", "no mechanics"},
        {"atmosphere", "no mechanics"},
        {"spherical_coordinates", "no mechanics"},
        {"particle_emitter", "pictures"},
        {"actor", "an animation"},
        {"road", "pictures"},
        {"state", "the drawing is the start"},
        {"projector", "pictures"},
        {"velocity_decay", "a simulator's own damping: add a UserForce"},
        {"kinematic", "a simulator's own"},
        {"must_be_base_link", "a simulator's own"},
        {"gripper", "a simulator's own"},
        {"allow_auto_disable", "a simulator's own"}};
    for (const pugi::xml_node& child : node.children()) {
      if (child.type() != pugi::node_element || known.count(child.name())) continue;
      const auto reason = reasons.find(child.name());
      if (reason == reasons.end())
        file_.fail(child, "<" + std::string(child.name()) + "> is no tag that SDF has in <" + node.name() + ">.",
                   "correct its name, or leave it out.");
      notes_.add(file_.line(child), "<" + std::string(child.name()) + ">", reason->second);
    }
  }

  /// Of <pose>: x y z roll pitch yaw.
  ModelPose values(const pugi::xml_node& node) const {
    if (!node || std::string(node.text().as_string()).find_first_not_of(" \t\r\n") == std::string::npos) return {};
    if (node.attribute("rotation_format") &&
        std::string(node.attribute("rotation_format").as_string()) != "euler_rpy") {
      const std::vector<double> x = file_.content(node, 7);  // quat_xyzw
      const Eigen::Quaterniond e(x[6], x[3], x[4], x[5]);
      if (!(e.norm() > 1e-12)) file_.fail(node, "the quaternion is zero.", "give x y z qx qy qz qw.");
      return {{x[0], x[1], x[2]}, e.normalized().toRotationMatrix()};
    }
    const std::vector<double> x = file_.content(node, 6);
    const double unit = node.attribute("degrees").as_bool() ? M_PI / 180 : 1;
    return {{x[0], x[1], x[2]}, rotation_from_euler_321(unit * x[5], unit * x[4], unit * x[3])};
  }

  /// The frame that a pose is given in, in the world; `fallback` where none is named.
  ModelPose relative(const pugi::xml_node& pose, const std::string& prefix, const ModelPose& fallback) {
    const std::string name = pose.attribute("relative_to").as_string();
    if (name.empty()) return fallback;
    return frame(pose, prefix, name);
  }

  /// A link, joint or frame of the model by its name; in the world. They may be written in any order.
  ModelPose frame(const pugi::xml_node& from, const std::string& prefix, const std::string& name) {
    if (name == "world") return {};
    if (name == "__model__") return model_pose_;
    const std::string key = prefix + name;
    if (const auto known = frames_.find(key); known != frames_.end()) return known->second;
    if (!open_.insert(key).second)
      file_.fail(from, "the pose of '" + name + "' is given relative to itself.", "end the circle at the model.");
    for (const char* tag : {"link", "joint", "frame"}) {
      const pugi::xml_node node = model_node_.find_child_by_attribute(tag, "name", name.c_str());
      if (!node) continue;
      ModelPose base = model_pose_;
      if (std::string(tag) == "joint" && !node.child("pose").attribute("relative_to")) {
        const std::string child = child_text(node, "child");
        base = child == "world" ? ModelPose{} : frame(node, prefix, child);
      }
      if (std::string(tag) == "frame" && !node.child("pose").attribute("relative_to"))
        if (const std::string to = node.attribute("attached_to").as_string(); !to.empty())
          base = frame(node, prefix, to);
      const ModelPose made = relative(node.child("pose"), prefix, base) * values(node.child("pose"));
      open_.erase(key);
      return frames_[key] = made;
    }
    file_.fail(from, "there is no link, joint or frame '" + name + "'.", "name one of the model.");
  }

  std::string child_text(const pugi::xml_node& node, const char* tag) const {
    std::string text = node.child(tag).text().as_string();
    const auto blank = [](char c) { return std::isspace(static_cast<unsigned char>(c)); };
    while (!text.empty() && blank(text.back())) text.pop_back();
    while (!text.empty() && blank(text.front())) text.erase(text.begin());
    if (text.empty())
      file_.fail(node, "<" + std::string(node.name()) + "> has no <" + tag + ">.",
                 "give it as <" + std::string(tag) + ">.");
    return text;
  }

  void add_model(const pugi::xml_node& node, const std::string& prefix) {
    if (node.child("model"))
      file_.fail(node.child("model"), "the model holds another model, which is not read.", "give its links here.");
    model_node_ = node;
    if (const std::string to = node.child("pose").attribute("relative_to").as_string(); !to.empty() && to != "world")
      file_.fail(node.child("pose"), "the pose of the model is relative to '" + to + "', which is not read.",
                 "give it in the world.");
    model_pose_ = values(node.child("pose"));
    note_others(node, {"link", "joint", "frame", "pose", "static"});
    std::vector<std::string> own;
    for (const pugi::xml_node& link : node.children("link"))
      add_link(link, prefix), own.push_back(model_.links.back().name);
    if (own.empty()) file_.fail(node, "the model has no link.", "give it at least one <link>.");
    for (const pugi::xml_node& joint : node.children("joint")) add_joint(joint, prefix);
    if (node.child("static").text().as_bool())
      for (const std::string& name : own) {
        ModelJoint fixed{.name = name + "_static", .line = file_.line(node)};
        fixed.child = links_.at(name);
        fixed.origin = poses_[static_cast<std::size_t>(fixed.child)];
        model_.joints.push_back(fixed);
      }
  }

  void add_link(const pugi::xml_node& node, const std::string& prefix) {
    const std::string own = file_.text(node, "name");
    ModelLink link{.name = prefix + own, .line = file_.line(node)};
    if (own == "world" || !links_.try_emplace(link.name, static_cast<int>(model_.links.size())).second)
      file_.fail(node, "there are two links '" + own + "'.", "give each a name of its own.");
    poses_.push_back(frame(node, prefix, own));
    link.mass = 1, link.inertia.setIdentity();  // SDF's defaults
    if (const pugi::xml_node inertial = node.child("inertial")) {
      link.inertial = values(inertial.child("pose"));
      link.mass = file_.content(inertial, "mass", 1);
      if (!(link.mass > 0)) file_.fail(inertial, "the mass of '" + own + "' is not above zero.", "give a mass in kg.");
      if (const pugi::xml_node I = inertial.child("inertia")) {
        const auto of = [&](const char* tag, double fallback) { return file_.content(I, tag, fallback); };
        const double xx = of("ixx", 1), yy = of("iyy", 1), zz = of("izz", 1);
        const double xy = of("ixy", 0), xz = of("ixz", 0), yz = of("iyz", 0);
        link.inertia << xx, xy, xz, xy, yy, yz, xz, yz, zz;
      }
      if (inertial.child("fluid_added_mass") || inertial.child("density"))
        notes_.add(file_.line(inertial), "<fluid_added_mass> or <density>", "mass and inertia as given act");
    } else {
      notes_.add(file_.line(node), "a <link> without <inertial>", "it has SDF's default, 1 kg and 1 kg m²");
    }
    try {
      check_inertia(link);
      for (const pugi::xml_node& visual : node.children("visual")) add_shape(visual, link);
    } catch (const SceneError& error) {
      file_.fail(node, error.problem(), error.fix());
    }
    note_others(node, {"inertial", "visual", "pose"});
    model_.links.push_back(std::move(link));
  }

  void add_shape(const pugi::xml_node& visual, ModelLink& link) {
    const pugi::xml_node geometry = visual.child("geometry");
    const ModelPose place = values(visual.child("pose"));
    const auto number = [&](const pugi::xml_node& of, const char* tag) { return file_.content(of, tag, NAN); };
    if (const pugi::xml_node box = geometry.child("box"))
      link.shapes.push_back(visual::box(Eigen::Map<const Vector3>(file_.content(box.child("size"), 3).data())));
    else if (const pugi::xml_node cylinder = geometry.child("cylinder"))
      link.shapes.push_back(visual::cylinder(number(cylinder, "radius"), number(cylinder, "length")));
    else if (const pugi::xml_node capsule = geometry.child("capsule"))
      link.shapes.push_back(visual::capsule(number(capsule, "radius"), number(capsule, "length")));
    else if (const pugi::xml_node sphere = geometry.child("sphere"))
      link.shapes.push_back(visual::sphere(number(sphere, "radius")));
    else
      return notes_.add(file_.line(visual), "<visual> of a mesh",
                        "mesh files are not read: pages show the links as sticks");
    link.shapes.back() = link.shapes.back().at(place.position, place.rotation);
  }

  int find_link(const pugi::xml_node& joint, const char* side, const std::string& prefix) {
    std::string name = child_text(joint, side);
    if (name == "world") return 0;
    // A frame stands for the link that it is attached to.
    for (int steps = 0; steps < 100 && !links_.count(prefix + name); ++steps) {
      const pugi::xml_node frame = model_node_.find_child_by_attribute("frame", "name", name.c_str());
      const std::string to = frame.attribute("attached_to").as_string();
      if (to.empty()) break;
      name = to;
    }
    const auto at = links_.find(prefix + name);
    if (at == links_.end()) file_.fail(joint, "there is no link '" + name + "'.", "name one of the model's links.");
    return at->second;
  }

  Vector3 axis(const pugi::xml_node& joint, const char* tag, const std::string& prefix, const ModelPose& at) {
    const pugi::xml_node node = joint.child(tag), xyz = node.child("xyz");
    Vector3 direction = Vector3::UnitZ();
    if (xyz) direction = Eigen::Map<const Vector3>(file_.content(xyz, 3).data());
    if (!(direction.norm() > 1e-12))
      file_.fail(joint, "the axis of '" + std::string(joint.attribute("name").as_string()) + "' has no direction.",
                 "give <axis><xyz>0 0 1</xyz></axis> or another.");
    const std::string in = xyz.attribute("expressed_in").as_string();
    const bool of_model = (version_ < 1.5 && version_ > 0) || node.child("use_parent_model_frame").text().as_bool();
    if (!in.empty())
      direction = at.rotation.transpose() * (frame(joint, prefix, in).rotation * direction);
    else if (of_model)
      direction = at.rotation.transpose() * (model_pose_.rotation * direction);
    return direction.normalized();
  }

  void add_joint(const pugi::xml_node& node, const std::string& prefix) {
    using enum ModelJoint::Type;
    static const std::map<std::string, ModelJoint::Type> types = {{"fixed", fixed},         {"revolute", revolute},
                                                                  {"continuous", revolute}, {"prismatic", prismatic},
                                                                  {"ball", spherical},      {"universal", universal}};
    const std::string own = file_.text(node, "name"), type = file_.text(node, "type");
    ModelJoint joint{.name = prefix + own, .line = file_.line(node)};
    if (!joints_.try_emplace(joint.name, static_cast<int>(model_.joints.size())).second)
      file_.fail(node, "there are two joints '" + own + "'.", "give each a name of its own.");
    const auto known = types.find(type);
    if (known == types.end())
      file_.fail(node, "the joint '" + own + "' is of the type '" + type + "', which is unknown or not read.",
                 "known are revolute, continuous, prismatic, fixed, ball, universal.");
    joint.type = known->second;
    joint.parent = find_link(node, "parent", prefix);
    joint.child = find_link(node, "child", prefix);
    if (joint.parent == joint.child)
      file_.fail(node, "the joint '" + own + "' joins a link to itself.", "name two links.");
    const ModelPose at = frame(node, prefix, own);
    joint.origin = seen_from(poses_[static_cast<std::size_t>(joint.parent)], at);
    joint.child_origin = seen_from(poses_[static_cast<std::size_t>(joint.child)], at);
    note_others(node, {"parent", "child", "pose", "axis", "axis2"});
    if (joint.type == revolute || joint.type == prismatic || joint.type == universal) {
      if (!node.child("axis"))
        file_.fail(node, "the joint '" + own + "' has no <axis>.", "give <axis><xyz>0 0 1</xyz></axis>.");
      joint.axis = axis(node, "axis", prefix, at);
    }
    if (joint.type == universal) {
      joint.second_axis = axis(node, "axis2", prefix, at);
      if (std::abs(joint.axis.dot(joint.second_axis)) > 1e-9)
        file_.fail(node, "the axes of the universal joint '" + own + "' are not at right angles.", "turn one of them.");
      if (node.child("axis").child("dynamics") || node.child("axis2").child("dynamics"))
        notes_.add(file_.line(node), "<dynamics> of a universal joint", "add CoordinateSprings to its angles");
    }
    const pugi::xml_node axis_node = node.child("axis"), dynamics = axis_node.child("dynamics");
    if (joint.type == revolute || joint.type == prismatic) {
      joint.damping = file_.content(dynamics, "damping", 0);
      joint.stiffness = file_.content(dynamics, "spring_stiffness", 0);
      joint.spring_reference = file_.content(dynamics, "spring_reference", 0);
      if (joint.damping < 0 || joint.stiffness < 0)
        file_.fail(dynamics, "the damping or stiffness of '" + own + "' is negative.",
                   "give it in N m s/rad, N m/rad.");
      if (file_.content(dynamics, "friction", 0) != 0)
        notes_.add(file_.line(dynamics), "<friction>", "dry friction needs the joint's reaction: add a JointFriction");
      note_others(axis_node, {"xyz", "dynamics", "mimic", "use_parent_model_frame", "initial_position"});
      if (file_.content(axis_node, "initial_position", 0) != 0)
        notes_.add(file_.line(axis_node), "<initial_position>", "give .positions to draw_model, --set to the command");
      if (const pugi::xml_node mimic = axis_node.child("mimic"))
        mimics_.emplace_back(static_cast<int>(model_.joints.size()), std::pair(mimic, prefix));
    }
    model_.joints.push_back(std::move(joint));
  }

  void add_mimic(int own, const std::pair<pugi::xml_node, std::string>& where) {
    const auto& [mimic, prefix] = where;
    ModelJoint& joint = model_.joints[static_cast<std::size_t>(own)];
    const std::string leader = file_.text(mimic, "joint");
    const auto at = joints_.find(prefix + leader);
    if (at == joints_.end())
      file_.fail(mimic, "there is no joint '" + leader + "' to follow.", "name one of the model's joints.");
    const ModelJoint& other = model_.joints[static_cast<std::size_t>(at->second)];
    const bool has_coordinate = other.type == ModelJoint::Type::revolute || other.type == ModelJoint::Type::prismatic;
    for (const auto& [follower, node] : mimics_)
      if (follower == at->second)
        file_.fail(mimic, "'" + joint.name + "' follows '" + leader + "', which follows another joint itself.",
                   "let it follow that one.");
    if (at->second == own || !has_coordinate)
      file_.fail(mimic, "'" + joint.name + "' cannot follow '" + leader + "'.",
                 "let a revolute or prismatic joint follow another one.");
    const double multiplier = file_.content(mimic, "multiplier", 1);
    joint.mimic = ModelJoint::Mimic{
        at->second, multiplier, file_.content(mimic, "offset", 0) - multiplier * file_.content(mimic, "reference", 0)};
  }

  const XmlFile& file_;
  double version_ = 0;
  ModelDescription model_;
  Notes notes_;
  std::vector<ModelPose> poses_;  // of the links, in the world
  std::map<std::string, int> links_, joints_;
  std::vector<std::pair<int, std::pair<pugi::xml_node, std::string>>> mimics_;
  // Of the model that is read
  pugi::xml_node model_node_;
  ModelPose model_pose_;
  std::map<std::string, ModelPose> frames_;
  std::set<std::string> open_;
};

}  // namespace

ModelDescription read_sdf(const std::filesystem::path& path) { return SdfReader(XmlFile(path)).read(); }

}  // namespace lithe
