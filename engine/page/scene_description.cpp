#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/class_name.h"
#include "engine/model/marker_motions.h"
#include "engine/model/placeless_body.h"
#include "engine/page/scene_plan_internal.h"
#include "engine/simplify/stand_in.h"

namespace lithe {
namespace {

using Json = nlohmann::json;
constexpr int kMostLinear = 200;  // linear coordinates of a body that become charts

Json vector_json(const Vector3& x) { return {x[0], x[1], x[2]}; }
Json rotation_json(const Matrix3& R) {
  const Vector4 e = quaternion_of(R);
  return {e[0], e[1], e[2], e[3]};
}
Json row_json(int first, int width, const char* as) { return {{"row", first}, {"width", width}, {"as", as}}; }

const char* kind_name(DrawnShape::Kind kind) {
  static constexpr const char* kNames[] = {"sphere", "box", "cylinder", "capsule", "cone", "half_space", "mesh"};
  return kNames[static_cast<int>(kind)];
}

/// Writes the description and plans the rows.
class SceneDescription {
 public:
  SceneDescription(Snapshot& now, const RunOptions& options, ScenePlan& plan, RunRecord& record)
      : now_(now), options_(options), plan_(plan), record_(record), graph_(now.system().graph()) {}
  void describe(const std::vector<SceneRecorder::Drawn>& drawn);

 private:
  using BodyPart = ScenePlan::BodyPart;
  using ConnectorPart = ScenePlan::ConnectorPart;

  int add_columns(int count, std::string name) {
    plan_.names.emplace_back(plan_.width, std::move(name));
    plan_.width += count;
    return plan_.width - count;
  }
  int add_channel(const std::string& name, const std::string& unit, const char* group, int body, int connector) {
    const int column = add_columns(1, name);
    Json channel = {{"name", name},
                    {"unit", unit},
                    {"group", group},
                    {"values", row_json(column, 1, std::string(group) == "recorded" ? "f64" : "f32")}};
    channel["body"] = body >= 0 ? Json(body) : Json();
    channel["connector"] = connector >= 0 ? Json(connector) : Json();
    channels_.push_back(std::move(channel));
    return column;
  }
  int add_channels(const std::string& name, const std::vector<const char*>& endings, const std::string& unit,
                   const char* group, int body, int connector) {
    const int first = plan_.width;
    for (const char* ending : endings) add_channel(name + ending, unit, group, body, connector);
    return first;
  }
  bool is_detailed(std::size_t number) const { return static_cast<int>(number) < options_.detailed; }

  Json set_json(const std::string& name, MatrixX matrix, const char* as) {
    record_.sets[name] = std::move(matrix);
    return {{"set", name}, {"as", as}};
  }
  template <class Rows>
  Json indices_json(const std::string& name, const Rows& rows) {
    const int width = rows.empty() ? 0 : static_cast<int>(rows[0].size());
    MatrixX matrix(width, static_cast<Eigen::Index>(rows.size()));
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (int k = 0; k < width; ++k) matrix(k, static_cast<Eigen::Index>(i)) = rows[i][static_cast<std::size_t>(k)];
    return set_json(name, std::move(matrix), "u32");
  }

  void describe_bodies();
  void describe_coordinates(BodyPart& part, int number);
  void describe_mesh(std::size_t number, Json& json);
  Json shape_json(const DrawnShape& shape, const char* role, const std::string& set);
  int describe_marker(const Marker& m);
  void find_connectors();
  void describe_connectors();
  bool is_drive(const ConnectorPart& part) const;
  void describe_sensors();
  void add_shapes(const std::vector<SceneRecorder::Drawn>& drawn);

  Snapshot& now_;
  const RunOptions& options_;
  ScenePlan& plan_;
  RunRecord& record_;
  const SystemGraph& graph_;
  Json scene_, channels_ = Json::array(), notes_ = Json::array(), markers_ = Json::array();
  std::map<std::pair<const Body*, int>, int> marker_number_;
};

Json SceneDescription::shape_json(const DrawnShape& shape, const char* role, const std::string& set) {
  Json json = {{"kind", kind_name(shape.kind)},
               {"size", shape.size},
               {"position", vector_json(shape.position)},
               {"rotation", rotation_json(shape.orientation)},
               {"role", role}};
  if (shape.kind == DrawnShape::Kind::mesh) {
    json["points"] = set_json(
        set + "/points",
        Eigen::Map<const Matrix3X>(shape.points[0].data(), 3, static_cast<Eigen::Index>(shape.points.size())), "f32");
    json["triangles"] = indices_json(set + "/triangles", shape.triangles);
  }
  return json;
}

void SceneDescription::describe_bodies() {
  scene_["bodies"] = Json::array();
  for (std::size_t i = 0; i < graph_.bodies().size(); ++i) {
    const auto& entry = graph_.bodies()[i];
    const Coordinates coordinates = entry.body->coordinates();
    const std::string& name = entry.body->name();
    const int number = static_cast<int>(i);
    const bool moves = coordinates.v_count() > 0;
    plan_.body_number[entry.body] = number;
    BodyPart& part = plan_.bodies.emplace_back();
    part = {.body = entry.body,
            .place = i,
            .frame = coordinates.frames == 1,
            .frames = coordinates.frames,
            .linear = coordinates.linear};
    part.drawable = dynamic_cast<const DrawableBody*>(entry.body);
    if (moves && !part.frame && !part.drawable && entry.body->marker_count() > 0) part.carrier = Marker{entry.body, 0};
    Json json = {{"name", name},
                 {"kind", class_name(entry.type.name())},
                 {"frame", part.frame},
                 {"where", entry.body->where()},
                 {"shapes", Json::array()},
                 {"mesh", nullptr}};
    if (part.frame || part.carrier) {
      part.pose = add_columns(7, "pose of '" + name + "'");
      json["position"] = row_json(part.pose, 3, "f32");
      json["rotation"] = row_json(part.pose + 3, 4, "f32");
    } else if (moves && !part.drawable) {
      notes_.push_back("'" + name + "' has neither a frame nor markers, so that it is not drawn.");
    }
    if (part.frame && coordinates.linear > 0 && !part.drawable)
      notes_.push_back("The deformation of '" + name + "' is not drawn: its type does not tell its surface.");
    if (part.drawable) describe_mesh(i, json);
    if (moves && is_detailed(i - 1)) describe_coordinates(part, number);
    scene_["bodies"].push_back(std::move(json));
  }
}

void SceneDescription::describe_coordinates(BodyPart& part, int number) {
  const std::string& name = part.body->name();
  if (options_.coordinates && part.linear <= kMostLinear) {
    part.detail = plan_.width;
    struct Columns {
      std::vector<const char*> endings;
      const char* unit;
    };
    const auto add = [&](const Columns& position, const Columns& rotation) {
      for (int k = 0; k < part.frames; ++k)
        for (const Columns& c : {position, rotation})
          add_channels(part.frame ? name : name + "_" + std::to_string(k), c.endings, c.unit, "coordinate", number, -1);
    };
    const auto add_linear = [&](const char* what) {
      for (int k = 1; k <= part.linear; ++k) add_channel(name + what + std::to_string(k), "", "coordinate", number, -1);
    };
    add({{"_p_x", "_p_y", "_p_z"}, "m"}, {{"_e_w", "_e_x", "_e_y", "_e_z"}, ""});
    add_linear("_eta_");
    add({{"_p_dot_x", "_p_dot_y", "_p_dot_z"}, "m/s"}, {{"_omega_x", "_omega_y", "_omega_z"}, "rad/s"});
    add_linear("_eta_dot_");
  }
  if (options_.energies)
    part.energies =
        add_channels(name, {"_kinetic_energy", "_elastic_energy", "_gravity_energy"}, "J", "energy", number, -1);
}

void SceneDescription::describe_mesh(std::size_t number, Json& json) {
  BodyPart& part = plan_.bodies[number];
  const std::string& name = part.body->name();
  part.mesh = part.drawable->drawn_mesh(options_.stress);
  const DrawnMesh& mesh = part.mesh;
  if (mesh.points.cols() == 0) {
    notes_.push_back("'" + name + "' has no elements, so that its surface is not drawn.");
    return;
  }
  const std::string set = "/mesh/" + std::to_string(number);
  Json drawn = {{"points", set_json(set + "/points", mesh.points, "f32")},
                {"triangles", indices_json(set + "/triangles", mesh.triangles)},
                {"edges", indices_json(set + "/edges", mesh.edges)},
                {"natural", !mesh.nodal},
                {"pairs", nullptr},
                {"stress", nullptr},
                {"modes", Json::array()}};
  if (mesh.nodal) {
    const int width = static_cast<int>(mesh.points.size());
    part.points = add_columns(width, "nodes of '" + name + "'");
    drawn["nodal"] = row_json(part.points, width, "f32");
    if (options_.stress) notes_.push_back("'" + name + "' has full nodal coordinates: its stress is not drawn.");
  } else {
    const int modes = static_cast<int>(mesh.modes.cols());
    part.modes = add_columns(modes, "modal coordinates of '" + name + "'");
    drawn["coordinates"] = row_json(part.modes, modes, "f32");
    drawn["shapes"] = set_json(set + "/shapes", mesh.modes, "f32");
    for (int k = 0; k < modes; ++k) {
      Json mode = {{"name", "mode " + std::to_string(k + 1)}, {"frequency", nullptr}};
      if (mesh.frequencies.size() > k && std::isfinite(mesh.frequencies[k])) mode["frequency"] = mesh.frequencies[k];
      drawn["modes"].push_back(std::move(mode));
    }
    if (mesh.pairs.cols() > 0) drawn["pairs"] = set_json(set + "/pairs", mesh.pairs, "f32");
    if (mesh.stress.cols() > 0)
      drawn["stress"] = {{"unit", "Pa"}, {"shapes", set_json(set + "/stress", mesh.stress, "f32")}};
    else if (options_.stress && modes > 0)
      notes_.push_back("The stress of '" + name + "' is not drawn: its basis has no elements with a material.");
  }
  json["mesh"] = std::move(drawn);
}

int SceneDescription::describe_marker(const Marker& m) {
  const auto [found, is_new] = marker_number_.try_emplace({m.body, m.index}, static_cast<int>(markers_.size()));
  if (!is_new) return found->second;
  const int number = plan_.body_number.at(m.body);
  const BodyPart& part = plan_.bodies[static_cast<std::size_t>(number)];
  const ScenePlan::Pose pose = plan_.in_body(m);
  Json json = {{"name", m.body->name() + "_m" + std::to_string(m.index)},
               {"body", number},
               {"position", vector_json(pose.p)},
               {"rotation", rotation_json(pose.R)},
               {"node", nullptr}};
  if (part.drawable && part.mesh.points.cols() > 0) {
    Json nodes = Json::array(), weights = Json::array();
    double closest = 0;
    for (const auto& [node, weight] : part.drawable->nodes_of_marker(m.index)) {
      const auto at = std::find(part.mesh.nodes.begin(), part.mesh.nodes.end(), node);
      if (at == part.mesh.nodes.end()) continue;
      const auto point = static_cast<int>(at - part.mesh.nodes.begin());
      const double distance = (part.mesh.points.col(point) - pose.p).norm();
      if (nodes.empty() || distance < closest) json["node"] = point, closest = distance;
      nodes.push_back(point);
      weights.push_back(weight);
    }
    if (nodes.size() > 1) json["nodes"] = std::move(nodes), json["weights"] = std::move(weights);
  }
  markers_.push_back(std::move(json));
  return found->second;
}

/// Rows or loads of the same markers at another time.
bool SceneDescription::is_drive(const ConnectorPart& part) const {
  if (!part.joint) return false;
  const MarkerMotions views(*part.markers, [&](const Marker& m) { return plan_.marker(m, Level::acceleration); });
  const auto residuals_at = [&](double time) {
    ConstraintRows rows(part.joint->marker_count());
    rows.recall(now_.quarter_turns_of(*part.joint));
    part.joint->evaluate(time, views, rows);
    VectorX values(3 * rows.count());
    for (int r = 0; r < rows.count(); ++r) values.segment<3>(3 * r) << rows.residual(r), rows.rate(r), rows.bias(r);
    return values;
  };
  try {
    return residuals_at(now_.time()) != residuals_at(now_.time() + 1e-3);
  } catch (const Error&) {  // a table that ends there
    return true;
  }
}

void SceneDescription::find_connectors() {
  const auto& rows = now_.system().layout().rows();
  for (std::size_t i = 0; i < graph_.constraints().size(); ++i) {
    const auto& entry = graph_.constraints()[i];
    plan_.connectors.push_back(
        {.joint = entry.constraint, .markers = &entry.markers, .first_row = rows[i].first, .rows = rows[i].count});
  }
  int contacts = 0;
  graph_.for_each_load(
      [&](const SystemGraph::ForceEntry& entry) {
        plan_.connectors.push_back({.force = entry.force, .markers = &entry.markers});
      },
      [&](const SystemGraph::ContactEntry& entry) {
        plan_.connector_of_contact[contacts] = static_cast<int>(plan_.connectors.size());
        plan_.connectors.push_back({.surfaces = entry.contact, .markers = &entry.markers, .contact = contacts++});
      });
}

void SceneDescription::describe_connectors() {
  find_connectors();
  scene_["connectors"] = Json::array();
  for (std::size_t i = 0; i < plan_.connectors.size(); ++i) {
    ConnectorPart& part = plan_.connectors[i];
    const Connector& element = part.element();
    const auto* in_plane = dynamic_cast<const RowsInPlane*>(&element);
    const Connector& kind = in_plane ? in_plane->whole() : element;
    const int number = static_cast<int>(i);
    Json bodies_of = Json::array(), markers_of = Json::array();
    for (std::size_t k = 0; k < part.markers->size(); ++k) {
      const Marker& m = (*part.markers)[k];
      const int body = plan_.body_number.at(m.body);
      if (std::find(bodies_of.begin(), bodies_of.end(), body) == bodies_of.end()) bodies_of.push_back(body);
      if (dynamic_cast<const PlacelessBody*>(m.body)) continue;
      if (markers_of.size() < 2) part.at = k;  // the second that is somewhere, as of a joint
      markers_of.push_back(describe_marker(m));
    }
    const char* role = part.contact >= 0 ? "contact" : !part.joint ? "force" : is_drive(part) ? "drive" : "joint";
    Json json = {{"name", element.name()}, {"kind", class_name(typeid(kind).name())},
                 {"role", role},           {"bodies", bodies_of},
                 {"markers", markers_of},  {"where", element.where()},
                 {"reaction", nullptr}};
    part.drawable = dynamic_cast<const DrawableConnector*>(&element);
    Matrix3X line;
    if (part.drawable && part.contact < 0) plan_.line_of(now_, part, line);
    if (line.size() > 0) {
      part.line = add_columns(static_cast<int>(line.size()), "line of '" + element.name() + "'");
      json["line"] = row_json(part.line, static_cast<int>(line.size()), "f32");
    }
    if (is_detailed(i)) {
      if (options_.reactions && part.contact < 0 && !markers_of.empty()) {
        part.reaction = add_columns(9, "reaction of '" + element.name() + "'");
        json["reaction"] = {{"marker", markers_of[std::min<std::size_t>(1, markers_of.size() - 1)]},
                            {"point", row_json(part.reaction, 3, "f32")},
                            {"force", row_json(part.reaction + 3, 3, "f32")},
                            {"moment", row_json(part.reaction + 6, 3, "f32")}};
        part.own_axes = add_channels(element.name(), {"_force_x", "_force_y", "_force_z"}, "N", "reaction", -1, number);
        add_channels(element.name(), {"_moment_x", "_moment_y", "_moment_z"}, "N m", "reaction", -1, number);
      }
      if (options_.contacts && part.contact >= 0) {
        part.summed = add_channel(element.name() + "_force", "N", "reaction", -1, number);
        add_channel(element.name() + "_points", "", "reaction", -1, number);
      }
      if (options_.residuals && part.rows > 0)
        part.residual = add_channels(element.name(), {"_residual", "_velocity_residual"}, "", "residual", -1, number);
    }
    scene_["connectors"].push_back(std::move(json));
  }
  const std::size_t all = std::max(plan_.bodies.size() - 1, plan_.connectors.size());
  if (!is_detailed(all - (all > 0)))
    notes_.push_back("Of " + std::to_string(plan_.bodies.size() - 1) + " bodies and " +
                     std::to_string(plan_.connectors.size()) + " connectors the first " +
                     std::to_string(options_.detailed) + " have charts; RunOptions::detailed gives more.");
}

void SceneDescription::add_shapes(const std::vector<SceneRecorder::Drawn>& drawn) {
  for (const auto& one : drawn)
    if (!plan_.body_number.contains(one.body))
      throw SceneError("a shape is drawn on '" + one.body->name() + "', which is not in this system", one.body->where(),
                       "draw on bodies of the scene that is simulated");
  int sets = 0;
  const auto add = [&](int body, const DrawnShape& shape, const char* role) {
    scene_["bodies"][static_cast<std::size_t>(body)]["shapes"].push_back(
        shape_json(shape, role, "/shape/" + std::to_string(sets++)));
  };
  for (const auto& one : drawn) add(plan_.body_number.at(one.body), one.shape, "visual");
  std::map<int, std::size_t> wheels;  // of ropes: a body with no other shape is drawn all the same
  for (const ConnectorPart& part : plan_.connectors) {
    for (std::size_t m = 0; part.drawable && m < part.markers->size(); ++m) {
      const Marker& marker = (*part.markers)[m];
      const ScenePlan::Pose pose = plan_.in_body(marker);
      for (const DrawnShape& shape : part.drawable->drawn_shapes(static_cast<int>(m))) {
        add(plan_.body_number.at(marker.body), shape.at(pose.p, pose.R), part.contact >= 0 ? "contact" : "visual");
        if (part.line >= 0) wheels[plan_.body_number.at(marker.body)] += 1;
      }
    }
  }
  // Sticks for the others: their markers are known only now.
  Eigen::AlignedBox3d around;
  for (const BodyPart& part : plan_.bodies) around.extend(plan_.pose_of(part).p);
  for (const auto& m : markers_) {
    const ScenePlan::Pose pose = plan_.pose_of(plan_.bodies[m["body"].get<std::size_t>()]);
    const auto& p = m["position"];
    around.extend(Vector3(pose.p + pose.R * Vector3(p[0], p[1], p[2])));
  }
  const double extent = around.diagonal().norm();
  for (const BodyPart& part : plan_.bodies) {
    const auto& json = scene_["bodies"][part.place];
    const std::size_t own = json["shapes"].size() - wheels[static_cast<int>(part.place)];
    if (part.place == 0 || own > 0 || !json["mesh"].is_null()) continue;
    if (part.pose < 0 || dynamic_cast<const PlacelessBody*>(part.body)) continue;
    std::vector<Vector3> ends;
    for (const auto& m : markers_)
      if (m["body"] == part.place) ends.emplace_back(m["position"][0], m["position"][1], m["position"][2]);
    for (const DrawnShape& shape : inferred_shapes(*part.body, ends, extent))
      add(static_cast<int>(part.place), shape, "inferred");
  }
}

void SceneDescription::describe_sensors() {
  scene_["traces"] = Json::array();
  plan_.sensor_columns = plan_.width;
  for (const Sensor& sensor : *plan_.sensors) {
    const int first = plan_.width;
    for (std::size_t c = 0; c < sensor.columns().size(); ++c)
      add_channel(sensor.columns()[c], sensor.unit(c), "recorded", -1, -1);
    const Marker& path = sensor.path();
    if (!path.body || sensor.columns().size() != 3) continue;
    Json trace = {{"name", sensor.columns()[0].substr(0, sensor.columns()[0].size() - 2)},
                  {"points", row_json(first, 3, "f32")}};
    if (plan_.body_number.contains(path.body)) trace["marker"] = describe_marker(path);
    scene_["traces"].push_back(std::move(trace));
  }
}

void SceneDescription::describe(const std::vector<SceneRecorder::Drawn>& drawn) {
  plan_.names.emplace_back(0, "the time");
  plan_.with_contacts = options_.contacts && !now_.system().contacts().empty();
  scene_["name"] = options_.name;
  scene_["gravity"] = vector_json(now_.system().gravity());
  scene_["times"] = row_json(0, 1, "f64");
  scene_["contacts"] = plan_.with_contacts;
  describe_bodies();
  describe_connectors();
  describe_sensors();
  add_shapes(drawn);
  if (options_.energies)
    plan_.totals =
        add_channels("", {"kinetic_energy", "elastic_energy", "gravity_energy", "total_energy"}, "J", "energy", -1, -1);
  if (options_.residuals && now_.system().layout().row_count() > 0)
    plan_.residuals = add_channels("", {"constraint_residual", "velocity_residual"}, "", "residual", -1, -1);
  scene_["markers"] = std::move(markers_);
  scene_["channels"] = std::move(channels_);
  scene_["notes"] = std::move(notes_);
  try {
    record_.scene = scene_.dump();
  } catch (const Json::exception&) {
    throw SceneError("a name in the scene is not UTF-8", "run '" + options_.name + "'",
                     "save the scene's source as UTF-8, or use other names");
  }
}

}  // namespace

void add_field(RunRecord& record, const PlacedField& field) {
  Json scene = Json::parse(record.scene);
  Json& fields = scene["bodies"][static_cast<std::size_t>(field.body)]["mesh"]["fields"];
  const std::string set = "/mesh/" + std::to_string(field.body) + "/field/" + std::to_string(fields.size());
  record.sets[set] = field.values;
  fields.push_back({{"name", field.name}, {"unit", field.unit}, {"values", {{"set", set}, {"as", "f32"}}}});
  record.scene = scene.dump();
}

void describe_scene(Snapshot& now, const RunOptions& options, const std::vector<SceneRecorder::Drawn>& drawn,
                    ScenePlan& plan, RunRecord& record) {
  SceneDescription(now, options, plan, record).describe(drawn);
}

}  // namespace lithe
