#include "models/write_scene.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <set>
#include <typeindex>

#include "bodies/rigid_body.h"
#include "engine/assembly/system.h"
#include "engine/base/error.h"
#include "engine/model/system_graph.h"
#include "engine/observe/snapshot.h"
#include "joints/constant_velocity_joint.h"
#include "joints/coordinate_coupling.h"
#include "joints/cylindrical_joint.h"
#include "joints/fixed_joint.h"
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
#include "models/adams/adams_words_internal.h"

namespace lithe {
namespace {

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.15g", x);
  return text;
}
/// Of what was computed: without its round-off, beside a metre or a unit vector.
std::string place(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.14g", std::abs(x) < 1e-15 ? 0 : x);
  return text;
}
/// Of an inertia, however small.
std::string rounded(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.14g", x);
  return text;
}
std::string list(const Vector3& v, bool of_pose = true) {
  std::string all;
  for (int i = 0; i < 3; ++i) all += (i ? ", " : "") + (of_pose ? place(v[i]) : rounded(v[i]));
  return "{" + all + "}";
}
std::string matrix(const Matrix3& R, bool of_pose = true) {
  std::string all;
  for (int i = 0; i < 3; ++i) all += (i ? ", " : "") + list(R.row(i).transpose(), of_pose);
  return "rows(" + all + ")";
}
bool is_identity(const Matrix3& R) { return (R - Matrix3::Identity()).cwiseAbs().maxCoeff() < 1e-15; }

/// A text between quotes.
std::string quoted(const std::string& text) {
  std::string all = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') all += '\\';
    all += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return all + "\"";
}

class Writer {
 public:
  Writer(const ModelDescription& model, const DrawnModel::Options& options)
      : model_(model),
        options_(options),
        graph_({.gravity = model.gravity}),
        drawn_(draw_model(graph_, model, options)),
        system_(assemble(graph_)),
        now_(system_, system_.initial_state()) {}

  std::string write() {
    text_ += "// " + plain(model_.name) + ": written by lithe from a model file (" + model_.format + "). SI units.\n";
    text_ += "//   lithe run scene.cpp\n";
    for (const ModelNote& note : model_.notes)
      text_ +=
          "// Not here: " + plain(note.what) + " (line " + std::to_string(note.line) + "): " + plain(note.why) + "\n";
    text_ +=
        "#include <cstdio>\n#include <filesystem>\n\n#include \"lithe/lithe.h\"\n\nusing namespace lithe;\n\n"
        "/// A matrix by its rows.\n"
        "Matrix3 rows(const Vector3& x, const Vector3& y, const Vector3& z) {\n"
        "  Matrix3 R;\n  R << x.transpose(), y.transpose(), z.transpose();\n  return R;\n}\n\nint main() {\n"
        "  SystemGraph graph{{.gravity = " +
        list(model_.gravity) + "}};\n\n  // 1. Bodies, at their centres of mass.\n";
    for (const auto& entry : graph_.bodies())
      if (const auto* body = dynamic_cast<const RigidBody*>(entry.body)) add_body(*body);
    text_ += "\n  // 2. Joints, between markers.\n";
    for (const auto& entry : graph_.constraints()) add_constraint(entry);
    add_springs();
    add_couplings();
    add_rotors();
    if (model_.adams) add_functions(*model_.adams);
    add_run();
    return text_;
  }

 private:
  static std::string plain(std::string text) {
    for (char& c : text)
      if (static_cast<unsigned char>(c) < ' ' || c == '\\') c = ' ';
    return text;
  }

  /// A name of C++ for one of the file.
  std::string identifier(const std::string& name) {
    static const std::set<std::string> taken = {
        "graph",      "system",  "state",    "main",    "rows",    "integrator", "simulation", "recorder",
        "auto",       "bool",    "break",    "case",    "catch",   "char",       "class",      "const",
        "continue",   "default", "delete",   "do",      "double",  "else",       "enum",       "false",
        "float",      "for",     "goto",     "if",      "int",     "long",       "namespace",  "new",
        "operator",   "or",      "and",      "not",     "private", "public",     "register",   "return",
        "short",      "signed",  "sizeof",   "static",  "struct",  "switch",     "template",   "this",
        "throw",      "true",    "try",      "typedef", "union",   "unsigned",   "using",      "virtual",
        "void",       "while",   "volatile", "xor",     "adams",   "position",   "velocity",   "orientation",
        "coordinate", "every",   "assemble", "lithe",   "std"};
    std::string made;
    for (const char c : name) {
      const bool word = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
      if (word)
        made += c;
      else if (!made.empty() && made.back() != '_')
        made += '_';
    }
    if (made.empty() || (made[0] >= '0' && made[0] <= '9')) made = "n" + made;
    if (taken.count(made)) made += "_1";
    while (!names_.insert(made).second) made += "_";
    return made;
  }

  void add_body(const RigidBody& body) {
    const RigidBody::Parameters& p = body.parameters();
    const std::string& name = variables_[&body] = identifier(body.name());
    const Matrix3& J = p.inertia.matrix;
    const bool diagonal = Matrix3(J.diagonal().asDiagonal()) == J;
    text_ += "  auto& " + name + " = graph.add<RigidBody>(" + quoted(body.name()) + ", {.mass = " + number(p.mass) +
             ",\n      .inertia = " + (diagonal ? "Vector3" + list(J.diagonal(), false) : matrix(J, false)) +
             ",\n      .position = " + list(p.position);
    if (!is_identity(p.orientation)) text_ += ",\n      .orientation = " + matrix(p.orientation);
    if (!p.velocity.isZero(0)) text_ += ",\n      .velocity = " + list(p.velocity);
    if (!p.angular_velocity.isZero(0)) text_ += ",\n      .angular_velocity = " + list(p.angular_velocity);
    text_ += "});\n";
  }

  std::string marker(const Marker& m) {
    const MarkerKinematics k = now_.marker(m);
    const auto* body = dynamic_cast<const RigidBody*>(m.body);
    Vector3 r = k.p;
    Matrix3 R = k.R;
    if (body) {
      const RigidBody::Parameters& p = body->parameters();
      r = p.orientation.transpose() * (k.p - p.position);
      R = p.orientation.transpose() * k.R;
    }
    const std::string of = body ? variables_.at(body) : "graph.ground()";
    return of + ".marker(" + list(r) + (is_identity(R) ? "" : ", " + matrix(R)) + ")";
  }

  void add(const std::string& type, const Constraint& joint, const std::vector<Marker>& markers,
           const std::string& parameters = "") {
    const std::string& name = variables_[&joint] = identifier(joint.name());
    text_ += "  auto& " + name + " = graph.add<" + type + ">(" + quoted(joint.name()) + ", {" + marker(markers[0]) +
             ",\n      " + marker(markers[1]) + "}" + (parameters.empty() ? "" : ", {" + parameters + "}") + ");\n";
  }

  void add_constraint(const SystemGraph::ConstraintEntry& entry) {
    static const std::map<std::type_index, const char*> plain_types = {
        {typeid(RevoluteJoint), "RevoluteJoint"},
        {typeid(PrismaticJoint), "PrismaticJoint"},
        {typeid(CylindricalJoint), "CylindricalJoint"},
        {typeid(SphericalJoint), "SphericalJoint"},
        {typeid(UniversalJoint), "UniversalJoint"},
        {typeid(FixedJoint), "FixedJoint"},
        {typeid(PlanarJoint), "PlanarJoint"},
        {typeid(ConstantVelocityJoint), "ConstantVelocityJoint"},
        {typeid(PointOnLineJoint), "PointOnLineJoint"},
        {typeid(PointOnPlaneJoint), "PointOnPlaneJoint"},
        {typeid(OrientationJoint), "OrientationJoint"},
        {typeid(ParallelAxesJoint), "ParallelAxesJoint"},
        {typeid(PerpendicularAxesJoint), "PerpendicularAxesJoint"}};
    if (entry.type == typeid(CoordinateCoupling)) return;
    if (const auto known = plain_types.find(entry.type); known != plain_types.end())
      return add(known->second, *entry.constraint, entry.markers);
    for (const auto& [id, joint] : model_.adams->joints) {
      if (options_.prefix + joint.name != entry.constraint->name()) continue;
      if (entry.type == typeid(ScrewJoint))
        return add("ScrewJoint", *entry.constraint, entry.markers, ".lead = " + number(joint.what.value));
      const MarkerKinematics pinion = now_.marker(entry.markers[0]), rack = now_.marker(entry.markers[1]);
      const double radius = 0.5 * joint.what.value, side = (pinion.p - rack.p).dot(rack.R.col(1));
      return add("RackAndPinion", *entry.constraint, entry.markers,
                 ".radius = " + number(side < -0.1 * std::abs(radius) ? -radius : radius));
    }
  }

  /// "elbow.angle()", of a joint that was written.
  std::string coordinate_of(const Constraint& joint, bool rotation) const {
    return variables_.at(&joint) + (rotation ? ".angle()" : ".displacement()");
  }
  std::string coordinate_of(const ModelJoint& joint) const {
    return coordinate_of(drawn_.joint(joint.name), joint.type == ModelJoint::Type::revolute);
  }

  void add_springs() {
    bool first = true;
    const auto begin = [&] {
      if (first) text_ += title("Springs and dampers.");
      first = false;
    };
    for (const ModelJoint& joint : model_.joints) {
      const bool acts = options_.damping && (joint.damping > 0 || joint.stiffness > 0);
      if (!acts || (joint.type != ModelJoint::Type::revolute && joint.type != ModelJoint::Type::prismatic)) continue;
      begin();
      text_ += "  graph.add<CoordinateSpring>(" + quoted(options_.prefix + joint.name + "_spring") + ", {" +
               coordinate_of(joint) + "}, {.stiffness = " + number(joint.stiffness) +
               ", .damping = " + number(joint.damping) + ", .free_value = " + number(joint.spring_reference) + "});\n";
    }
    if (!model_.adams) return;
    for (const auto& [name, line, spring] : model_.adams->springs) {
      begin();
      const std::string J = marker(drawn_.adams_marker(spring.j)), I = marker(drawn_.adams_marker(spring.i));
      const std::string values = "{.stiffness = " + number(spring.stiffness) +
                                 ", .damping = " + number(spring.damping) +
                                 (spring.rotation ? ", .free_value = " : ", .natural_length = ") +
                                 number(spring.free_value) + ", .preload = " + number(-spring.preload) + "});\n";
      if (spring.rotation)
        text_ += "  graph.add<CoordinateSpring>(" + quoted(name) + ", {angle_between(" + J + ",\n      " + I + ")}, " +
                 values;
      else
        text_ += "  graph.add<SpringDamper>(" + quoted(name) + ", {" + J + ",\n      " + I + "}, " + values;
    }
  }

  void add_couplings() {
    for (const ModelJoint& joint : model_.joints)
      if (joint.mimic)
        text_ += "  graph.add<CoordinateCoupling>(" + quoted(options_.prefix + joint.name + "_mimic") + ", {" +
                 coordinate_of(joint) + ", " +
                 coordinate_of(model_.joints[static_cast<std::size_t>(joint.mimic->leader)]) + "}, {.factors = {1, " +
                 number(-joint.mimic->multiplier) + "}, .offset = " + number(joint.mimic->offset) + "});\n";
    if (!model_.adams) return;
    for (const auto& [name, line, coupler] : model_.adams->couplers) {
      std::string all, factors;
      for (std::size_t k = 0; k < coupler.joints.size(); ++k) {
        const std::string joint = "JOINT/" + std::to_string(coupler.joints[k]);
        all += (k ? ", " : "") + coordinate_of(drawn_.joint(joint), coupler.rotation[k]);
        factors += (k ? ", " : "") + number(coupler.factors[k]);
      }
      text_ +=
          "  graph.add<CoordinateCoupling>(" + quoted(name) + ", {" + all + "}, {.factors = {" + factors + "}});\n";
    }
    if (!model_.adams->gears.empty())
      throw SceneError("a GEAR is not written as C++.", model_.path + ":" + std::to_string(model_.adams->gears[0].line),
                       "run the data set itself: lithe model run.");
  }

  /// Motions, loads and constraints by functions, in the language of the data set.
  void add_functions(const AdamsModel& m) {
    std::set<int> read;
    std::string all;
    const auto function = [&](const AdamsFunction& f) {
      for (AdamsMeasure measure : f.measures)
        for (const int* id : adams::markers_of(measure)) read.insert(*id);
      return "adams.function(" + quoted(adams_text(f)) + ")";
    };
    const auto add = [&](const auto& element, const std::string& type, const std::string& fields) {
      all += "  adams.add(" + quoted(options_.prefix + element.name) + ", AdamsModel::" + type + "{" + fields + "});\n";
    };
    const auto ends = [&](const auto& what) {
      read.insert({what.i, what.j});
      return ".i = " + std::to_string(what.i) + ", .j = " + std::to_string(what.j);
    };
    for (const auto& motion : m.motions)
      at(motion, [&](const AdamsModel::Motion& what) {
        add(motion, "Motion",
            ends(what) + (what.rotation ? ", .rotation = true" : "") + (what.rate ? ", .rate = true" : "") +
                ", .axis = " + std::to_string(what.axis) + ",\n      .function = " + function(what.function));
      });
    for (const auto& gcon : m.constraints)
      at(gcon, [&](const AdamsModel::Constraint& what) {
        add(gcon, "Constraint", ".function = " + function(what.function));
      });
    for (const auto& load : m.loads)
      at(load, [&](const AdamsModel::Load& what) {
        static constexpr const char* kKinds[] = {"along_line", "about_z", "on_i_along_z", "on_i_about_z", "components"};
        std::string functions;
        for (std::size_t c = 0; c < 6; ++c)
          functions += (c ? ", " : "") + (what.functions[c] ? function(*what.functions[c]) : std::string("{}"));
        const std::string kind = kKinds[static_cast<std::size_t>(what.kind)], two = ends(what);
        read.insert(what.axes);
        add(load, "Load",
            ".kind = AdamsModel::Load::Kind::" + kind + ", " + two + ", .axes = " + std::to_string(what.axes) +
                ",\n      .functions = {{" + functions + "}}");
      });
    for (const auto& field : m.fields) {
      const AdamsModel::Field& what = field.what;
      add(field, "Field",
          ends(what) + ",\n      .stiffness = " + numbers("Matrix6", what.stiffness) + ",\n      .damping = " +
              numbers("Matrix6", what.damping) + ",\n      .free = " + numbers("Vector6", what.free) +
              ",\n      .preload = " + numbers("Vector6", what.preload));
    }
    if (all.empty()) return;
    text_ += title("By functions, in the language and the units of the data set; markers by its numbers.") +
             "  AdamsScene adams(graph, {.mass = " + number(m.units.mass) + ", .length = " + number(m.units.length) +
             ", .time = " + number(m.units.time) + ", .force = " + number(m.units.force) + "},\n      {";
    for (const int id : read)
      text_ += (id == *read.begin() ? "{" : ",\n       {") + std::to_string(id) + ", " +
               marker(drawn_.adams_marker(id)) + "}";
    text_ += "});\n" + all;
  }
  template <class Element, class Write>
  void at(const Element& element, Write&& write) {
    try {
      write(element.what);
    } catch (const SceneError& error) {
      throw SceneError(element.name + ": " + error.problem() + ", and is not written as C++.",
                       model_.path + ":" + std::to_string(element.line),
                       "run the data set itself: read_model() and draw_model(), or lithe model run.");
    }
  }
  /// Row by row.
  static std::string numbers(const std::string& type, ConstMatrixRef m) {
    std::string all;
    for (Eigen::Index r = 0; r < m.rows(); ++r)
      for (Eigen::Index c = 0; c < m.cols(); ++c) all += (r + c > 0 ? ", " : "") + number(m(r, c));
    return "(" + type + "() << " + all + ").finished()";
  }
  std::string title(const std::string& what) { return "\n  // " + std::to_string(++steps_) + ". " + what + "\n"; }

  /// Armature: a coordinate of unit mass that runs √a times as fast has the same kinetic energy.
  void add_rotors() {
    if (!options_.armature) return;
    for (const ModelJoint& joint : model_.joints) {
      if (!(joint.armature > 0) ||
          (joint.type != ModelJoint::Type::revolute && joint.type != ModelJoint::Type::prismatic))
        continue;
      const double root = std::sqrt(joint.armature);
      const double rate = coordinate_rate(drawn_.coordinate(joint.name), "rate").value(now_);
      const std::string name = identifier(joint.name + "_rotor");
      text_ += "  // Rotor of " + plain(joint.name) + ": " + number(joint.armature) +
               " kg m2 or kg, as a coordinate of unit mass that runs its square root times as fast.\n  auto& " + name +
               " = graph.add<IntegralState>(" + quoted(joint.name + "_rotor") + ", {.start = " + number(root * rate) +
               "});\n  graph.add<CoordinateCoupling>(" + quoted(joint.name + "_rotor_gear") + ", {" +
               coordinate_of(joint) + ", " + name + ".coordinate()}, {.factors = {" + number(root) + ", -1}});\n";
    }
  }

  void add_run() {
    const double duration = model_.duration.value_or(2), tolerance = model_.tolerance.value_or(1e-6);
    std::string sensors;
    for (const auto& entry : graph_.constraints()) {
      const bool turns = entry.type == typeid(RevoluteJoint);
      if (!turns && entry.type != typeid(PrismaticJoint)) continue;
      sensors += std::string(sensors.empty() ? "" : ",\n      ") + "coordinate(" +
                 coordinate_of(*entry.constraint, turns) + ", " + quoted(entry.constraint->name()) + ")";
    }
    for (const auto& entry : graph_.bodies())
      if (sensors.empty() && variables_.count(entry.body))
        sensors = "position(" + variables_.at(entry.body) + ".marker(), " + quoted(entry.body->name()) + ")";
    std::string file;
    for (const char c : model_.name.substr(0, 60)) file += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
    text_ += title("Let it move, and record it.") +
             "  const System system = assemble(graph);\n"
             "  State state = system.initial_state();\n  Recorder recorder{{" +
             sensors + "}};\n  Automatic integrator{{.tolerance = {.relative = " + number(tolerance) +
             ", .absolute = " + number(0.01 * tolerance) + "}}};\n  Simulation simulation{system, integrator};\n" +
             "  simulation.observe(recorder, every(" + number(model_.every.value_or(0.01 * duration)) +
             "));\n  simulation.run(state, " + number(duration) +
             ");\n  std::filesystem::create_directories(\"results\");\n  recorder.write_csv(\"results/" + file +
             ".csv\");\n  std::printf(\"results/" + file + ".csv\\n\");\n}\n";
  }

  const ModelDescription& model_;
  const DrawnModel::Options& options_;
  SystemGraph graph_;
  DrawnModel drawn_;
  System system_;
  Snapshot now_;
  std::string text_;
  int steps_ = 2;  // told so far
  std::map<const Element*, std::string> variables_;
  std::set<std::string> names_;
};

}  // namespace

std::string scene_text(const ModelDescription& model, const DrawnModel::Options& options) {
  return Writer(model, options).write();
}

void write_scene(const ModelDescription& model, const std::filesystem::path& path, const DrawnModel::Options& options) {
  const std::string text = scene_text(model, options);
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw FileError("the scene cannot be written.", path.string(), "give a path in a folder that exists.");
}

}  // namespace lithe
