#pragma once

#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/page/run_record_internal.h"

namespace lithe {

/// Which columns of a row hold what. Filled by scene_description.cpp, read by scene_recorder.cpp.
struct ScenePlan {
  struct BodyPart {
    const Body* body;
    std::size_t place;   // in the graph
    bool frame = false;  // one, of the body
    int frames = 0;
    int linear = 0;
    // First columns of a row; -1: not recorded.
    int pose = -1;
    int modes = -1;   // modal coordinates
    int points = -1;  // of a nodal mesh
    int detail = -1;  // q and v
    int energies = -1;
    const DrawableBody* drawable = nullptr;
    DrawnMesh mesh{};
    std::optional<Marker> carrier{};  // whose pose is taken for the body's: no frame, no mesh
  };
  struct ConnectorPart {
    const Constraint* joint = nullptr;
    const ForceElement* force = nullptr;
    const ContactElement* surfaces = nullptr;
    const std::vector<Marker>* markers = nullptr;
    std::size_t at = 0;  // marker at which its load is reported
    int first_row = 0, rows = 0;
    int contact = -1;                                 // number among the contacts
    int reaction = -1, own_axes = -1, residual = -1;  // columns
    int summed = -1;                                  // of a contact: Σ |force|, number of points
    int line = -1;                                    // of a rope: its points
    const DrawableConnector* drawable = nullptr;
    const Connector& element() const {
      return joint ? static_cast<const Connector&>(*joint) : force ? static_cast<const Connector&>(*force) : *surfaces;
    }
  };
  struct Pose {
    Vector3 p = Vector3::Zero();
    Matrix3 R = Matrix3::Identity();
  };

  std::string run;
  const System* system;
  const std::vector<Sensor>* sensors;
  bool with_contacts = false;
  int width = 1;
  std::vector<BodyPart> bodies;
  std::vector<ConnectorPart> connectors;
  std::unordered_map<const Body*, int> body_number;
  std::map<int, int> connector_of_contact;
  int sensor_columns = -1, totals = -1, residuals = -1;
  std::vector<std::pair<int, std::string>> names;  // first column, what it is; rising
  std::vector<BodyState> states;                   // of the snapshot looked at

  void look(Snapshot& now);
  MarkerKinematics marker(const Marker& m, Level level = Level::position) const;
  /// The points of a connector's line.
  void line_of(Snapshot& now, const ConnectorPart& part, Matrix3X& points) const;
  Pose pose_of(const BodyPart& part) const;
  /// A marker in the axes of its body, undeformed.
  Pose in_body(const Marker& m) const;
  /// Throws SimulationError that names the first number that is not finite.
  void require_finite(const VectorX& row) const;
};

/// The scene as JSON, and its sets, into the record.
void describe_scene(Snapshot& now, const RunOptions& options, const std::vector<SceneRecorder::Drawn>& drawn,
                    ScenePlan& plan, RunRecord& record);

}  // namespace lithe
