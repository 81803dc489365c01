#include "engine/observe/sensors.h"

#include <algorithm>

#include "engine/assembly/evaluator.h"
#include "engine/model/deformable_body.h"
#include "engine/model/marker_motions.h"
#include "engine/model/placeless_body.h"

namespace lithe {
namespace {

using Names = std::vector<std::string>;

const Names kXyz = {"_x", "_y", "_z"};
const Names kQuaternion = {"_w", "_x", "_y", "_z"};
const Names kWrenchUnits = {"N", "N", "N", "N m", "N m", "N m"};
const Names kWrench = {"_force_x", "_force_y", "_force_z", "_moment_x", "_moment_y", "_moment_z"};

/// A sensor called `name`, or `otherwise` where no name was given; `endings` make its columns.
Sensor make_sensor(Located name, const std::string& otherwise, const Names& endings, const Names& units,
                   Sensor::Reading reading, Marker path = {}) {
  if (name.text.empty()) name.text = otherwise;
  Names columns;
  for (const std::string& ending : endings) columns.push_back(name.text + ending);
  return {std::move(name), std::move(columns), std::move(reading), units, path};
}

std::string text_of(const Marker& marker) { return marker.body->name() + "_m" + std::to_string(marker.index); }

void check(const Marker& marker, const Located& name) {
  if (!marker.body)
    throw SceneError("a sensor's marker belongs to no body", to_string(name.where),
                     "make markers with body.marker(...)");
  if (marker.index < 0 || marker.index >= marker.body->marker_count())
    throw SceneError("marker " + std::to_string(marker.index) + " does not exist on body '" + marker.body->name() + "'",
                     to_string(name.where), "make markers with body.marker(...)");
}

void check_place(const Element& element, int marker, int count, const Located& name) {
  if (marker >= 0 && marker < count) return;
  throw SceneError("'" + element.name() + "' has no marker number " + std::to_string(marker), to_string(name.where),
                   "its markers are numbered 0 to " + std::to_string(count - 1) + ", in the order of its list");
}

/// A sensor of a marker's motion: `vector(snapshot, marker)` gives its columns.
template <class VectorOf>
Sensor marker_sensor(const Marker& marker, Located name, const std::string& quantity, const Names& endings,
                     const std::string& unit, VectorOf&& vector, Marker path = {}) {
  check(marker, name);
  return make_sensor(
      std::move(name), text_of(marker) + quantity, endings, {unit},
      [marker, vector](Snapshot& now, std::span<double> values) {
        const auto x = vector(now, marker);
        std::copy(x.data(), x.data() + x.size(), values.begin());
      },
      path);
}

// ---- loads ----

/// The entry of a joint or force in the snapshot's graph, with its markers.
const SystemGraph::ConstraintEntry& entry_of(const SystemGraph& graph, const Constraint& joint) {
  for (const auto& entry : graph.constraints())
    if (entry.constraint == &joint) return entry;
  throw SceneError("'" + joint.name() + "' is not in this system", joint.where(), "use a joint of the assembled graph");
}
const SystemGraph::ForceEntry& entry_of(const SystemGraph& graph, const ForceElement& force) {
  for (const auto& entry : graph.forces())
    if (entry.force == &force) return entry;
  throw SceneError("'" + force.name() + "' is not in this system", force.where(), "use a force of the assembled graph");
}

/// The multipliers of a joint's rows. Its entry is looked up first: joints of two graphs may bear one name.
const double* multipliers_of(Snapshot& now, const Constraint& joint) {
  entry_of(now.system().graph(), joint);
  return now.multipliers().data() + now.system().rows(joint).first;
}

MarkerMotions motions_of(Snapshot& now, const std::vector<Marker>& markers) {
  return {markers, [&](const Marker& m) { return now.marker(m); }};
}

/// What a joint does to the body at one of its markers: -Σ_rows W λ.
Wrench wrench_of(Snapshot& now, const Constraint& joint, int marker) {
  const MarkerMotions markers = motions_of(now, entry_of(now.system().graph(), joint).markers);
  ConstraintRows rows(joint.marker_count());
  rows.recall(now.quarter_turns_of(joint));
  joint.evaluate(now.time(), markers, rows);
  const double* multiplier = multipliers_of(now, joint);
  Wrench sum{Vector3::Zero(), Vector3::Zero()};
  for (int r = 0; r < rows.count(); ++r) {
    sum.force -= multiplier[r] * rows.wrench(r, marker).force;
    sum.torque -= multiplier[r] * rows.wrench(r, marker).torque;
  }
  return sum;
}

/// A force element at a snapshot.
ForceRows rows_of(Snapshot& now, const ForceElement& force) {
  const MarkerMotions markers = motions_of(now, entry_of(now.system().graph(), force).markers);
  ForceRows rows(force.marker_count());
  rows.recall(now.quarter_turns_of(force));
  if (const Constraint* joint = force.reaction_of()) rows.set_reaction(wrench_of(now, *joint, 1));
  force.evaluate(now.time(), markers, rows);
  return rows;
}

/// What a force element does to the body at one of its markers: its load - Σ_rows W σ.
Wrench wrench_of(Snapshot& now, const ForceElement& force, int marker) {
  const ForceRows rows = rows_of(now, force);
  Wrench sum = rows.load(marker);
  for (int r = 0; r < rows.count(); ++r) {
    sum.force -= rows.tension(r) * rows.wrench(r, marker).force;
    sum.torque -= rows.tension(r) * rows.wrench(r, marker).torque;
  }
  return sum;
}

void write_wrench(Snapshot& now, const Wrench& w, const Marker& axes, std::span<double> values) {
  const Matrix3 R = axes == kWorldAxes ? Matrix3::Identity() : now.marker(axes).R;
  Eigen::Map<Vector3>(values.data()) = R.transpose() * w.force;
  Eigen::Map<Vector3>(values.data() + 3) = R.transpose() * w.torque;
}

template <class Connector>
Sensor wrench_sensor(const Connector& connector, int marker, const Marker& axes, Located name) {
  check_place(connector, marker, connector.marker_count(), name);
  if (axes != kWorldAxes) check(axes, name);
  return make_sensor(std::move(name), connector.name() + "_m" + std::to_string(marker), kWrench, kWrenchUnits,
                     [&connector, marker, axes](Snapshot& now, std::span<double> values) {
                       write_wrench(now, wrench_of(now, connector, marker), axes, values);
                     });
}

/// Σ wrench · (v, w) over the markers.
template <class Element>
Sensor power_sensor(const Element& element, Located name) {
  return make_sensor(std::move(name), element.name() + "_power", {""}, {"W"},
                     [&element](Snapshot& now, std::span<double> values) {
                       values[0] = 0;
                       for (int m = 0; m < element.marker_count(); ++m) {
                         const Marker& marker = element.markers()[m];
                         const auto* states = dynamic_cast<const PlacelessBody*>(marker.body);
                         if (states && !states->has_energy()) continue;
                         const Wrench w = wrench_of(now, element, m);
                         const MarkerKinematics k = now.marker(marker);
                         values[0] += w.force.dot(k.v) + w.torque.dot(k.w);
                       }
                     });
}

// ---- coordinates ----

MeasuredCoordinate measured(Snapshot& now, const JointCoordinate& x) {
  const MarkerKinematics A = now.marker(x.A), B = now.marker(x.B);
  MeasuredCoordinate measured = measure(x.kind, x.axis, {A, 0}, {B, 1});
  if (const int place = now.system().find_angle(x); place >= 0 && x.is_angle()) {
    AngleMemory memory;
    memory.recall(now.state().quarter_turns.data());
    measured.value = memory.wound(place, measured.value);
  }
  return measured;
}

template <class ValueOf>
Sensor coordinate_sensor(const JointCoordinate& x, Located name, const std::string& per_time, ValueOf&& value) {
  check(x.A, name);
  check(x.B, name);
  const std::string otherwise = text_of(x.B) + "_against_" + text_of(x.A);
  const std::string unit = (x.is_angle() ? "rad" : "m") + per_time;
  return make_sensor(std::move(name), otherwise, {""}, {unit}, [x, value](Snapshot& now, std::span<double> values) {
    values[0] = x.sign * value(now, measured(now, x));
  });
}

/// Endings of a body's columns: those of its frame ("_0_p_x" of the first of several), then "_eta_1" and so on.
Names endings_of(const Coordinates& c, const Names& frame, const std::string& linear) {
  Names names;
  for (int i = 0; i < c.frames; ++i)
    for (const std::string& ending : frame) names.push_back((c.frames > 1 ? "_" + std::to_string(i) : "") + ending);
  for (int i = 1; i <= c.linear; ++i) names.push_back(linear + std::to_string(i));
  return names;
}

/// Part of q or v of a body, from its `skip`-th entry on. Of a deformable body each column stays with its mode: zero
/// where a fidelity leaves that mode out.
Sensor slice_sensor(const Body& body, Located name, const Names& endings, VectorX State::*vector, int skip) {
  // p in m, e a quaternion, omega in rad/s; what a linear coordinate is, is the body's business.
  const bool rates = vector == &State::v;
  Names units(endings.size());
  const int frames = skip > 0 ? 0 : body.coordinates().frames;
  const std::size_t frame = rates ? 6 : 7;
  for (std::size_t i = 0; i < frame * static_cast<std::size_t>(frames); ++i)
    units[i] = i % frame < 3 ? (rates ? "m/s" : "m") : (rates ? "rad/s" : "");
  if (endings.empty())
    throw SceneError("body '" + body.name() + "' has no such coordinates", to_string(name.where),
                     "ask a body that has some");
  const auto* deformable = dynamic_cast<const DeformableBody*>(&body);
  const bool has_candidates = deformable && deformable->candidate_stiffness().size() > 0;
  const std::vector<int> modes = has_candidates ? deformable->fidelity().modes : std::vector<int>{};
  return make_sensor(std::move(name), body.name(), endings, units,
                     [&body, deformable, modes, vector, skip, frames](Snapshot& now, std::span<double> values) {
                       if (deformable && frames > 0 && body.coordinates().frames != frames)
                         throw SceneError("'" + body.name() + "' has other coordinates than when its sensor was made",
                                          body.where(), "make the sensor after set_fidelity()");
                       const Layout::BodySlice& slice = now.system().layout().slice(body);
                       const int first = (vector == &State::q ? slice.q : slice.v) + skip;
                       const double* from = (now.state().*vector).data() + first;
                       const auto before = values.size() - modes.size();  // of the frame
                       std::copy(from, from + before, values.begin());
                       for (std::size_t k = 0; k < modes.size(); ++k) {
                         const std::vector<int>& present = deformable->fidelity().modes;
                         const auto at = std::lower_bound(present.begin(), present.end(), modes[k]);
                         const bool moves = at != present.end() && *at == modes[k];
                         values[before + k] = moves ? from[before + static_cast<std::size_t>(at - present.begin())] : 0;
                       }
                     });
}

// ---- energies ----

template <class ShareOf>
Sensor energy_sensor(const Body* body, Located name, const std::string& quantity, ShareOf&& share) {
  return make_sensor(std::move(name), body ? body->name() + "_" + quantity : quantity, {""}, {"J"},
                     [body, share](Snapshot& now, std::span<double> values) {
                       values[0] =
                           share(body ? body->energy(now.body_state(*body), now.system().gravity()) : now.energy());
                     });
}

double kinetic(const BodyEnergy& e) { return e.kinetic; }
double elastic(const BodyEnergy& e) { return e.elastic; }
double potential(const BodyEnergy& e) { return e.elastic + e.gravity; }
double total(const BodyEnergy& e) { return e.total(); }

Sensor residual_sensor(Located name, const std::string& otherwise, Level level) {
  return make_sensor(std::move(name), otherwise, {""}, {}, [level](Snapshot& now, std::span<double> values) {
    VectorX rows(now.system().layout().row_count());
    now.evaluator().constraint(level, rows);
    values[0] = rows.size() > 0 ? rows.lpNorm<Eigen::Infinity>() : 0;
  });
}

}  // namespace

Sensor::Sensor(Located name, std::vector<std::string> columns, Reading reading, std::vector<std::string> units,
               Marker path)
    : name_(std::move(name)),
      columns_(std::move(columns)),
      reading_(std::move(reading)),
      units_(std::move(units)),
      path_(path) {
  if (columns_.empty() || !reading_)
    throw SceneError("sensor '" + name_.text + "' reads nothing", where(), "give its columns and the function");
  if (units_.size() > 1 && units_.size() != columns_.size())
    throw SceneError("sensor '" + name_.text + "' has " + std::to_string(columns_.size()) + " columns and " +
                         std::to_string(units_.size()) + " units",
                     where(), "give one unit a column, one for all, or none");
}

std::string Sensor::unit(std::size_t column) const {
  if (units_.empty()) return "";
  return units_.size() == 1 ? units_[0] : units_.at(column);
}

double Sensor::value(Snapshot& snapshot, int column) const {
  std::vector<double> values(columns_.size());
  evaluate(snapshot, values);
  return values.at(static_cast<std::size_t>(column));
}

Sensor position(Marker marker, Located name) {
  return marker_sensor(
      marker, std::move(name), "", kXyz, "m", [](Snapshot& now, const Marker& m) { return now.marker(m).p; }, marker);
}

Sensor height(Marker marker, Located name) {
  return marker_sensor(marker, std::move(name), "_height", {""}, "m",
                       [](Snapshot& now, const Marker& m) { return Eigen::Matrix<double, 1, 1>(now.marker(m).p.z()); });
}

Sensor orientation(Marker marker, Located name) {
  return marker_sensor(marker, std::move(name), "_e", kQuaternion, "",
                       [](Snapshot& now, const Marker& m) { return quaternion_of(now.marker(m).R); });
}

Sensor velocity(Marker marker, Located name) {
  return marker_sensor(marker, std::move(name), "_v", kXyz, "m/s",
                       [](Snapshot& now, const Marker& m) { return now.marker(m).v; });
}

Sensor angular_velocity(Marker marker, Located name) {
  return marker_sensor(marker, std::move(name), "_w", kXyz, "rad/s",
                       [](Snapshot& now, const Marker& m) { return now.marker(m).w; });
}

Sensor acceleration(Marker marker, Located name) {
  return marker_sensor(marker, std::move(name), "_v_dot", kXyz, "m/s²",
                       [](Snapshot& now, const Marker& m) -> Vector3 { return now.acceleration(m).head<3>(); });
}

Sensor angular_acceleration(Marker marker, Located name) {
  return marker_sensor(marker, std::move(name), "_w_dot", kXyz, "rad/s²",
                       [](Snapshot& now, const Marker& m) -> Vector3 { return now.acceleration(m).tail<3>(); });
}

Sensor coordinates(const Body& body, Located name) {
  const Names frame = {"_p_x", "_p_y", "_p_z", "_e_w", "_e_x", "_e_y", "_e_z"};
  return slice_sensor(body, std::move(name), endings_of(body.coordinates(), frame, "_eta_"), &State::q, 0);
}

Sensor generalized_velocities(const Body& body, Located name) {
  const Names frame = {"_p_dot_x", "_p_dot_y", "_p_dot_z", "_omega_x", "_omega_y", "_omega_z"};
  return slice_sensor(body, std::move(name), endings_of(body.coordinates(), frame, "_eta_dot_"), &State::v, 0);
}

Sensor modal_coordinates(const Body& body, Located name) {
  const Coordinates c = body.coordinates();
  return slice_sensor(body, std::move(name), endings_of(c, {}, "_eta_"), &State::q, 7 * c.frames);
}

Sensor modal_rates(const Body& body, Located name) {
  const Coordinates c = body.coordinates();
  return slice_sensor(body, std::move(name), endings_of(c, {}, "_eta_dot_"), &State::v, 6 * c.frames);
}

Sensor reaction(const Constraint& joint, int marker, Marker axes, Located name) {
  return wrench_sensor(joint, marker, axes, std::move(name));
}

Sensor applied_force(const ForceElement& element, int marker, Marker axes, Located name) {
  return wrench_sensor(element, marker, axes, std::move(name));
}

Sensor joint_reaction(const Constraint& joint, Located name) {
  if (name.text.empty()) name.text = joint.name();
  return wrench_sensor(joint, 1, joint.markers().at(0), std::move(name));
}

Sensor total_reaction(const Body& body, std::vector<const Constraint*> joints, Marker about, Marker axes,
                      Located name) {
  check(about, name);
  if (axes != kWorldAxes) check(axes, name);
  if (joints.empty())
    throw SceneError("no joint is to be summed", to_string(name.where), "list the joints that hold the body");
  for (const Constraint* joint : joints)
    if (!joint || std::none_of(joint->markers().begin(), joint->markers().end(),
                               [&](const Marker& m) { return m.body == &body; }))
      throw SceneError((joint ? "'" + joint->name() + "'" : "a null joint") + " does not hold '" + body.name() + "'",
                       to_string(name.where), "list joints with a marker on the body");
  return make_sensor(std::move(name), body.name() + "_reactions", kWrench, kWrenchUnits,
                     [&body, joints = std::move(joints), about, axes](Snapshot& now, std::span<double> values) {
                       const Vector3 point = now.marker(about).p;
                       Wrench sum{Vector3::Zero(), Vector3::Zero()};
                       for (const Constraint* joint : joints)
                         for (int m = 0; m < joint->marker_count(); ++m) {
                           const Marker& at = joint->markers()[static_cast<std::size_t>(m)];
                           if (at.body != &body) continue;
                           const Wrench w = wrench_of(now, *joint, m);
                           sum = sum + w + torque((now.marker(at).p - point).cross(w.force));
                         }
                       write_wrench(now, sum, axes, values);
                     });
}

Sensor power(const Constraint& joint, Located name) { return power_sensor(joint, std::move(name)); }
Sensor power(const ForceElement& element, Located name) { return power_sensor(element, std::move(name)); }

Sensor coordinate(const JointCoordinate& coordinate, Located name) {
  return coordinate_sensor(coordinate, std::move(name), "",
                           [](Snapshot&, const MeasuredCoordinate& x) { return x.value; });
}
Sensor coordinate_rate(const JointCoordinate& coordinate, Located name) {
  return coordinate_sensor(coordinate, std::move(name), "/s",
                           [](Snapshot&, const MeasuredCoordinate& x) { return x.rate; });
}
Sensor coordinate_acceleration(const JointCoordinate& coordinate, Located name) {
  const Marker A = coordinate.A, B = coordinate.B;
  return coordinate_sensor(coordinate, std::move(name), "/s²", [A, B](Snapshot& now, const MeasuredCoordinate& x) {
    const Vector6 a = now.acceleration(A), b = now.acceleration(B);
    return x.bias + x.on_A.force.dot(a.head<3>()) + x.on_A.torque.dot(a.tail<3>()) + x.on_B.force.dot(b.head<3>()) +
           x.on_B.torque.dot(b.tail<3>());
  });
}

Sensor multipliers(const Constraint& joint, Located name) {
  Names endings;
  for (int r = 1; r <= joint.row_count(); ++r) endings.push_back("_" + std::to_string(r));
  return make_sensor(std::move(name), joint.name() + "_lambda", endings, {},
                     [&joint](Snapshot& now, std::span<double> values) {
                       const double* from = multipliers_of(now, joint);
                       std::copy(from, from + values.size(), values.begin());
                     });
}

Sensor input_value(const Input& input, Located name) {
  if (name.text.empty()) name.text = input.name();
  const std::string column = name.text;
  return {std::move(name),
          {column},
          [&input](Snapshot& now, std::span<double> out) { out[0] = input.value(now.time()); },
          {input.unit()}};
}

Sensor kinetic_energy(Located name) { return energy_sensor(nullptr, std::move(name), "kinetic_energy", kinetic); }
Sensor elastic_energy(Located name) { return energy_sensor(nullptr, std::move(name), "elastic_energy", elastic); }
Sensor potential_energy(Located name) { return energy_sensor(nullptr, std::move(name), "potential_energy", potential); }
Sensor total_energy(Located name) { return energy_sensor(nullptr, std::move(name), "total_energy", total); }

Sensor kinetic_energy(const Body& body, Located name) {
  return energy_sensor(&body, std::move(name), "kinetic_energy", kinetic);
}
Sensor elastic_energy(const Body& body, Located name) {
  return energy_sensor(&body, std::move(name), "elastic_energy", elastic);
}
Sensor potential_energy(const Body& body, Located name) {
  return energy_sensor(&body, std::move(name), "potential_energy", potential);
}
Sensor potential_energy(const ForceElement& element, Located name) {
  return make_sensor(
      std::move(name), element.name() + "_potential_energy", {""}, {"J"},
      [&element](Snapshot& now, std::span<double> values) { values[0] = rows_of(now, element).energy(); });
}
Sensor total_energy(const Body& body, Located name) {
  return energy_sensor(&body, std::move(name), "total_energy", total);
}

Sensor constraint_residual(Located name) {
  return residual_sensor(std::move(name), "constraint_residual", Level::position);
}
Sensor velocity_residual(Located name) {
  return residual_sensor(std::move(name), "velocity_residual", Level::velocity);
}

}  // namespace lithe
