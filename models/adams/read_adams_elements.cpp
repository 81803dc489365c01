#include <algorithm>
#include <cmath>
#include <set>

#include "engine/base/error.h"
#include "models/adams/read_adams_internal.h"

/// Joints, motions, loads and outputs of a data set.
namespace lithe::adams {

std::pair<int, int> Reader::ends(const Arguments& a) {
  const int i = a.identifier("I"), j = a.identifier("J");
  const AdamsModel::MarkerFrame &I = marker_of(a, i, "I"), &J = marker_of(a, j, "J");
  if (I.part == J.part) a.fail("joins two markers of one part.", "name markers of two parts.");
  return {i, j};
}

void Reader::list(const Statement& s, const std::string& kind, int i, int j) {
  ModelJoint joint{.name = s.name(), .type = ModelJoint::Type::other, .line = s.line};
  joint.kind = kind;
  joint.parent = made_.markers.at(j).part;
  joint.child = made_.markers.at(i).part;
  model_.joints.push_back(joint);
}

std::string Reader::kind_of(const Arguments& a, const std::vector<std::string>& kinds) {
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

void Reader::add_joint(const Statement& s, const Arguments& a) {
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

void Reader::add_motion(const Statement& s, const Arguments& a) {
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
      a.fail(std::string("drives the ") + (motion.rotation ? "rotation" : "translation") + " of a joint that has none.",
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

void Reader::refuse_routine(const Arguments& a) {
  if (a.has("ROUTINE")) a.fail("is in a routine, which is not read.", "give functions.");
}

void Reader::refuse_euler_parameters(const Arguments& a, const AdamsFunction& f) {
  for (const AdamsMeasure& m : f.measures)
    if (m.kind >= AdamsMeasure::Kind::E0 && m.kind <= AdamsMeasure::Kind::E3)
      a.fail("reads Euler parameters (ORIENT), whose sign is free.", "read angles or displacements.");
}

void Reader::refuse_loads(const Arguments& a, const AdamsFunction& f) {
  for (const AdamsMeasure& m : f.measures)
    if (m.of_load() || m.of_acceleration())
      a.fail("depends on a load or an acceleration: an equation that only the whole system solves.",
             "let forces depend on time, displacements and velocities.");
  refuse_euler_parameters(a, f);
}

void Reader::add_sforce(const Statement& s, const Arguments& a) {
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

std::pair<int, int> Reader::ends_or_one(const Arguments& a) {
  if (!a.has("ACTIONONLY")) return ends(a);
  const int i = a.identifier("I"), j = a.identifier("J");
  marker_of(a, i, "I"), marker_of(a, j, "J");
  return {i, j};
}

void Reader::add_components(const Statement& s, const Arguments& a) {
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

void Reader::add_spring(const Statement& s, const Arguments& a) {
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

void Reader::add_scaled(const Statement& s, AdamsModel::Field field, const std::string& kind) {
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

void Reader::add_bushing(const Statement& s, const Arguments& a) {
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

void Reader::add_beam(const Statement& s, const Arguments& a) {
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

void Reader::add_field(const Statement& s, const Arguments& a) {
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

void Reader::add_damping(const Arguments& a, AdamsModel::Field& field) {
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

void Reader::add_coupler(const Statement& s, const Arguments& a) {
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
    if (!joint) a.fail("couples JOINT/" + std::to_string(coupler.joints[i]) + ", which is not there.", "name a joint.");
    const Arguments of(file_, *joint);
    const bool cylindrical = of.has("CYLINDRICAL"), rotation = of.has("REVOLUTE");
    if (!cylindrical && !rotation && !of.has("TRANSLATIONAL"))
      a.fail("couples " + joint->name() + ", which has no rotation or translation of its own.",
             "couple REVOLUTE, TRANSLATIONAL and CYLINDRICAL joints.");
    if (cylindrical && i >= types.size()) a.fail("couples a CYLINDRICAL joint without saying how.", "give TYPE = T:R.");
    const bool turns = cylindrical ? types[i] == 'R' : rotation;
    coupler.rotation.push_back(turns);
    coupler.factors.push_back(scales[i] / (turns ? 1 : made_.units.length));
  }
  made_.couplers.push_back({s.name(), s.line, std::move(coupler)});
}

void Reader::list_all(const Statement& s, const std::string& kind, const AdamsFunction& f) {
  int i = 0, j = 0;
  for (const AdamsMeasure& m : f.measures) i = i ? i : m.i, j = j ? j : m.j;
  ModelJoint joint{.name = s.name(), .type = ModelJoint::Type::other, .line = s.line};
  joint.kind = kind;
  joint.parent = j ? made_.markers.at(j).part : ground_;
  joint.child = i ? made_.markers.at(i).part : ground_;
  model_.joints.push_back(joint);
}

void Reader::add_request(const Statement& s, const Arguments& a) {
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

void Reader::add_simulation(const Statement& s, const Arguments& a) {
  if (a.has("STATIC") || a.has("STATICS") || a.has("INITIAL_CONDITIONS"))
    return notes_.add(s.line, "SIMULATE of statics or initial conditions", "ask for find_equilibrium(system, state)");
  const double T = made_.units.time;
  const double end = T * (a.has("END") ? a.number("END") : a.number("DURATION"));
  if (!(end > 0)) a.fail("ends at the time 0 or before.", "give END above zero.");
  model_.duration = end;
  if (a.has("DTOUT")) model_.every = T * a.number("DTOUT");
  if (a.has("STEPS")) model_.every = end / a.number("STEPS");
  if (model_.every && !(*model_.every > 0)) a.fail("has no output step above zero.", "give DTOUT or STEPS above zero.");
}

}  // namespace lithe::adams
