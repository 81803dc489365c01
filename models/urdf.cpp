#include <map>
#include <set>

#include "engine/base/error.h"
#include "engine/base/rotations.h"
#include "models/notes_internal.h"
#include "models/read_model.h"
#include "models/xml_file_internal.h"

namespace lithe {
namespace {

class UrdfReader {
 public:
  explicit UrdfReader(const XmlFile& file) : file_(file) {
    if (std::string(file_.root().name()) != "robot")
      file_.fail(file_.root(), "the root element is <" + std::string(file_.root().name()) + ">, not <robot>.",
                 "give a URDF file; a xacro file must be expanded first.");
    model_.name = file_.text(file_.root(), "name");
    model_.format = "URDF";
    model_.path = file.path();
  }

  ModelDescription read() {
    for (const pugi::xml_node& node : file_.root().children("link")) add_link(node);
    if (model_.links.empty()) file_.fail(file_.root(), "the robot has no link.", "give it at least one <link>.");
    for (const pugi::xml_node& node : file_.root().children("joint")) add_joint(node);
    for (const pugi::xml_node& node : file_.root().children("joint")) add_mimic(node);
    note_others(file_.root(), {"link", "joint", "material"});
    find_root();
    model_.notes = notes_.take();
    return std::move(model_);
  }

 private:
  ModelPose pose(const pugi::xml_node& origin) const {
    const Vector3 rpy = file_.vector(origin, "rpy", Vector3::Zero());
    return {file_.vector(origin, "xyz", Vector3::Zero()), rotation_from_euler_321(rpy[2], rpy[1], rpy[0])};
  }

  /// Tags below `node` other than the known ones.
  void note_others(const pugi::xml_node& node, const std::set<std::string>& known) {
    static const std::map<std::string, std::string> reasons = {
        {"transmission", "an actuator's wiring: drive the joint's coordinate by a CoordinateMotor or CoordinateDrive"},
        {"gazebo", "an extension for one simulator"},
        {"collision", "contact is given by add<Contact>() with shapes of your choice"},
        {"safety_controller", "a controller's limits"},
        {"calibration", "an encoder's reference position"},
        {"limit", "limits do not act: add a CoordinateStop"},
    };
    for (const pugi::xml_node& child : node.children()) {
      if (child.type() != pugi::node_element || known.count(child.name())) continue;
      const auto reason = reasons.find(child.name());
      notes_.add(file_.line(child), "<" + std::string(child.name()) + ">",
                 reason == reasons.end() ? "no tag of URDF that acts on motion" : reason->second);
    }
  }

  void add_shape(const pugi::xml_node& visual, ModelLink& link) {
    const pugi::xml_node geometry = visual.child("geometry");
    const ModelPose place = pose(visual.child("origin"));
    if (const pugi::xml_node box = geometry.child("box"))
      link.shapes.push_back(visual::box(file_.vector(box, "size", Vector3::Zero())));
    else if (const pugi::xml_node cylinder = geometry.child("cylinder"))
      link.shapes.push_back(visual::cylinder(file_.number(cylinder, "radius"), file_.number(cylinder, "length")));
    else if (const pugi::xml_node sphere = geometry.child("sphere"))
      link.shapes.push_back(visual::sphere(file_.number(sphere, "radius")));
    else
      return notes_.add(file_.line(visual), "<visual> of a mesh",
                        "mesh files are not read: pages show the links as sticks");
    link.shapes.back() = link.shapes.back().at(place.position, place.rotation);
  }

  void add_link(const pugi::xml_node& node) {
    ModelLink link{.name = file_.text(node, "name"), .line = file_.line(node)};
    if (!links_.try_emplace(link.name, static_cast<int>(model_.links.size())).second)
      file_.fail(node, "there are two links '" + link.name + "'.", "give each a name of its own.");
    if (const pugi::xml_node inertial = node.child("inertial")) {
      link.inertial = pose(inertial.child("origin"));
      link.mass = file_.number(inertial.child("mass") ? inertial.child("mass") : inertial, "value");
      if (link.mass < 0) file_.fail(inertial, "the mass of '" + link.name + "' is negative.", "give a mass in kg.");
      if (const pugi::xml_node I = inertial.child("inertia")) {
        const double xx = file_.number(I, "ixx"), yy = file_.number(I, "iyy"), zz = file_.number(I, "izz");
        const double xy = file_.number(I, "ixy", 0), xz = file_.number(I, "ixz", 0), yz = file_.number(I, "iyz", 0);
        link.inertia << xx, xy, xz, xy, yy, yz, xz, yz, zz;
      }
      note_others(inertial, {"origin", "mass", "inertia"});
    }
    try {
      for (const pugi::xml_node& visual : node.children("visual")) add_shape(visual, link);
    } catch (const SceneError& error) {
      file_.fail(node, error.problem(), error.fix());
    }
    note_others(node, {"inertial", "visual"});
    model_.links.push_back(std::move(link));
  }

  int find_link(const pugi::xml_node& joint, const char* side) const {
    const pugi::xml_node node = joint.child(side);
    if (!node)
      file_.fail(joint, std::string("the joint has no <") + side + ">.", "name a link: <parent link=\"...\"/>.");
    const std::string name = file_.text(node, "link");
    const auto at = links_.find(name);
    if (at == links_.end()) file_.fail(node, "there is no link '" + name + "'.", "name one of the file's links.");
    return at->second;
  }

  void add_joint(const pugi::xml_node& node) {
    using enum ModelJoint::Type;
    static const std::map<std::string, ModelJoint::Type> types = {{"fixed", fixed},         {"revolute", revolute},
                                                                  {"continuous", revolute}, {"prismatic", prismatic},
                                                                  {"planar", planar},       {"floating", floating}};
    ModelJoint joint{.name = file_.text(node, "name"), .line = file_.line(node)};
    if (!joints_.try_emplace(joint.name, static_cast<int>(model_.joints.size())).second)
      file_.fail(node, "there are two joints '" + joint.name + "'.", "give each a name of its own.");
    const std::string type = file_.text(node, "type");
    const auto known = types.find(type);
    if (known == types.end())
      file_.fail(node, "the joint '" + joint.name + "' is of the unknown type '" + type + "'.",
                 "known are revolute, continuous, prismatic, planar, floating, fixed.");
    joint.type = known->second;
    joint.parent = find_link(node, "parent");
    joint.child = find_link(node, "child");
    joint.origin = pose(node.child("origin"));
    const Vector3 axis = file_.vector(node.child("axis"), "xyz", Vector3::UnitX());
    if (joint.type != fixed && joint.type != floating && !(axis.norm() > 1e-12))
      file_.fail(node, "the axis of '" + joint.name + "' has no direction.", "give <axis xyz=\"0 0 1\"/> or another.");
    if (axis.norm() > 1e-12) joint.axis = axis.normalized();
    const pugi::xml_node dynamics = node.child("dynamics");
    joint.damping = file_.number(dynamics, "damping", 0);
    if (joint.damping < 0)
      file_.fail(dynamics, "the damping of '" + joint.name + "' is negative.", "give it in N m s/rad or N s/m.");
    if (file_.number(dynamics, "friction", 0) != 0)
      notes_.add(file_.line(dynamics), "friction of <dynamics>",
                 "dry friction needs the joint's reaction: add a JointFriction");
    if (joint.damping > 0 && (joint.type == planar || joint.type == floating || joint.type == fixed))
      notes_.add(file_.line(dynamics), "damping of a joint that is not revolute or prismatic",
                 "URDF does not say along which coordinates");
    note_others(node, {"origin", "parent", "child", "axis", "dynamics", "mimic"});
    model_.joints.push_back(std::move(joint));
  }

  void add_mimic(const pugi::xml_node& node) {
    const pugi::xml_node mimic = node.child("mimic");
    if (!mimic) return;
    const int own = joints_.at(node.attribute("name").as_string());
    ModelJoint& joint = model_.joints[own];
    const std::string leader = file_.text(mimic, "joint");
    const auto at = joints_.find(leader);
    if (at == joints_.end())
      file_.fail(mimic, "there is no joint '" + leader + "' to follow.", "name one of the file's joints.");
    const auto has_coordinate = [](const ModelJoint& j) {
      return j.type == ModelJoint::Type::revolute || j.type == ModelJoint::Type::prismatic;
    };
    if (at->second == own || !has_coordinate(joint) || !has_coordinate(model_.joints[at->second]))
      file_.fail(mimic, "'" + joint.name + "' cannot follow '" + leader + "'.",
                 "let a revolute or prismatic joint follow another one.");
    if (file_.root().find_child_by_attribute("joint", "name", leader.c_str()).child("mimic"))
      file_.fail(mimic, "'" + joint.name + "' follows '" + leader + "', which follows another joint itself.",
                 "let it follow that one.");
    joint.mimic = ModelJoint::Mimic{at->second, file_.number(mimic, "multiplier", 1), file_.number(mimic, "offset", 0)};
  }

  /// The one link that is no child; from it all others must be reached.
  void find_root() {
    const int n = static_cast<int>(model_.links.size());
    std::vector<int> parent(n, -1);
    for (const ModelJoint& joint : model_.joints) {
      if (parent[joint.child] >= 0)
        throw FileError("the link '" + model_.links[joint.child].name + "' is the child of two joints.",
                        file_.path() + ":" + std::to_string(joint.line),
                        "URDF holds trees: close the loop with a joint of the scene.");
      parent[joint.child] = joint.parent;
    }
    std::vector<std::string> roots;
    for (int i = 0; i < n; ++i)
      if (parent[i] < 0) {
        model_.root = i;
        roots.push_back(model_.links[i].name);
      }
    if (roots.empty())
      file_.fail(file_.root(), "the joints form a cycle: no link is the root.", "join all links into one tree.");
    if (roots.size() > 1)
      file_.fail(
          file_.root(),
          std::to_string(roots.size()) + " links have no parent, among them '" + roots[0] + "' and '" + roots[1] + "'.",
          "join all links into one tree.");
    for (int i = 0; i < n; ++i) {
      int steps = 0;
      for (int at = i; at != model_.root; at = parent[at])
        if (++steps > n)
          throw FileError("the link '" + model_.links[i].name + "' lies on a cycle of joints.",
                          file_.path() + ":" + std::to_string(model_.links[i].line), "URDF holds trees.");
    }
  }

  const XmlFile& file_;
  ModelDescription model_;
  Notes notes_;
  std::map<std::string, int> links_, joints_;
};

}  // namespace

ModelDescription read_urdf(const std::filesystem::path& path) { return UrdfReader(XmlFile(path)).read(); }

ModelDescription read_model(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (ending == ".adm") return read_adams(path);
  std::string root;
  {
    const XmlFile file(path);
    root = file.root().name();
    if (root != "robot" && root != "sdf" && root != "mujoco")
      file.fail(file.root(), "a file whose root element is <" + root.substr(0, 40) + "> is of no known format.",
                "known are URDF (<robot>), SDF (<sdf>), MJCF (<mujoco>), and Adams data sets (.adm).");
  }
  return root == "robot" ? read_urdf(path) : root == "sdf" ? read_sdf(path) : read_mjcf(path);
}

}  // namespace lithe
