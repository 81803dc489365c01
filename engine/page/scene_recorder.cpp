#include "engine/assembly/evaluator.h"
#include "engine/base/number_text.h"
#include "engine/contact/contact_forces.h"
#include "engine/model/marker_motions.h"
#include "engine/page/scene_plan_internal.h"

#include <algorithm>
#include <cmath>

namespace lithe {

void ScenePlan::look(Snapshot& now) {
  states.clear();
  for (std::size_t i = 0; i < system->graph().bodies().size(); ++i) states.push_back(now.evaluator().body_state(i));
}

MarkerKinematics ScenePlan::marker(const Marker& m, Level level) const {
  MarkerKinematics k;
  m.body->marker_kinematics(states[static_cast<std::size_t>(body_number.at(m.body))], m.index, level, k);
  return k;
}

void ScenePlan::line_of(Snapshot& now, const ConnectorPart& part, Matrix3X& points) const {
  const MarkerMotions views(*part.markers, [&](const Marker& m) { return marker(m, Level::velocity); });
  AngleMemory memory;
  memory.recall(now.quarter_turns_of(part.element()));
  part.drawable->drawn_line(views, memory, points);
}

ScenePlan::Pose ScenePlan::pose_of(const BodyPart& part) const {
  const BodyState& state = states[part.place];
  if (part.frame) return {Eigen::Map<const Vector3>(state.q), rotation_matrix(Eigen::Map<const Vector4>(state.q + 3))};
  if (part.points >= 0) {
    Matrix3X points(3, part.mesh.points.cols());
    part.drawable->drawn_points(state, part.mesh, points);
    const BestFit fit = best_fit(part.mesh.points, points);
    return {fit.translation, fit.rotation};
  }
  if (!part.carrier) return {};
  const MarkerKinematics k = marker(*part.carrier);
  return {k.p, k.R};
}

ScenePlan::Pose ScenePlan::in_body(const Marker& m) const {
  const BodyPart& part = bodies[static_cast<std::size_t>(body_number.at(m.body))];
  const MarkerKinematics k = marker(m);
  const Pose pose = pose_of(part);
  Pose own{pose.R.transpose() * (k.p - pose.p), pose.R.transpose() * k.R};
  if (part.frame && k.elastic)
    own.p -= Eigen::Map<const Matrix6X>(k.elastic, 6, part.linear).topRows<3>() *
             Eigen::Map<const VectorX>(states[part.place].q + 7, part.linear);
  return own;
}

void ScenePlan::require_finite(const VectorX& row) const {
  if (row.allFinite()) return;
  int bad = 0;
  while (std::isfinite(row[bad])) ++bad;
  const auto after = std::upper_bound(names.begin(), names.end(), bad,
                                      [](int column, const auto& name) { return column < name.first; });
  throw SimulationError(std::prev(after)->second + " is " + std::to_string(row[bad]) + " at " + time_text(row[0]),
                        "run '" + run + "'",
                        "see what it divides by or takes the root of; what was recorded "
                        "up to then is kept");
}

namespace {

/// What a joint or force element does to its bodies at each of its markers.
struct Loads {
  std::vector<MarkerKinematics> markers;
  std::vector<Wrench> wrenches;

  /// All of it on the body of marker `at`, about that marker's point.
  Wrench on_body(const std::vector<Marker>& of, std::size_t at) const {
    Wrench sum{Vector3::Zero(), Vector3::Zero()};
    for (std::size_t m = 0; m < of.size(); ++m) {
      if (of[m].body != of[at].body) continue;
      sum.force += wrenches[m].force;
      sum.torque += wrenches[m].torque + (markers[m].p - markers[at].p).cross(wrenches[m].force);
    }
    return sum;
  }
};

Loads loads_of(Snapshot& now, const ScenePlan& plan, const ScenePlan::ConnectorPart& part) {
  Loads loads;
  loads.markers.reserve(part.markers->size());
  std::vector<MarkerView> views;
  for (const Marker& m : *part.markers) {
    loads.markers.push_back(plan.marker(m, Level::acceleration));
    views.emplace_back(loads.markers.back(), static_cast<int>(views.size()));
  }
  loads.wrenches.assign(views.size(), {Vector3::Zero(), Vector3::Zero()});
  const auto subtract = [&](const auto& rows, int r, double tension) {
    for (std::size_t m = 0; m < views.size(); ++m) {
      loads.wrenches[m].force -= tension * rows.wrench(r, static_cast<int>(m)).force;
      loads.wrenches[m].torque -= tension * rows.wrench(r, static_cast<int>(m)).torque;
    }
  };
  if (part.joint) {  // -Σ_rows W λ
    ConstraintRows rows(part.joint->marker_count());
    rows.recall(now.quarter_turns_of(*part.joint));
    part.joint->evaluate(now.time(), views, rows);
    for (int r = 0; r < rows.count(); ++r) subtract(rows, r, now.multipliers()[part.first_row + r]);
    return loads;
  }
  ForceRows rows(part.force->marker_count());
  rows.recall(now.quarter_turns_of(*part.force));
  if (const Constraint* joint = part.force->reaction_of())
    for (const auto& other : plan.connectors)
      if (other.joint == joint) rows.set_reaction(loads_of(now, plan, other).wrenches.at(1));
  part.force->evaluate(now.time(), views, rows);
  for (std::size_t m = 0; m < views.size(); ++m) loads.wrenches[m] = rows.load(static_cast<int>(m));
  for (int r = 0; r < rows.count(); ++r) subtract(rows, r, rows.tension(r));
  return loads;
}

}  // namespace

SceneRecorder::SceneRecorder(Snapshot& now, const std::vector<Sensor>& sensors, const RunOptions& options,
                             const std::vector<Drawn>& drawn, RunRecord& record)
    : plan_(new ScenePlan{.run = options.name, .system = &now.system(), .sensors = &sensors}) {
  plan_->look(now);
  describe_scene(now, options, drawn, *plan_, record);
  record.name = options.name;
  record.width = plan_->width;
}

SceneRecorder::~SceneRecorder() = default;

std::pair<int, const DrawnMesh&> SceneRecorder::mesh_of(const Body& body) const {
  const auto number = plan_->body_number.find(&body);
  if (number != plan_->body_number.end())
    if (const DrawnMesh& mesh = plan_->bodies[static_cast<std::size_t>(number->second)].mesh; mesh.points.cols() > 0)
      return {number->second, mesh};
  throw SceneError("'" + body.name() + "' draws no mesh in the run '" + plan_->run + "'", body.where(),
                   "colour a body of this scene that has elements, as a FlexibleBody or a Beam");
}

void SceneRecorder::fill(Snapshot& now, int number, VectorX& row, std::vector<double>& contacts) {
  ScenePlan& plan = *plan_;
  if (&now.system() != plan.system)
    throw SceneError("the run '" + plan.run + "' receives the state of another system", "Run::observe",
                     "record each system into a run of its own");
  plan.look(now);
  row.setZero(plan.width);
  row[0] = now.time();
  const auto put = [&](int column, const auto& values) { row.segment(column, values.size()) = values; };

  BodyEnergy total;
  for (const auto& part : plan.bodies) {
    const BodyState& state = plan.states[part.place];
    const int q = 7 * part.frames + part.linear, v = 6 * part.frames + part.linear;
    if (part.pose >= 0 && part.frame) put(part.pose, Eigen::Map<const VectorX>(state.q, 7));
    if (part.carrier) {
      const auto pose = plan.pose_of(part);
      put(part.pose, pose.p);
      put(part.pose + 3, quaternion_of(pose.R));
    }
    if (part.modes >= 0) put(part.modes, Eigen::Map<const VectorX>(state.q + 7 * part.frames, part.mesh.modes.cols()));
    if (part.points >= 0) {
      Matrix3X points(3, part.mesh.points.cols());
      part.drawable->drawn_points(state, part.mesh, points);
      put(part.points, points.reshaped());
    }
    if (part.detail >= 0) {
      put(part.detail, Eigen::Map<const VectorX>(state.q, q));
      put(part.detail + q, Eigen::Map<const VectorX>(state.v, v));
    }
    if (part.place == 0 || (part.energies < 0 && plan.totals < 0)) continue;
    const BodyEnergy energy = part.body->energy(state, plan.system->gravity());
    if (part.energies >= 0) put(part.energies, Vector3(energy.kinetic, energy.elastic, energy.gravity));
  }
  if (plan.totals >= 0) {
    total = now.energy();
    put(plan.totals, Vector4(total.kinetic, total.elastic, total.gravity, total.total()));
  }

  VectorX position, velocity;
  if (plan.residuals >= 0) {
    position.resize(plan.system->layout().row_count());
    velocity.resize(position.size());
    now.evaluator().constraint(Level::position, position);
    now.evaluator().constraint(Level::velocity, velocity);
    put(plan.residuals, Eigen::Vector2d(position.lpNorm<Eigen::Infinity>(), velocity.lpNorm<Eigen::Infinity>()));
  }
  for (const auto& part : plan.connectors) {
    if (part.line >= 0) {
      Matrix3X points;
      plan.line_of(now, part, points);
      put(part.line, points.reshaped());
    }
    if (part.residual >= 0)
      put(part.residual, Eigen::Vector2d(position.segment(part.first_row, part.rows).lpNorm<Eigen::Infinity>(),
                                         velocity.segment(part.first_row, part.rows).lpNorm<Eigen::Infinity>()));
    if (part.reaction < 0) continue;
    const Loads loads = loads_of(now, plan, part);
    const Wrench load = loads.on_body(*part.markers, part.at);
    put(part.reaction, loads.markers[part.at].p);
    put(part.reaction + 3, load.force);
    put(part.reaction + 6, load.torque);
    const Matrix3 axes = loads.markers[0].R.transpose();
    put(part.own_axes, Vector3(axes * load.force));
    put(part.own_axes + 3, Vector3(axes * load.torque));
  }
  contacts.clear();
  if (plan.with_contacts)
    for (const ContactTrace& trace : now.contacts()->report()) {
      const int connector = plan.connector_of_contact.at(trace.element);
      const Vector3& p = trace.point.position;
      contacts.insert(contacts.end(), {static_cast<double>(number), static_cast<double>(connector), p[0], p[1], p[2],
                                       trace.force[0], trace.force[1], trace.force[2]});
      if (const int sum = plan.connectors[static_cast<std::size_t>(connector)].summed; sum >= 0) {
        row[sum] += trace.force.norm();
        row[sum + 1] += 1;
      }
    }

  int column = plan.sensor_columns;
  for (const Sensor& sensor : *plan.sensors) {
    sensor.evaluate(now, {row.data() + column, sensor.columns().size()});
    column += static_cast<int>(sensor.columns().size());
  }
  plan.require_finite(row);
  for (double value : contacts)
    if (!std::isfinite(value))
      throw SimulationError("a contact's point or force is not finite at " + time_text(now.time()),
                            "run '" + plan.run + "'", "see what its law divides by");
}

}  // namespace lithe
