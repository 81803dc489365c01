#include <algorithm>
#include <cmath>
#include <set>

#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/base/rotations.h"
#include "models/adams/read_adams_internal.h"
#include "models/read_model.h"

namespace lithe {
namespace adams {
namespace {

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

}  // namespace

ModelDescription Reader::read() {
  check_identifiers();
  made_.units = read_adams_units(file_);
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

void Reader::check_identifiers() {
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

Matrix3 Reader::axes_of_points(const Arguments& a, const char* z_name, const char* x_name, const Vector3& origin) {
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

Matrix3 Reader::orientation(const Arguments& a, const char* z_name, const char* x_name, const Vector3& origin) {
  if (a.has("REULER")) {
    if (a.has(z_name) || a.has(x_name)) a.fail("has REULER and points of its axes.", "give one of them.");
    return euler(a.vector("REULER", Vector3::Zero()));
  }
  if (a.has(z_name) || a.has(x_name)) return axes_of_points(a, z_name, x_name, origin);
  return Matrix3::Identity();
}

void Reader::add_part(const Statement& s, const Arguments& a) {
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

void Reader::add_marker(const Statement& s, const Arguments& a) {
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

const AdamsModel::MarkerFrame& Reader::marker_of(const Arguments& a, int id, const std::string& argument) {
  const auto at = made_.markers.find(id);
  if (at == made_.markers.end())
    a.fail("names MARKER/" + std::to_string(id) + " as " + argument + ", which is not there.",
           "name a marker of the file.");
  return at->second;
}

void Reader::add_mass(const Statement& s, const Arguments& a) {
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
  part.velocity = u.length / u.time * (v_axes * Vector3(a.number("VX", 0.0), a.number("VY", 0.0), a.number("VZ", 0.0)));
  part.angular_velocity = w_axes * Vector3(a.number("WX", 0.0), a.number("WY", 0.0), a.number("WZ", 0.0)) / u.time;
  if (a.has("EXACT"))
    notes_.add(s.line, "EXACT", "the start is moved as little as the joints want, in all coordinates");
}

Matrix3 Reader::world_axes(const AdamsModel::MarkerFrame& marker) const {
  return made_.parts[static_cast<std::size_t>(marker.part)].orientation * marker.orientation;
}

AdamsFunction Reader::function(const Arguments& a, const std::string& name) {
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

const Statement* Reader::statement(const std::string& keyword, int id) const {
  for (const Statement& s : file_.statements)
    if (s.keyword == keyword && s.id == id) return &s;
  return nullptr;
}

std::string Reader::variable_text(int id) {
  const Statement* s = statement("VARIABLE", id);
  if (!s) file_.fail(line_, "a function reads VARIABLE/" + std::to_string(id) + ", which is not there.", "give it.");
  return Arguments(file_, *s).text("FUNCTION");
}

AdamsCurve Reader::curve(int id, AdamsCurve::Kind kind) {
  const Statement* s = statement("SPLINE", id);
  if (!s) file_.fail(line_, "a function reads SPLINE/" + std::to_string(id) + ", which is not there.", "give it.");
  const Arguments a(file_, *s);
  check_spline(*s, a);
  return {a.numbers("X", 4, 1 << 24), a.numbers("Y", 4, 1 << 24), a.has("LINEAR_EXTRAPOLATE"), kind};
}

void Reader::check_spline(const Statement& s, const Arguments& a) {
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

void Reader::read(const Statement& s, const Arguments& a) {
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
    model_.gravity =
        u.length / (u.time * u.time) * Vector3(a.number("IGRAV", 0.0), a.number("JGRAV", 0.0), a.number("KGRAV", 0.0));
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
    notes_.add(s.line, k, reason == reasons().end() ? "it does not act on the motion, or is not read" : reason->second);
  }
}

void Reader::check_references() {
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

}  // namespace adams

ModelDescription read_adams(const std::filesystem::path& path) { return adams::Reader(path).read(); }

}  // namespace lithe
