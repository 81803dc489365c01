#include <cmath>
#include <map>
#include <set>

#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/base/rotations.h"
#include "models/link_graph_internal.h"
#include "models/notes_internal.h"
#include "models/read_model.h"
#include "models/xml_file_internal.h"

namespace lithe {
namespace {

using Attributes = std::map<std::string, std::string>;

/// The least rotation that takes the z axis there; for its opposite, half a turn about x, as MuJoCo has it.
Matrix3 z_turned_to(const Vector3& direction) {
  const Vector3 axis = Vector3::UnitZ().cross(direction);
  const double size = axis.norm();
  return rotation_about(size > 0 ? Vector3(axis / size) : Vector3::UnitX(), std::atan2(size, direction.z()));
}

class MjcfReader {
 public:
  explicit MjcfReader(const XmlFile& file) : file_(file) {
    if (std::string(file_.root().name()) != "mujoco")
      file_.fail(file_.root(), "the root element is <" + std::string(file_.root().name()) + ">, not <mujoco>.",
                 "give an MJCF file.");
    model_.name = file_.root().attribute("model").as_string("MuJoCo Model");
    model_.format = "MJCF";
    model_.path = file.path();
    model_.root_is_world = true;
  }

  ModelDescription read() {
    const pugi::xml_node root = file_.root();
    note_others(root, {"compiler", "option", "default", "worldbody", "equality"});
    read_settings(root);
    for (const pugi::xml_node& node : root.children("default")) add_class(node, "main", {});
    const pugi::xml_node world = root.child("worldbody");
    if (!world) file_.fail(root, "the file has no <worldbody>.", "give one, with bodies.");
    model_.links.push_back({.name = "world", .line = file_.line(world)});
    names_["world"] = 0;
    poses_.emplace_back();
    for (const pugi::xml_node& node : root.children("worldbody")) add_content(node, 0, "main");
    if (model_.links.size() == 1) file_.fail(world, "the world has no body.", "give at least one <body>.");
    for (const pugi::xml_node& node : root.children("equality"))
      for (const pugi::xml_node& one : node.children())
        if (one.type() == pugi::node_element) add_equality(one);
    model_.notes = notes_.take();
    return std::move(model_);
  }

 private:
  void note_others(const pugi::xml_node& node, const std::set<std::string>& known) {
    static const std::map<std::string, std::string> reasons = {
        {"actuator", "drive the joints' coordinates by CoordinateMotor or CoordinateDrive"},
        {"tendon", "add a Rope, a SpringDamper or a CoordinateCoupling"},
        {"contact", "contact is given by add<Contact>() with shapes of your choice"},
        {"asset", "meshes, textures and materials: mesh files are not read"},
        {"sensor", "ask for sensors of markers and joints"},
        {"keyframe", "give .positions to draw_model, --set to the command"},
        {"visual", "pictures"},
        {"statistic", "pictures"},
        {"size", "memory of one simulator"},
        {"custom", "numbers for user programs"},
        {"extension", "a plug-in of one simulator"},
        {"deformable", "flexible bodies come in by read_flexible_body()"},
        {"site", "a named frame: take a marker of the body"},
        {"camera", "pictures"},
        {"light", "pictures"},
        {"plugin", "a plug-in of one simulator"},
        {"composite", "bodies made by a simulator"},
        {"flexcomp", "bodies made by a simulator"},
        {"flag", "settings of one simulator"}};
    for (const pugi::xml_node& child : node.children()) {
      if (child.type() != pugi::node_element || known.count(child.name())) continue;
      const std::string name = child.name();
      if (name == "include" || name == "replicate" || name == "attach" || name == "frame" || name == "model")
        file_.fail(child, "<" + name + "> is not read.", "put what it stands for into the file.");
      const auto reason = reasons.find(name);
      if (reason == reasons.end())
        file_.fail(child, "<" + name + "> is no tag that MJCF has in <" + node.name() + ">.",
                   "correct its name, or leave it out.");
      notes_.add(file_.line(child), "<" + name + ">", reason->second);
    }
  }

  void read_settings(const pugi::xml_node& root) {
    for (const pugi::xml_node& c : root.children("compiler")) {
      const std::string angle = c.attribute("angle").as_string("degree");
      if (angle != "degree" && angle != "radian")
        file_.fail(c, "angle=\"" + angle + "\" is no unit of angles.", "give degree or radian.");
      unit_ = angle == "degree" ? M_PI / 180 : 1;
      sequence_ = c.attribute("eulerseq").as_string("xyz");
      if (sequence_.size() != 3 || sequence_.find_first_not_of("xyzXYZ") != std::string::npos)
        file_.fail(c, "eulerseq=\"" + sequence_ + "\" is no sequence of axes.", "give three of x, y, z, X, Y, Z.");
      if (std::string(c.attribute("coordinate").as_string("local")) != "local")
        file_.fail(c, "global coordinates are not read.", "give coordinate=\"local\".");
      inertia_from_geom_ = c.attribute("inertiafromgeom").as_string("auto");
      for (const char* name : {"settotalmass", "balanceinertia", "boundmass", "boundinertia"})
        if (c.attribute(name) && c.attribute(name).as_double(1) > 0 &&
            std::string(c.attribute(name).as_string()) != "false")
          notes_.add(file_.line(c), std::string(name) + " of <compiler>", "masses and inertias act as given");
    }
    for (const pugi::xml_node& o : root.children("option")) {
      model_.gravity = file_.vector(o, "gravity", Vector3(0, 0, -9.81));
      for (const char* name :
           {"timestep", "integrator", "solver", "iterations", "tolerance", "cone", "jacobian", "impratio"})
        if (o.attribute(name))
          notes_.add(file_.line(o), std::string(name) + " of <option>", "the method is that of the run");
      for (const char* name : {"wind", "density", "viscosity"})
        if (o.attribute(name))
          notes_.add(file_.line(o), std::string(name) + " of <option>", "a medium: add UserForces");
      note_others(o, {});
    }
  }

  // ---- default classes ----

  /// What a class sets, tag by tag: that of the class that it lies in, and its own.
  using Class = std::map<std::string, Attributes>;
  void add_class(const pugi::xml_node& node, const std::string& fallback, const Class& above) {
    const std::string name = node.attribute("class").as_string(fallback.c_str());
    if (name.empty()) file_.fail(node, "the default class has no name.", "give class=\"...\".");
    if (++depth_ > 200) file_.fail(node, "default classes are nested too deep.", "nest them less.");
    Class own = above;
    for (const pugi::xml_node& tag : node.children())
      if (tag.type() == pugi::node_element && std::string(tag.name()) != "default")
        for (const pugi::xml_attribute& a : tag.attributes()) own[tag.name()][a.name()] = a.value();
    classes_[name] = own;
    for (const pugi::xml_node& inner : node.children("default")) add_class(inner, "", own);
    --depth_;
  }

  /// A copy of the element with what its class sets and it does not.
  pugi::xml_node complete(const pugi::xml_node& node, const std::string& childclass) {
    std::string name = node.attribute("class").as_string(childclass.c_str());
    const auto found = classes_.find(name);
    if (found == classes_.end()) {
      if (name == "main") return node;
      file_.fail(node, "there is no default class '" + name + "'.", "name one of <default>.");
    }
    const auto tag = found->second.find(node.name());
    if (tag == found->second.end()) return node;
    pugi::xml_node changed = node;  // a handle: the document itself is completed
    for (const auto& [key, value] : tag->second) {
      if (changed.attribute(key.c_str())) continue;
      if (is_orientation(key) && has_orientation(node)) continue;
      changed.append_attribute(key.c_str()) = value.c_str();
    }
    return changed;
  }
  static bool is_orientation(const std::string& key) {
    return key == "quat" || key == "axisangle" || key == "euler" || key == "xyaxes" || key == "zaxis";
  }
  static bool has_orientation(const pugi::xml_node& node) {
    for (const pugi::xml_attribute& a : node.attributes())
      if (is_orientation(a.name())) return true;
    return false;
  }

  // ---- frames ----

  std::vector<double> list(const pugi::xml_node& node, const char* name, int least, int most) const {
    return file_.numbers(node, std::string(node.name()) + " " + name, node.attribute(name).as_string(), least, most);
  }
  Vector3 direction(const pugi::xml_node& node, const char* name, const Vector3& v) const {
    if (!(v.norm() > 1e-12))
      file_.fail(node, std::string(name) + " has no direction.", "give a vector that is not zero.");
    return v.normalized();
  }

  Matrix3 orientation(const pugi::xml_node& node) const {
    if (node.attribute("quat")) {
      const std::vector<double> e = list(node, "quat", 4, 4);
      const Eigen::Quaterniond q(e[0], e[1], e[2], e[3]);
      if (!(q.norm() > 1e-12)) file_.fail(node, "the quaternion is zero.", "give w x y z.");
      return q.normalized().toRotationMatrix();
    }
    if (node.attribute("axisangle")) {
      const std::vector<double> a = list(node, "axisangle", 4, 4);
      return rotation_about(direction(node, "axisangle", {a[0], a[1], a[2]}), unit_ * a[3]);
    }
    if (node.attribute("euler")) {
      const std::vector<double> a = list(node, "euler", 3, 3);
      Matrix3 R = Matrix3::Identity();
      for (std::size_t i = 0; i < 3; ++i) {
        const bool moving = std::islower(static_cast<unsigned char>(sequence_[i]));
        const int axis = std::tolower(static_cast<unsigned char>(sequence_[i])) - 'x';
        const Matrix3 turn = rotation_about(Vector3::Unit(axis), unit_ * a[i]);
        R = moving ? Matrix3(R * turn) : Matrix3(turn * R);
      }
      return R;
    }
    try {
      if (node.attribute("xyaxes")) {
        const std::vector<double> a = list(node, "xyaxes", 6, 6);
        const Vector3 x(a[0], a[1], a[2]), y(a[3], a[4], a[5]);
        return axes_along(x.cross(y), x);
      }
      if (node.attribute("zaxis")) {
        const Vector3 z = direction(node, "zaxis", file_.vector(node, "zaxis", Vector3::Zero()));
        return z_turned_to(z);
      }
    } catch (const SceneError& error) {
      file_.fail(node, error.problem(), error.fix());
    }
    return Matrix3::Identity();
  }
  ModelPose pose(const pugi::xml_node& node) const {
    return {file_.vector(node, "pos", Vector3::Zero()), orientation(node)};
  }

  // ---- bodies ----

  void add_content(const pugi::xml_node& node, int link, const std::string& childclass) {
    if (link == 0)
      for (const pugi::xml_node& geom : node.children("geom")) add_geom(complete(geom, childclass), link, nullptr);
    note_others(node, {"body", "inertial", "joint", "freejoint", "geom"});
    for (const pugi::xml_node& body : node.children("body")) add_body(body, link, childclass);
  }

  void add_body(const pugi::xml_node& node, int parent, const std::string& above) {
    if (++depth_ > 500) file_.fail(node, "bodies are nested deeper than 500.", "no robot is.");
    const std::string childclass = node.attribute("childclass").as_string(above.c_str());
    const int own = static_cast<int>(model_.links.size());
    ModelLink link{.line = file_.line(node)};
    link.name = node.attribute("name").as_string();
    if (link.name.empty()) link.name = "body" + std::to_string(own);
    if (!names_.try_emplace(link.name, own).second)
      file_.fail(node, "there are two bodies '" + link.name + "'.", "give each a name of its own.");
    if (node.attribute("mocap").as_bool())
      notes_.add(file_.line(node), "mocap of <body>", "what it is moved by is not in the file: it stays");
    const ModelPose at = pose(node);
    poses_.push_back(poses_[static_cast<std::size_t>(parent)] * at);
    // Mass from <inertial>, or from geoms.
    const pugi::xml_node inertial = node.child("inertial");
    const bool from_geoms = inertia_from_geom_ == "true" || (inertia_from_geom_ == "auto" && !inertial);
    Masses masses;
    model_.links.push_back(link);
    for (const pugi::xml_node& geom : node.children("geom"))
      add_geom(complete(geom, childclass), own, from_geoms ? &masses : nullptr);
    ModelLink& made = model_.links[static_cast<std::size_t>(own)];
    if (from_geoms)
      masses.finish(made);
    else if (inertial)
      read_inertial(inertial, made);
    try {
      check_inertia(made);
    } catch (const SceneError& error) {
      file_.fail(node, error.problem(), error.fix());
    }
    add_joints(node, parent, own, at, childclass);
    add_content(node, own, childclass);
    --depth_;
  }

  void read_inertial(const pugi::xml_node& node, ModelLink& link) {
    link.mass = file_.number(node, "mass");
    if (link.mass < 0) file_.fail(node, "the mass of '" + link.name + "' is negative.", "give a mass in kg.");
    link.inertial = pose(node);
    if (node.attribute("fullinertia")) {  // xx yy zz xy xz yz
      const std::vector<double> I = list(node, "fullinertia", 6, 6);
      link.inertia << I[0], I[3], I[4], I[3], I[1], I[5], I[4], I[5], I[2];
    } else if (node.attribute("diaginertia")) {
      link.inertia = file_.vector(node, "diaginertia", Vector3::Zero()).asDiagonal();
    }
  }

  /// Masses of geoms, put together.
  struct Masses {
    double mass = 0;
    Vector3 moment = Vector3::Zero();
    Matrix3 inertia = Matrix3::Zero();  // about the body's origin
    void add(double m, const Matrix3& J, const ModelPose& at) {
      const Matrix3 c = skew(at.position);
      mass += m;
      moment += m * at.position;
      inertia += at.rotation * J * at.rotation.transpose() - m * c * c;
    }
    void finish(ModelLink& link) const {
      if (!(mass > 0)) return;
      link.mass = mass;
      link.inertial.position = moment / mass;
      const Matrix3 c = skew(link.inertial.position);
      link.inertia = inertia + mass * c * c;
      link.inertia = (0.5 * (link.inertia + link.inertia.transpose())).eval();
    }
  };

  void add_geom(const pugi::xml_node& node, int link, Masses* masses) {
    const std::string type =
        node.attribute("mesh") && !node.attribute("type") ? "mesh" : node.attribute("type").as_string("sphere");
    ModelPose at = pose(node);
    if (type == "plane" || type == "hfield" || type == "sdf")
      return notes_.add(file_.line(node), "<geom> that is a " + type, "contact is given by add<Contact>()");
    if (type == "mesh") {
      notes_.add(file_.line(node), "<geom> of a mesh", "mesh files are not read: pages show the links as sticks");
      if (masses && node.attribute("mass").as_double(1) > 0 && node.attribute("density").as_double(1) > 0)
        file_.fail(node,
                   "the mass of '" + model_.links[static_cast<std::size_t>(link)].name +
                       "' is that of a mesh, which is not read.",
                   "give the body an <inertial>.");
      return;
    }
    std::vector<double> size = node.attribute("size") ? list(node, "size", 1, 3) : std::vector<double>{};
    const bool round = type == "capsule" || type == "cylinder", three = type == "box" || type == "ellipsoid";
    if (!round && !three && type != "sphere")
      file_.fail(node, "a geom of the unknown type '" + type + "'.",
                 "known are sphere, capsule, cylinder, ellipsoid, box, plane, mesh, hfield.");
    if (node.attribute("fromto")) {
      const std::vector<double> ends = list(node, "fromto", 6, 6);
      const Vector3 a(ends[0], ends[1], ends[2]), b(ends[3], ends[4], ends[5]);
      if (type == "sphere" || !((b - a).norm() > 1e-12))
        file_.fail(node, "fromto gives no length.", "give two points.");
      at = {0.5 * (a + b), z_turned_to(b - a)};
      size.resize(1);
      if (three) size.push_back(size[0]);
      size.push_back(0.5 * (b - a).norm());
    }
    const std::size_t wanted = three ? 3 : round ? 2 : 1;
    if (size.size() < wanted)
      file_.fail(node, "a " + type + " has " + std::to_string(size.size()) + " sizes.",
                 "give " + std::to_string(wanted) + ".");
    for (std::size_t i = 0; i < wanted; ++i)
      if (!(size[i] > 0)) file_.fail(node, "a " + type + " has a size that is not above zero.", "give sizes in m.");
    const double r = size[0], r2 = r * r;
    // Volume, and moments of inertia of unit density.
    double volume = 4.0 / 3 * M_PI * r2 * r;
    Vector3 J = Vector3::Constant(0.4 * volume * r2);
    DrawnShape shape;
    if (type == "sphere") {
      shape = visual::sphere(r);
    } else if (type == "box") {
      const Vector3 h(size[0], size[1], size[2]), s = h.cwiseAbs2();
      volume = 8 * h.prod();
      J = volume / 3 * Vector3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
      shape = visual::box(2 * h);
    } else if (type == "ellipsoid") {
      const Vector3 h(size[0], size[1], size[2]), s = h.cwiseAbs2();
      volume = 4.0 / 3 * M_PI * h.prod();
      J = volume / 5 * Vector3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
      shape = visual::sphere(std::cbrt(h.prod()));
      notes_.add(file_.line(node), "the shape of an ellipsoid", "pages draw a sphere of its volume");
    } else {
      const double h = size[1], rod = 2 * M_PI * r2 * h, ball = volume;
      J = Vector3(rod * (r2 / 4 + h * h / 3), rod * (r2 / 4 + h * h / 3), 0.5 * rod * r2);
      volume = rod;
      if (type == "capsule") {  // two half balls, their centres 3 r / 8 beyond the ends
        volume += ball;
        const double across = ball * (0.4 * r2 + h * h + 0.75 * h * r);
        J += Vector3(across, across, 0.4 * ball * r2);
        shape = visual::capsule(r, 2 * h);
      } else {
        shape = visual::cylinder(r, 2 * h);
      }
    }
    model_.links[static_cast<std::size_t>(link)].shapes.push_back(shape.at(at.position, at.rotation));
    if (!masses) return;
    const double mass = file_.number(node, "mass", file_.number(node, "density", 1000) * volume);
    if (mass < 0) file_.fail(node, "a geom has a negative mass.", "give kg, or a density in kg/m³.");
    if (mass > 0) masses->add(mass, (mass / volume * J).asDiagonal(), at);
  }

  // ---- joints ----

  struct Degree {
    std::string name;
    std::string type;
    Vector3 position, axis;
    pugi::xml_node node;
  };

  void add_joints(const pugi::xml_node& node, int parent, int own, const ModelPose& at, const std::string& childclass) {
    std::vector<Degree> all;
    for (const pugi::xml_node& child : node.children()) {
      const bool free = std::string(child.name()) == "freejoint";
      if (!free && std::string(child.name()) != "joint") continue;
      const pugi::xml_node joint = free ? child : complete(child, childclass);
      Degree degree{.node = joint};
      degree.name = joint.attribute("name").as_string();
      if (degree.name.empty())
        degree.name = model_.links[static_cast<std::size_t>(own)].name + "_joint" + std::to_string(all.size());
      degree.type = free ? "free" : joint.attribute("type").as_string("hinge");
      degree.position = file_.vector(joint, "pos", Vector3::Zero());
      degree.axis = direction(joint, "axis", file_.vector(joint, "axis", Vector3::UnitZ()));
      if (degree.type != "hinge" && degree.type != "slide" && degree.type != "ball" && degree.type != "free")
        file_.fail(joint, "the joint '" + degree.name + "' is of the unknown type '" + degree.type + "'.",
                   "known are hinge, slide, ball, free.");
      note_joint(joint, degree);
      all.push_back(degree);
    }
    ModelJoint joint{.parent = parent, .child = own, .line = file_.line(node)};
    joint.name = all.empty() ? model_.links[static_cast<std::size_t>(own)].name + "_fixed" : all[0].name;
    using enum ModelJoint::Type;
    std::string types;
    for (const Degree& d : all) types += d.type[0];
    Vector3 position = all.empty() ? Vector3(Vector3::Zero()) : all[0].position;
    const auto one_place = [&] {
      for (const Degree& d : all)
        if ((d.position - position).norm() > 1e-12) return false;
      return true;
    };
    const auto across = [&](std::size_t a, std::size_t b) { return std::abs(all[a].axis.dot(all[b].axis)) < 1e-9; };
    if (types.empty()) {
      joint.type = fixed;
    } else if (types == "h" || types == "s") {
      joint.type = types == "h" ? revolute : prismatic;
      joint.axis = all[0].axis;
      read_dynamics(all[0].node, joint);
    } else if (types == "b" || (types == "hhh" && one_place())) {
      joint.type = spherical;
    } else if (types == "f" || types == "sssb" || types == "ssshhh") {
      joint.type = floating;
    } else if (types == "hh" && one_place() && across(0, 1)) {
      joint.type = universal;
      joint.axis = all[0].axis, joint.second_axis = all[1].axis;
    } else if (types == "ssh" && across(0, 1) && across(0, 2) && across(1, 2)) {
      joint.type = planar;
      joint.axis = all[2].axis;
      position = all[2].position;
    } else {
      file_.fail(
          all[0].node,
          "the body '" + model_.links[static_cast<std::size_t>(own)].name + "' has joints (" + types +
              ") that are not read together.",
          "one hinge or slide, a ball, a free joint; of several: two hinges at right angles, three hinges, three "
          "slides and a ball, two slides and the hinge across: else put a body with mass between them.");
    }
    if (all.size() > 1)
      notes_.add(file_.line(all[0].node), "coordinates of several joints of one body",
                 "they move as one joint: their springs, damping and armature do not act");
    if (joint.type == spherical && all.size() == 1 && has_dynamics(all[0].node))
      notes_.add(file_.line(all[0].node), "springs, damping and armature of a ball joint", "add a Bushing");
    if (joint.type == floating && parent != 0) joint.line = file_.line(all[0].node);
    joint.origin = at * ModelPose{position, Matrix3::Identity()};
    joint.child_origin = {position, Matrix3::Identity()};
    for (const Degree& d : all)
      if (!joints_.try_emplace(d.name, static_cast<int>(model_.joints.size())).second)
        file_.fail(d.node, "there are two joints '" + d.name + "'.", "give each a name of its own.");
    model_.joints.push_back(joint);
  }

  static bool has_dynamics(const pugi::xml_node& node) {
    return node.attribute("damping").as_double() != 0 || node.attribute("stiffness").as_double() != 0 ||
           node.attribute("armature").as_double() != 0;
  }

  void note_joint(const pugi::xml_node& node, const Degree&) {
    const int line = file_.line(node);
    if (node.attribute("range")) notes_.add(line, "range of <joint>", "limits do not act: add a CoordinateStop");
    if (file_.number(node, "frictionloss", 0) != 0)
      notes_.add(line, "frictionloss of <joint>", "dry friction needs the joint's reaction: add a JointFriction");
    if (file_.number(node, "ref", 0) != 0) notes_.add(line, "ref of <joint>", "coordinates count from the drawing");
    if (node.attribute("springdamper")) notes_.add(line, "springdamper of <joint>", "give stiffness and damping");
  }

  void read_dynamics(const pugi::xml_node& node, ModelJoint& joint) {
    const bool turns = joint.type == ModelJoint::Type::revolute;
    joint.damping = file_.number(node, "damping", 0);
    joint.stiffness = file_.number(node, "stiffness", 0);
    joint.spring_reference = (turns ? unit_ : 1) * file_.number(node, "springref", 0);
    joint.armature = file_.number(node, "armature", 0);
    if (joint.damping < 0 || joint.stiffness < 0 || joint.armature < 0)
      file_.fail(node, "the damping, stiffness or armature of '" + joint.name + "' is negative.",
                 "give it in SI units.");
  }

  // ---- equalities ----

  int body(const pugi::xml_node& node, const char* name) const {
    const std::string text = node.attribute(name).as_string("world");
    const auto at = names_.find(text);
    if (at == names_.end()) file_.fail(node, "there is no body '" + text + "'.", "name one of the file's bodies.");
    return at->second;
  }

  void add_equality(const pugi::xml_node& given) {
    const pugi::xml_node node = complete_equality(given);
    const std::string kind = node.name();
    if (std::string(node.attribute("active").as_string("true")) == "false")
      return notes_.add(file_.line(node), "<" + kind + "> of <equality> that is not active", "it says so");
    if (node.attribute("solref") || node.attribute("solimp"))
      notes_.add(file_.line(node), "solref, solimp of <equality>", "it holds exactly");
    if (kind == "joint") return add_coupling(node);
    if (kind != "connect" && kind != "weld") {
      static const std::set<std::string> known = {"tendon", "distance", "flex", "flexvert", "flexstrain"};
      if (!known.count(kind))
        file_.fail(node, "<" + kind + "> is no tag that MJCF has in <equality>.", "known are connect, weld, joint.");
      return notes_.add(file_.line(node), "<" + kind + "> of <equality>", "it is not read");
    }
    if (node.attribute("site1") || node.attribute("site2"))
      file_.fail(node, "an equality between sites is not read.", "give body1, body2 and an anchor.");
    file_.text(node, "body1");
    ModelJoint joint{.name = node.attribute("name").as_string(), .closes_loop = true, .line = file_.line(node)};
    joint.child = body(node, "body1"), joint.parent = body(node, "body2");
    if (joint.child == joint.parent) file_.fail(node, "the equality joins a body to itself.", "name two bodies.");
    if (joint.name.empty()) joint.name = kind + std::to_string(model_.joints.size());
    if (!joints_.try_emplace(joint.name, static_cast<int>(model_.joints.size())).second)
      file_.fail(node, "there are two joints or equalities '" + joint.name + "'.", "give each a name of its own.");
    joint.type = kind == "connect" ? ModelJoint::Type::spherical : ModelJoint::Type::fixed;
    if (kind == "connect") file_.text(node, "anchor");
    joint.child_origin.position = file_.vector(node, "anchor", Vector3::Zero());  // in body1
    joint.origin = seen_from(poses_[static_cast<std::size_t>(joint.parent)],
                             poses_[static_cast<std::size_t>(joint.child)] * joint.child_origin);
    if (kind == "weld" && node.attribute("relpose")) {
      const std::vector<double> p = list(node, "relpose", 7, 7);
      const Eigen::Quaterniond e(p[3], p[4], p[5], p[6]);
      if (e.norm() > 1e-12)  // of body2 in body1; zero: as drawn
        notes_.add(file_.line(node), "relpose of <weld>", "the bodies are held as drawn");
    }
    model_.joints.push_back(joint);
  }
  pugi::xml_node complete_equality(const pugi::xml_node& node) {
    const auto found = classes_.find(node.attribute("class").as_string("main"));
    if (found == classes_.end()) return node;
    const auto tag = found->second.find("equality");
    if (tag == found->second.end()) return node;
    pugi::xml_node changed = node;
    for (const auto& [key, value] : tag->second)
      if (!changed.attribute(key.c_str())) changed.append_attribute(key.c_str()) = value.c_str();
    return changed;
  }

  /// joint1 = a0 + a1 joint2.
  void add_coupling(const pugi::xml_node& node) {
    const auto find = [&](const char* name) {
      const std::string text = file_.text(node, name);
      const auto at = joints_.find(text);
      if (at == joints_.end()) file_.fail(node, "there is no joint '" + text + "'.", "name one of the file's joints.");
      const ModelJoint& joint = model_.joints[static_cast<std::size_t>(at->second)];
      if (joint.closes_loop || (joint.type != ModelJoint::Type::revolute && joint.type != ModelJoint::Type::prismatic))
        file_.fail(node, "the joint '" + text + "' has no coordinate of its own.", "couple hinges and slides.");
      return at->second;
    };
    const int own = find("joint1");
    std::vector<double> a = {0, 1, 0, 0, 0};
    if (node.attribute("polycoef")) a = list(node, "polycoef", 1, 5);
    a.resize(5, 0.0);
    if (!node.attribute("joint2"))
      return notes_.add(file_.line(node), "<joint> of <equality> on one joint", "add a CoordinateDrive that holds it");
    if (a[2] != 0 || a[3] != 0 || a[4] != 0)
      return notes_.add(file_.line(node), "<joint> of <equality> that is not linear", "couplings are linear");
    const int leader = find("joint2");
    if (leader == own) file_.fail(node, "a joint is coupled to itself.", "name two joints.");
    ModelJoint& joint = model_.joints[static_cast<std::size_t>(own)];
    if (joint.mimic || model_.joints[static_cast<std::size_t>(leader)].mimic)
      file_.fail(node, "a joint that follows another one is coupled again.", "couple all to one joint.");
    for (const ModelJoint& other : model_.joints)
      if (other.mimic && other.mimic->leader == own)
        file_.fail(node, "a joint that another one follows is coupled again.", "couple all to one joint.");
    joint.mimic = ModelJoint::Mimic{leader, a[1], a[0]};
  }

  const XmlFile& file_;
  ModelDescription model_;
  Notes notes_;
  double unit_ = M_PI / 180;
  std::string sequence_ = "xyz", inertia_from_geom_ = "auto";
  std::map<std::string, Class> classes_;
  std::vector<ModelPose> poses_;  // of the links, in the world
  std::map<std::string, int> names_, joints_;
  int depth_ = 0;
};

}  // namespace

ModelDescription read_mjcf(const std::filesystem::path& path) { return MjcfReader(XmlFile(path)).read(); }

}  // namespace lithe
