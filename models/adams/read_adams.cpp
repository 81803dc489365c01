#include <algorithm>
#include <cmath>
#include <set>

#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/base/rotations.h"
#include "models/adams/adams_model.h"
#include "models/adams/adams_statements_internal.h"
#include "models/notes_internal.h"
#include "models/read_model.h"

namespace lithe {
namespace adams {
namespace {

struct Unit {
  const char* name;
  double value;
};
// Exact by definition, but for the pound-force and what follows from it: 0.45359237 kg * 9.80665 m/s².
constexpr Unit kForces[] = {{"NEWTON", 1},
                            {"KNEWTON", 1e3},
                            {"KILONEWTON", 1e3},
                            {"MILLINEWTON", 1e-3},
                            {"MEGANEWTON", 1e6},
                            {"DYNE", 1e-5},
                            {"KILOGRAM_FORCE", 9.80665},
                            {"POUND_FORCE", 0.45359237 * 9.80665},
                            {"KPOUND_FORCE", 453.59237 * 9.80665},
                            {"OUNCE_FORCE", 0.45359237 / 16 * 9.80665},
                            {"POUNDAL", 0.45359237 * 0.3048}};
constexpr Unit kMasses[] = {{"KILOGRAM", 1},
                            {"GRAM", 1e-3},
                            {"MEGAGRAM", 1e3},
                            {"TONNE", 1e3},
                            {"POUND_MASS", 0.45359237},
                            {"KPOUND_MASS", 453.59237},
                            {"OUNCE_MASS", 0.45359237 / 16},
                            {"SLUG", 0.45359237 * 9.80665 / 0.3048},
                            {"SLINCH", 0.45359237 * 9.80665 / 0.0254}};
constexpr Unit kLengths[] = {{"METER", 1},     {"MM", 1e-3},       {"MILLIMETER", 1e-3}, {"CENTIMETER", 1e-2},
                             {"CM", 1e-2},     {"KILOMETER", 1e3}, {"INCH", 0.0254},     {"FOOT", 0.3048},
                             {"FEET", 0.3048}, {"MILE", 1609.344}, {"MICROMETER", 1e-6}};
constexpr Unit kTimes[] = {{"SECOND", 1}, {"MILLISECOND", 1e-3}, {"MINUTE", 60}, {"HOUR", 3600}};

/// What becomes of statements that are known and do not act.
const std::map<std::string, std::string>& reasons() {
  static const std::map<std::string, std::string> all = {
      {"GRAPHICS", "pictures: pages draw bodies by their markers"},
      {"OUTPUT", "what Adams writes: take the requests as sensors"},
      {"RESULTS", "what Adams writes: take the requests as sensors"},
      {"CONTACT", "its shapes are in closed formats: add<Contact>() with shapes of your choice"},
      {"FRICTION", "add a JointFriction to the joint"},
      {"SENSOR", "events of a run: simulation.on(event)"},
      {"DIFF", "a differential equation of its own: use an IntegralState"},
      {"LSE", "a linear system of its own"},
      {"GSE", "a system in a user routine"},
      {"TFSISO", "a transfer function"},
      {"ARRAY", "numbers for user routines and states"},
      {"MATRIX", "numbers for user routines and states"},
      {"STRING", "text for user routines"},
      {"UCON", "a constraint in a user routine"},
      {"NFORCE", "a force among several markers in a user routine"},
      {"MFORCE", "a force on a flexible body in a user routine"},
      {"CVCV", "two curves in touch: SlidingJoint takes one"},
      {"PTCV", "a point on a curve: SlidingJoint"},
      {"CURVE", "no statement that reads it acts"},
      {"TIRE", "a tyre model"},
      {"LINEAR", "ask for linearize(system, state)"},
      {"DEACTIVATE", "the whole model acts"}};
  return all;
}

Matrix3 euler(const Vector3& angles) { return rotation_from_euler_313(angles[0], angles[1], angles[2]); }

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : file_(path) {
    model_.path = file_.path;
    model_.format = "Adams data set";
    model_.name = file_.title.substr(file_.title.find_last_of(" :\t") + 1);
    if (model_.name.empty()) model_.name = "model";
    names_.variable = [this](int id) { return variable_text(id); };
    names_.curve = [this](int id, AdamsCurve::Kind kind) { return curve(id, kind); };
    names_.fail = [this](const std::string& problem, const std::string& fix) { file_.fail(line_, problem, fix); };
  }

  ModelDescription read() {
    check_identifiers();
    read_units();
    for_each("PART", [&](const Statement& s, const Arguments& a) { add_part(s, a); });
    if (ground_ < 0) file_.fail(1, "no PART is GROUND.", "give PART/1, GROUND.");
    for_each("MARKER", [&](const Statement& s, const Arguments& a) { add_marker(s, a); });
    for_each("PART", [&](const Statement& s, const Arguments& a) { add_mass(s, a); });
    for (const Statement& statement : file_.statements) {
      line_ = statement.line;
      read(statement, Arguments(file_, statement));
    }
    check_references();
    model_.root = ground_;
    model_.notes = notes_.take();
    model_.adams = std::move(made_);
    return std::move(model_);
  }

 private:
  template <class Read>
  void for_each(const std::string& keyword, Read&& read) {
    for (const Statement& statement : file_.statements)
      if (statement.keyword == keyword) {
        line_ = statement.line;
        read(statement, Arguments(file_, statement));
      }
  }

  void check_identifiers() {
    std::map<std::string, int> seen;
    static const std::set<std::string> without = {"UNITS",      "ACCGRAV",     "OUTPUT",     "RESULTS",
                                                  "INTEGRATOR", "SIMULATE",    "END",        "PREFERENCES",
                                                  "DEBUG",      "EQUILIBRIUM", "KINEMATICS", "LINEAR"};
    for (const Statement& s : file_.statements) {
      if (without.count(s.keyword)) continue;
      if (s.id == 0) {
        if (reasons().count(s.keyword)) continue;
        file_.fail(s.line, "a " + s.keyword + " has no identifier.", "number it: " + s.keyword + "/12.");
      }
      if (const auto [at, added] = seen.try_emplace(s.name(), s.line); !added)
        file_.fail(s.line, "there are two " + s.name() + ": the first in line " + std::to_string(at->second) + ".",
                   "give each a number of its own.");
    }
  }

  template <std::size_t N>
  double unit(const Arguments& a, const char* name, const Unit (&known)[N]) {
    std::string all, text = a.text(name);
    for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    for (const Unit& one : known)
      if (text == one.name) return one.value;
    for (const Unit& one : known) {
      if (text.size() >= 2 && std::string(one.name).compare(0, text.size(), text) == 0) return one.value;
      all += std::string(all.empty() ? "" : ", ") + one.name;
    }
    a.fail("has " + (text.empty() ? "no " + std::string(name) : "the unknown " + std::string(name) + " " + text) + ".",
           "known are " + all + ".");
  }

  void read_units() {
    bool found = false;
    for_each("UNITS", [&](const Statement&, const Arguments& a) {
      if (found) a.fail("is there twice.", "give it once.");
      found = true;
      if (a.has("UCF")) a.fail("has UCF, a factor between force and mass times acceleration.", "give the four units.");
      if (a.has("SYSTEM")) {
        std::string text = a.text("SYSTEM");
        for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
        if (text == "CGS")
          made_.units = {.mass = 1e-3, .length = 1e-2, .time = 1, .force = 1e-5};
        else if (text != "MKS")
          a.fail("has SYSTEM = " + text.substr(0, 40) + ", which is not read.", "give FORCE, MASS, LENGTH and TIME.");
        return;
      }
      made_.units.force = unit(a, "FORCE", kForces);
      made_.units.mass = unit(a, "MASS", kMasses);
      made_.units.length = unit(a, "LENGTH", kLengths);
      made_.units.time = unit(a, "TIME", kTimes);
    });
    if (!found)
      file_.fail(1, "the data set has no UNITS.",
                 "give UNITS/FORCE = NEWTON, MASS = KILOGRAM, LENGTH = METER, TIME = SECOND, or those it is in.");
  }

  // ---- parts and markers ----

  /// Axes from points on z and in the xz plane, as of ZP, XP and ZG, XG.
  Matrix3 axes_of_points(const Arguments& a, const char* z_name, const char* x_name, const Vector3& origin) {
    const double L = made_.units.length;
    const auto direction = [&](const char* name) -> Vector3 {
      const Vector3 d = L * a.vector(name, Vector3::Zero()) - origin;
      if (!(d.norm() > 0)) a.fail("has " + std::string(name) + " in its own origin.", "give a point away from it.");
      return d;
    };
    try {
      if (!a.has(z_name)) {
        const Vector3 x = direction(x_name);
        // z is the global or part's z axis, as far as it is at right angles to x.
        return axes_along(Vector3::UnitZ() - x * (x.z() / x.squaredNorm()), x);
      }
      return a.has(x_name) ? axes_along(direction(z_name), direction(x_name)) : axes_along(direction(z_name));
    } catch (const SceneError& error) {
      a.fail("has points that give no axes: " + error.problem(), "give one on z, and one in the xz plane beside it.");
    }
  }

  Matrix3 orientation(const Arguments& a, const char* z_name, const char* x_name, const Vector3& origin) {
    if (a.has("REULER")) {
      if (a.has(z_name) || a.has(x_name)) a.fail("has REULER and points of its axes.", "give one of them.");
      return euler(a.vector("REULER", Vector3::Zero()));
    }
    if (a.has(z_name) || a.has(x_name)) return axes_of_points(a, z_name, x_name, origin);
    return Matrix3::Identity();
  }

  void add_part(const Statement& s, const Arguments& a) {
    const int place = static_cast<int>(made_.parts.size());
    AdamsModel::Part part{.id = s.id, .ground = a.has("GROUND")};
    part.position = made_.units.length * a.vector("QG", Vector3::Zero());
    part.orientation = orientation(a, "ZG", "XG", part.position);
    if (part.ground) {
      if (ground_ >= 0) a.fail("is GROUND, as another part is.", "one part is ground.");
      ground_ = place;
      part.position.setZero(), part.orientation.setIdentity();
    }
    part_places_[s.id] = place;
    made_.parts.push_back(part);
    ModelLink link{.name = "PART/" + std::to_string(s.id), .line = s.line};
    model_.links.push_back(link);
  }

  void add_marker(const Statement& s, const Arguments& a) {
    for (const char* what : {"POINT_MASS", "FLEX_BODY", "NODE_ID"})
      if (a.has(what))
        a.fail("lies on a " + std::string(what) + ", which is not read.",
               "flexible bodies come in by read_flexible_body(), in open formats.");
    const auto part = part_places_.find(a.identifier("PART"));
    if (part == part_places_.end())
      a.fail("lies on PART/" + std::to_string(a.identifier("PART")) + ", which is not there.",
             "name a part of the file.");
    AdamsModel::MarkerFrame marker{.part = part->second, .line = s.line};
    marker.position = made_.units.length * a.vector("QP", Vector3::Zero());
    marker.orientation = orientation(a, "ZP", "XP", marker.position);
    made_.markers[s.id] = marker;
  }

  const AdamsModel::MarkerFrame& marker_of(const Arguments& a, int id, const std::string& argument) {
    const auto at = made_.markers.find(id);
    if (at == made_.markers.end())
      a.fail("names MARKER/" + std::to_string(id) + " as " + argument + ", which is not there.",
             "name a marker of the file.");
    return at->second;
  }

  void add_mass(const Statement& s, const Arguments& a) {
    const AdamsUnits& u = made_.units;
    AdamsModel::Part& part = made_.parts[static_cast<std::size_t>(part_places_[s.id])];
    ModelLink& link = model_.links[static_cast<std::size_t>(part_places_[s.id])];
    if (part.ground) return;
    if (a.has("MATERIAL") && !a.has("MASS"))
      a.fail("has its mass by MATERIAL and geometry, which is not read.", "give MASS, CM and IP.");
    link.mass = u.mass * a.number("MASS", 0.0);
    if (!(link.mass > 0))
      a.fail("moves and has no mass.", "give it MASS, CM and IP; fix what is massless to a part by its markers.");
    const int cm = a.identifier("CM");
    const auto own = [&](int id, const std::string& name) -> const AdamsModel::MarkerFrame& {
      const AdamsModel::MarkerFrame& marker = marker_of(a, id, name);
      if (marker.part != part_places_[s.id])
        a.fail("has " + name + " = " + std::to_string(id) + " on another part.", "name a marker of its own.");
      return marker;
    };
    const AdamsModel::MarkerFrame &centre = own(cm, "CM"), &frame = own(a.identifier_if("IM").value_or(cm), "IM");
    // IP is about the origin of IM along its axes, the products as positive integrals.
    std::vector<double> ip = a.numbers("IP", 3, 6);
    if (ip.size() != 3 && ip.size() != 6)
      a.fail("has IP with " + std::to_string(ip.size()) + " numbers.", "give 3 or 6.");
    ip.resize(6, 0.0);
    Matrix3 J;
    J << ip[0], -ip[3], -ip[4], -ip[3], ip[1], -ip[5], -ip[4], -ip[5], ip[2];
    J *= u.mass * u.length * u.length;
    const Matrix3 d = skew(centre.position - frame.position);
    link.inertial = {centre.position, Matrix3::Identity()};
    link.inertia = frame.orientation * J * frame.orientation.transpose() + link.mass * d * d;
    link.inertia = (0.5 * (link.inertia + link.inertia.transpose())).eval();
    try {
      require::inertia(link.inertia, "IP");
    } catch (const SceneError& error) {
      a.fail("has an impossible inertia: " + error.problem() + ".", error.fix() + ".");
    }
    // Velocities: VX, VY, VZ along the global axes or those of VM, WX, WY, WZ along those of WM or CM.
    const Matrix3 v_axes =
        a.has("VM") ? world_axes(marker_of(a, a.identifier("VM"), "VM")) : Matrix3(Matrix3::Identity());
    const Matrix3 w_axes = world_axes(a.has("WM") ? marker_of(a, a.identifier("WM"), "WM") : centre);
    part.velocity =
        u.length / u.time * (v_axes * Vector3(a.number("VX", 0.0), a.number("VY", 0.0), a.number("VZ", 0.0)));
    part.angular_velocity = w_axes * Vector3(a.number("WX", 0.0), a.number("WY", 0.0), a.number("WZ", 0.0)) / u.time;
    if (a.has("EXACT"))
      notes_.add(s.line, "EXACT", "the start is moved as little as the joints want, in all coordinates");
  }

  Matrix3 world_axes(const AdamsModel::MarkerFrame& marker) const {
    return made_.parts[static_cast<std::size_t>(marker.part)].orientation * marker.orientation;
  }

  // ---- functions ----

  AdamsFunction function(const Arguments& a, const std::string& name) {
    if (const Argument* argument = a.find(name)) line_ = argument->line;
    const std::string text = a.text(name);
    if (text.empty()) a.fail("has no " + name + ".", "give " + name + " = an expression.");
    if (text.size() >= 4 && std::equal(text.begin(), text.begin() + 4, "USER",
                                       [](char x, char y) { return std::toupper(static_cast<unsigned char>(x)) == y; }))
      a.fail("has a user routine (USER(...)), which is not read.", "write " + name + " as an expression.");
    const AdamsFunction made = read_adams_function(text, line_, names_);
    for (const AdamsMeasure& m : made.measures)
      for (const int id : {m.i, m.j, m.k, m.l})
        if (id != 0 && !made_.markers.count(id))
          file_.fail(line_, "the function reads MARKER/" + std::to_string(id) + ", which is not there.",
                     "name a marker of the file.");
    return made;
  }

  const Statement* statement(const std::string& keyword, int id) const {
    for (const Statement& s : file_.statements)
      if (s.keyword == keyword && s.id == id) return &s;
    return nullptr;
  }

  std::string variable_text(int id) {
    const Statement* s = statement("VARIABLE", id);
    if (!s) file_.fail(line_, "a function reads VARIABLE/" + std::to_string(id) + ", which is not there.", "give it.");
    return Arguments(file_, *s).text("FUNCTION");
  }

  AdamsCurve curve(int id, AdamsCurve::Kind kind) {
    const Statement* s = statement("SPLINE", id);
    if (!s) file_.fail(line_, "a function reads SPLINE/" + std::to_string(id) + ", which is not there.", "give it.");
    const Arguments a(file_, *s);
    check_spline(*s, a);
    return {a.numbers("X", 4, 1 << 24), a.numbers("Y", 4, 1 << 24), a.has("LINEAR_EXTRAPOLATE"), kind};
  }

  void check_spline(const Statement& s, const Arguments& a) {
    if (a.has("FILE") || a.has("ROUTINE"))
      a.fail("takes its points from a file or routine, which is not read.", "give X and Y.");
    const auto curves =
        std::count_if(s.arguments.begin(), s.arguments.end(), [](const Argument& x) { return x.name == "Y"; });
    if (curves > 1) a.fail("is a family of curves, which is not read.", "give one Y.");
    const std::vector<double> x = a.numbers("X", 4, 1 << 24), y = a.numbers("Y", 1, 1 << 24);
    if (x.size() != y.size())
      a.fail("has " + std::to_string(x.size()) + " X and " + std::to_string(y.size()) + " Y.", "give as many of both.");
    for (std::size_t i = 1; i < x.size(); ++i)
      if (!(x[i] > x[i - 1])) a.fail("has X that do not rise.", "order the points, each X above the one before.");
  }

  // ---- all others ----

  std::pair<int, int> ends(const Arguments& a) {
    const int i = a.identifier("I"), j = a.identifier("J");
    const AdamsModel::MarkerFrame &I = marker_of(a, i, "I"), &J = marker_of(a, j, "J");
    if (I.part == J.part) a.fail("joins two markers of one part.", "name markers of two parts.");
    return {i, j};
  }

  void list(const Statement& s, const std::string& kind, int i, int j) {
    ModelJoint joint{.name = s.name(), .type = ModelJoint::Type::other, .line = s.line};
    joint.kind = kind;
    joint.parent = made_.markers.at(j).part;
    joint.child = made_.markers.at(i).part;
    model_.joints.push_back(joint);
  }

  /// The one of several names that is there.
  std::string kind_of(const Arguments& a, const std::vector<std::string>& kinds) {
    std::string found, all;
    for (const std::string& kind : kinds) {
      all += (all.empty() ? "" : ", ") + kind;
      if (!a.has(kind)) continue;
      if (!found.empty()) a.fail("is " + found + " and " + kind + ".", "give one of " + all + ".");
      found = kind;
    }
    if (found.empty()) a.fail("has no kind.", "give one of " + all + ".");
    return found;
  }

  void read(const Statement& s, const Arguments& a) {
    const AdamsUnits& u = made_.units;
    const std::string& k = s.keyword;
    if (k == "JOINT")
      add_joint(s, a);
    else if (k == "JPRIM") {
      const std::string kind =
          kind_of(a, {"ATPOINT", "INLINE", "INPLANE", "ORIENTATION", "PARALLEL_AXES", "PERPENDICULAR"});
      const auto [i, j] = ends(a);
      made_.joints[-s.id] = {s.name(), s.line, {.kind = kind, .primitive = true, .i = i, .j = j}};
      list(s, kind, i, j);
    } else if (k == "MOTION")
      add_motion(s, a);
    else if (k == "SFORCE")
      add_sforce(s, a);
    else if (k == "VFORCE" || k == "VTORQUE" || k == "GFORCE")
      add_components(s, a);
    else if (k == "SPRINGDAMPER")
      add_spring(s, a);
    else if (k == "BUSHING")
      add_bushing(s, a);
    else if (k == "BEAM")
      add_beam(s, a);
    else if (k == "FIELD")
      add_field(s, a);
    else if (k == "COUPLER")
      add_coupler(s, a);
    else if (k == "GEAR") {
      const std::vector<int> joints = a.identifiers("JOINTS", 2, 2);
      made_.gears.push_back({s.name(), s.line, {joints[0], joints[1], a.identifier("CV")}});
      marker_of(a, a.identifier("CV"), "CV");
      notes_.add(s.line, "bearing loads of GEAR", "it couples the angles of its joints by torques along them");
    } else if (k == "GCON") {
      AdamsFunction f = function(a, "FUNCTION");
      for (const AdamsMeasure& m : f.measures)
        if (!m.of_pose())
          file_.fail(s.line, s.name() + " depends on a velocity, acceleration or load.",
                     "constrain positions and angles alone.");
      refuse_euler_parameters(a, f);
      if (f.measures.empty()) a.fail("reads no marker: it constrains nothing.", "let it read displacements or angles.");
      made_.constraints.push_back({s.name(), s.line, {std::move(f)}});
      list_all(s, "GCON", made_.constraints.back().what.function);
    } else if (k == "REQUEST")
      add_request(s, a);
    else if (k == "VARIABLE") {
      if (a.has("ROUTINE")) a.fail("is computed by a routine, which is not read.", "give FUNCTION.");
      made_.variables.push_back({s.name(), s.line, function(a, "FUNCTION")});
    } else if (k == "SPLINE")
      check_spline(s, a);
    else if (k == "ACCGRAV") {
      if (a.has("GC"))
        notes_.add(s.line, "GC of ACCGRAV", "a factor between force and mass times acceleration: it is 1 in SI");
      model_.gravity = u.length / (u.time * u.time) *
                       Vector3(a.number("IGRAV", 0.0), a.number("JGRAV", 0.0), a.number("KGRAV", 0.0));
      has_gravity_ = true;
    } else if (k == "INTEGRATOR") {
      if (a.has("ERROR")) {
        model_.tolerance = a.number("ERROR");
        if (!(*model_.tolerance > 0)) a.fail("has ERROR that is not above zero.", "give a tolerance such as 1E-3.");
      }
      notes_.add(s.line, "the method of INTEGRATOR", "ours is chosen by the run; its ERROR is taken as the tolerance");
    } else if (k == "SIMULATE")
      add_simulation(s, a);
    else if (k != "PART" && k != "MARKER" && k != "UNITS" && k != "END") {
      if (k == "POINT_MASS" || k == "FLEX_BODY" || k == "FE_PART")
        a.fail("is a body that is not read.", k == "POINT_MASS" ? "make it a PART with a small IP."
                                                                : "flexible bodies come in by read_flexible_body().");
      const auto reason = reasons().find(k);
      notes_.add(s.line, k,
                 reason == reasons().end() ? "it does not act on the motion, or is not read" : reason->second);
    }
  }

  void add_joint(const Statement& s, const Arguments& a) {
    const std::string kind = kind_of(a, {"CONVEL", "CYLINDRICAL", "FIXED", "HOOKE", "PLANAR", "RACKPIN", "REVOLUTE",
                                         "SCREW", "SPHERICAL", "TRANSLATIONAL", "UNIVERSAL"});
    const auto [i, j] = ends(a);
    AdamsModel::Joint joint{.kind = kind, .i = i, .j = j};
    if (kind == "SCREW" || kind == "RACKPIN") {
      joint.value = made_.units.length * a.number(kind == "SCREW" ? "PITCH" : "PD");
      if (joint.value == 0) a.fail("has a pitch of zero.", "give a length.");
    }
    for (const char* name : {"IC", "ICROT", "ICTRAN"})
      if (a.has(name))
        notes_.add(s.line, std::string(name) + " of JOINT", "give the parts their velocities: VX ..., WX ...");
    for (const char* name : {"FRICTION", "DELTA_V", "MU1", "PRELOAD", "MAXIT"})
      if (a.has(name)) notes_.add(s.line, "friction of JOINT", "add a JointFriction");
    if (kind == "RACKPIN")
      notes_.add(s.line, "the sign of PD of RACKPIN beside the drawing",
                 "the pinion rolls on the side on which the rack is drawn, on that of -y of I if it is drawn through "
                 "its axis");
    made_.joints[s.id] = {s.name(), s.line, joint};
    list(s, kind, i, j);
  }

  void add_motion(const Statement& s, const Arguments& a) {
    if (a.has("ROUTINE")) a.fail("is in a routine, which is not read.", "give FUNCTION.");
    if (a.has("ACCELERATION"))
      a.fail("gives an acceleration, which is not read.", "give the displacement or the velocity.");
    AdamsModel::Motion motion{.rate = a.has("VELOCITY"), .function = function(a, "FUNCTION")};
    if (!motion.function.measures.empty()) a.fail("depends on more than TIME.", "let a control be a force: SFORCE.");
    if (a.has("JOINT")) {
      motion.joint = a.identifier("JOINT");
      const Statement* joint = statement("JOINT", motion.joint);
      if (!joint)
        a.fail("drives JOINT/" + std::to_string(motion.joint) + ", which is not there.", "name a joint of the file.");
      const Arguments of(file_, *joint);
      const bool rotation = of.has("REVOLUTE") || of.has("CYLINDRICAL"),
                 translation = of.has("TRANSLATIONAL") || of.has("CYLINDRICAL");
      if (!rotation && !translation)
        a.fail("drives a joint that has no rotation or translation of its own.",
               "drive a REVOLUTE, TRANSLATIONAL or CYLINDRICAL joint.");
      motion.rotation = a.has("ROTATION") || (!a.has("TRANSLATION") && rotation);
      if (motion.rotation ? !rotation : !translation)
        a.fail(
            std::string("drives the ") + (motion.rotation ? "rotation" : "translation") + " of a joint that has none.",
            "correct ROTATION or TRANSLATION.");
      motion.i = of.identifier("I"), motion.j = of.identifier("J");
    } else {
      const auto [i, j] = ends(a);
      motion.i = i, motion.j = j;
      const std::string kind = kind_of(a, {"X", "Y", "Z", "B1", "B2", "B3"});
      if (kind[0] == 'B') a.fail("drives an angle of markers, which is not read.", "drive a REVOLUTE joint.");
      motion.axis = kind[0] - 'X';
    }
    for (const char* name : {"ICDISP", "ICVEL"})
      if (a.has(name)) notes_.add(s.line, std::string(name) + " of MOTION", "the drawing is the start");
    made_.motions.push_back({s.name(), s.line, std::move(motion)});
    list(s, "MOTION", made_.motions.back().what.i, made_.motions.back().what.j);
  }

  void refuse_routine(const Arguments& a) {
    if (a.has("ROUTINE")) a.fail("is in a routine, which is not read.", "give functions.");
  }

  void refuse_euler_parameters(const Arguments& a, const AdamsFunction& f) {
    for (const AdamsMeasure& m : f.measures)
      if (m.kind >= AdamsMeasure::Kind::E0 && m.kind <= AdamsMeasure::Kind::E3)
        a.fail("reads Euler parameters (ORIENT), whose sign is free.", "read angles or displacements.");
  }

  void refuse_loads(const Arguments& a, const AdamsFunction& f) {
    for (const AdamsMeasure& m : f.measures)
      if (m.of_load() || m.of_acceleration())
        a.fail("depends on a load or an acceleration: an equation that only the whole system solves.",
               "let forces depend on time, displacements and velocities.");
    refuse_euler_parameters(a, f);
  }

  void add_sforce(const Statement& s, const Arguments& a) {
    using Kind = AdamsModel::Load::Kind;
    refuse_routine(a);
    const auto [i, j] = ends_or_one(a);
    const bool rotational = kind_of(a, {"TRANSLATIONAL", "ROTATIONAL"}) == "ROTATIONAL";
    AdamsModel::Load load{.kind = rotational ? Kind::about_z : Kind::along_line, .i = i, .j = j, .axes = j};
    if (a.has("ACTIONONLY")) load.kind = rotational ? Kind::on_i_about_z : Kind::on_i_along_z;
    load.functions[0] = function(a, "FUNCTION");
    refuse_loads(a, *load.functions[0]);
    made_.loads.push_back({s.name(), s.line, std::move(load)});
    list(s, rotational ? "SFORCE, rotational" : "SFORCE, translational", i, j);
  }

  std::pair<int, int> ends_or_one(const Arguments& a) {
    if (!a.has("ACTIONONLY")) return ends(a);
    const int i = a.identifier("I"), j = a.identifier("J");
    marker_of(a, i, "I"), marker_of(a, j, "J");
    return {i, j};
  }

  void add_components(const Statement& s, const Arguments& a) {
    refuse_routine(a);
    if (a.has("FUNCTION")) a.fail("is in a user routine (FUNCTION), which is not read.", "give its components.");
    const int i = a.identifier("I"), j = a.identifier("JFLOAT");
    if (marker_of(a, i, "I").part == marker_of(a, j, "JFLOAT").part)
      a.fail("acts between two markers of one part.", "name markers of two parts.");
    AdamsModel::Load load{
        .kind = AdamsModel::Load::Kind::components, .i = i, .j = j, .axes = a.identifier_if("RM").value_or(0)};
    if (load.axes) marker_of(a, load.axes, "RM");
    constexpr const char* kNames[] = {"FX", "FY", "FZ", "TX", "TY", "TZ"};
    bool any = false;
    for (std::size_t c = 0; c < 6; ++c)
      if (a.has(kNames[c])) {
        load.functions[c] = function(a, kNames[c]);
        refuse_loads(a, *load.functions[c]);
        any = true;
      }
    if (!any) a.fail("has no component.", "give FX, FY, FZ or TX, TY, TZ.");
    made_.loads.push_back({s.name(), s.line, std::move(load)});
    list(s, s.keyword, i, j);
  }

  void add_spring(const Statement& s, const Arguments& a) {
    const AdamsUnits& u = made_.units;
    const auto [i, j] = ends(a);
    AdamsModel::Spring spring{.i = i, .j = j, .rotation = kind_of(a, {"TRANSLATION", "ROTATION"}) == "ROTATION"};
    const bool r = spring.rotation;
    const double force = r ? u.torque() : u.force, length = r ? 1 : u.length;
    for (const char* name : {r ? "K" : "KT", r ? "C" : "CT", r ? "FORCE" : "TORQUE", r ? "LENGTH" : "ANGLE"})
      if (a.has(name))
        a.fail(std::string("has ") + name + ", which the other kind has.", "correct TRANSLATION or ROTATION.");
    spring.stiffness = force / length * a.number(r ? "KT" : "K", 0.0);
    spring.damping = force * u.time / length * a.number(r ? "CT" : "C", 0.0);
    spring.free_value = length * a.number(r ? "ANGLE" : "LENGTH", 0.0);
    spring.preload = force * a.number(r ? "TORQUE" : "FORCE", 0.0);
    if (spring.stiffness < 0 || spring.damping < 0)
      a.fail("has a negative stiffness or damping.", "give them above zero.");
    made_.springs.push_back({s.name(), s.line, spring});
    list(s, r ? "SPRINGDAMPER, rotation" : "SPRINGDAMPER, translation", i, j);
  }

  /// From matrices and vectors of the file, which act on (lengths, radians) and give (forces, torques), to SI.
  void add_scaled(const Statement& s, AdamsModel::Field field, const std::string& kind) {
    const AdamsUnits& u = made_.units;
    Vector6 load, inverse;
    load << Vector3::Constant(u.force), Vector3::Constant(u.torque());
    inverse << Vector3::Constant(1 / u.length), Vector3::Ones();
    field.stiffness = (load.asDiagonal() * field.stiffness * inverse.asDiagonal()).eval();
    field.damping = (u.time * load.asDiagonal() * field.damping * inverse.asDiagonal()).eval();
    field.free = field.free.cwiseQuotient(inverse).eval();
    field.preload = field.preload.cwiseProduct(load).eval();
    made_.fields.push_back({s.name(), s.line, field});
    list(s, kind, field.i, field.j);
  }

  void add_bushing(const Statement& s, const Arguments& a) {
    const auto [i, j] = ends(a);
    AdamsModel::Field field{.i = i, .j = j};
    const Vector3 zero = Vector3::Zero();
    const auto six = [&](const char* translation, const char* rotation) -> Vector6 {
      const Vector3 first = a.vector(translation, zero), second = a.vector(rotation, zero);  // both may throw
      return (Vector6() << first, second).finished();
    };
    field.stiffness = six("K", "KT").asDiagonal();
    field.damping = six("C", "CT").asDiagonal();
    field.preload = six("FORCE", "TORQUE");
    add_scaled(s, field, "BUSHING");
  }

  void add_beam(const Statement& s, const Arguments& a) {
    const auto [i, j] = ends(a);
    AdamsModel::Field field{.i = i, .j = j};
    if (a.has("FORMULATION") && a.text("FORMULATION") != "LINEAR")
      notes_.add(s.line, "FORMULATION of BEAM", "the linear beam acts; Beam is the geometrically exact one");
    const auto positive = [&](const char* name) {
      const double x = a.number(name);
      if (!(x > 0)) a.fail(std::string("has ") + name + " that is not above zero.", "correct it.");
      return x;
    };
    const double L = positive("LENGTH"), A = positive("AREA"), E = positive("EMODULUS"), G = positive("GMODULUS");
    const double ixx = positive("IXX"), iyy = positive("IYY"), izz = positive("IZZ");
    const double py = 12 * E * izz * a.number("ASY", 0.0) / (G * A * L * L);
    const double pz = 12 * E * iyy * a.number("ASZ", 0.0) / (G * A * L * L);
    Matrix6& K = field.stiffness;
    K(0, 0) = E * A / L;
    K(1, 1) = 12 * E * izz / (L * L * L * (1 + py));
    K(2, 2) = 12 * E * iyy / (L * L * L * (1 + pz));
    K(3, 3) = G * ixx / L;
    K(4, 4) = (4 + pz) * E * iyy / (L * (1 + pz));
    K(5, 5) = (4 + py) * E * izz / (L * (1 + py));
    K(1, 5) = K(5, 1) = -6 * E * izz / (L * L * (1 + py));
    K(2, 4) = K(4, 2) = 6 * E * iyy / (L * L * (1 + pz));
    field.free[0] = L;
    add_damping(a, field);
    add_scaled(s, field, "BEAM");
  }

  void add_field(const Statement& s, const Arguments& a) {
    refuse_routine(a);
    if (a.has("FUNCTION")) a.fail("is in a user routine (FUNCTION), which is not read.", "give KMATRIX.");
    if (a.has("FORMULATION")) notes_.add(s.line, "FORMULATION of FIELD", "the linear field acts");
    const auto [i, j] = ends(a);
    AdamsModel::Field field{.i = i, .j = j};
    field.stiffness = Eigen::Map<const Matrix6>(a.numbers("KMATRIX", 36, 36).data());  // by columns
    const auto six = [&](const char* name) -> Vector6 {
      if (!a.has(name)) return Vector6::Zero();
      return Eigen::Map<const Vector6>(a.numbers(name, 6, 6).data());
    };
    field.free = six("LENGTH"), field.preload = six("FORCE");
    add_damping(a, field);
    add_scaled(s, field, "FIELD");
  }

  void add_damping(const Arguments& a, AdamsModel::Field& field) {
    if (a.has("CRATIO") && a.has("CMATRIX")) a.fail("has CRATIO and CMATRIX.", "give one of them.");
    if (a.has("CRATIO")) field.damping = a.number("CRATIO") * field.stiffness;
    if (!a.has("CMATRIX")) return;
    const std::vector<double> c = a.numbers("CMATRIX", 21, 36);
    if (c.size() == 36) {
      field.damping = Eigen::Map<const Matrix6>(c.data());
    } else if (c.size() == 21) {  // the lower half, column by column
      std::size_t at = 0;
      for (int column = 0; column < 6; ++column)
        for (int row = column; row < 6; ++row) field.damping(row, column) = field.damping(column, row) = c[at++];
    } else {
      a.fail("has CMATRIX with " + std::to_string(c.size()) + " numbers.", "give 21 (BEAM) or 36 (FIELD).");
    }
  }

  void add_coupler(const Statement& s, const Arguments& a) {
    refuse_routine(a);
    if (a.has("FUNCTION")) a.fail("is in a user routine (FUNCTION), which is not read.", "give SCALES.");
    AdamsModel::Coupler coupler;
    coupler.joints = a.identifiers("JOINTS", 2, 3);
    const std::size_t n = coupler.joints.size();
    std::vector<double> scales = a.numbers("SCALES", 1, 3);
    if (scales.size() == n - 1) scales.insert(scales.begin(), 1.0);
    if (scales.size() != n) a.fail("has SCALES that do not fit its JOINTS.", "give one a joint.");
    std::string types;
    for (const char c : a.text("TYPE"))
      if (std::isalpha(static_cast<unsigned char>(c)))
        types += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    for (std::size_t i = 0; i < n; ++i) {
      const Statement* joint = statement("JOINT", coupler.joints[i]);
      if (!joint)
        a.fail("couples JOINT/" + std::to_string(coupler.joints[i]) + ", which is not there.", "name a joint.");
      const Arguments of(file_, *joint);
      const bool cylindrical = of.has("CYLINDRICAL"), rotation = of.has("REVOLUTE");
      if (!cylindrical && !rotation && !of.has("TRANSLATIONAL"))
        a.fail("couples " + joint->name() + ", which has no rotation or translation of its own.",
               "couple REVOLUTE, TRANSLATIONAL and CYLINDRICAL joints.");
      if (cylindrical && i >= types.size())
        a.fail("couples a CYLINDRICAL joint without saying how.", "give TYPE = T:R.");
      const bool turns = cylindrical ? types[i] == 'R' : rotation;
      coupler.rotation.push_back(turns);
      coupler.factors.push_back(scales[i] / (turns ? 1 : made_.units.length));
    }
    made_.couplers.push_back({s.name(), s.line, std::move(coupler)});
  }

  void list_all(const Statement& s, const std::string& kind, const AdamsFunction& f) {
    int i = 0, j = 0;
    for (const AdamsMeasure& m : f.measures) i = i ? i : m.i, j = j ? j : m.j;
    ModelJoint joint{.name = s.name(), .type = ModelJoint::Type::other, .line = s.line};
    joint.kind = kind;
    joint.parent = j ? made_.markers.at(j).part : ground_;
    joint.child = i ? made_.markers.at(i).part : ground_;
    model_.joints.push_back(joint);
  }

  void add_request(const Statement& s, const Arguments& a) {
    if (a.has("ROUTINE") || a.has("VARIABLES") || a.has("FUNCTION"))
      return notes_.add(s.line, "REQUEST of a routine or of VARIABLES", "give it as functions F1 to F8");
    AdamsModel::Request request{.comment = a.text("COMMENT").empty() ? a.text("TITLE") : a.text("COMMENT")};
    for (const char* kind : {"DISPLACEMENT", "VELOCITY", "ACCELERATION", "FORCE"})
      if (a.has(kind)) request.kind = kind[0];
    if (request.kind) {
      request.i = a.identifier("I");
      request.j = a.identifier_if("J").value_or(0);
      request.axes = a.identifier_if("RM").value_or(0);
      for (const int id : {request.i, request.j, request.axes})
        if (id) marker_of(a, id, "I, J or RM");
    } else {
      for (int c = 1; c <= 8; ++c)
        if (const std::string name = "F" + std::to_string(c); a.has(name)) {
          if (a.text(name).empty()) continue;
          request.functions.emplace(c, function(a, name));
        }
      if (request.functions.empty()) a.fail("asks for nothing.", "give DISPLACEMENT, I = ..., or F2 = an expression.");
    }
    made_.requests.push_back({s.name(), s.line, std::move(request)});
  }

  void add_simulation(const Statement& s, const Arguments& a) {
    if (a.has("STATIC") || a.has("STATICS") || a.has("INITIAL_CONDITIONS"))
      return notes_.add(s.line, "SIMULATE of statics or initial conditions", "ask for find_equilibrium(system, state)");
    const double T = made_.units.time;
    const double end = T * (a.has("END") ? a.number("END") : a.number("DURATION"));
    if (!(end > 0)) a.fail("ends at the time 0 or before.", "give END above zero.");
    model_.duration = end;
    if (a.has("DTOUT")) model_.every = T * a.number("DTOUT");
    if (a.has("STEPS")) model_.every = end / a.number("STEPS");
    if (model_.every && !(*model_.every > 0))
      a.fail("has no output step above zero.", "give DTOUT or STEPS above zero.");
  }

  /// What could only be checked once all is read.
  void check_references() {
    const auto need = [&](int line, const std::string& who, int joint) {
      if (!made_.joints.count(joint))
        file_.fail(line, who + " names JOINT/" + std::to_string(joint) + ", which is not there.",
                   "name a joint of the file.");
    };
    for (const auto& gear : made_.gears)
      need(gear.line, gear.name, gear.what.first), need(gear.line, gear.name, gear.what.second);
    std::set<std::string> known;
    for (const Statement& s : file_.statements) known.insert(s.name());
    const auto check = [&](const AdamsFunction& f) {
      for (const AdamsMeasure& m : f.measures)
        if (m.kind == AdamsMeasure::Kind::of_element && !known.count(m.element))
          file_.fail(f.line, "the function reads the load of " + m.element + ", which is not there.",
                     "name an element of the file.");
    };
    for (const auto& request : made_.requests)
      for (const auto& [column, f] : request.what.functions) check(f);
    for (const auto& variable : made_.variables) check(variable.what);
    if (!has_gravity_) model_.gravity.setZero();
  }

  DataSet file_;
  ModelDescription model_;
  AdamsModel made_;
  Notes notes_;
  AdamsNames names_;
  std::map<int, int> part_places_;
  int ground_ = -1, line_ = 0;
  bool has_gravity_ = false;
};

}  // namespace
}  // namespace adams

ModelDescription read_adams(const std::filesystem::path& path) { return adams::Reader(path).read(); }

}  // namespace lithe
