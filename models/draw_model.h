#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine/model/joint_coordinate.h"
#include "engine/model/marker.h"
#include "engine/observe/sensors.h"
#include "models/model_description.h"

namespace lithe {

class SystemGraph;
class RigidBody;
class Constraint;

/// A model as drawn in a graph: its bodies, joints and markers by the names of the file. Lasts as long as the graph.
class DrawnModel {
 public:
  struct Options {
    bool floating = false;                       // the root link is free; otherwise it is part of ground
    ModelPose root{};                            // pose of the root link in the world
    Vector3 velocity{0, 0, 0};                   // of the root link's origin if it is free, world axes, m/s
    Vector3 angular_velocity{0, 0, 0};           // of it, in its own axes, rad/s
    std::map<std::string, double> positions{};   // of joints by name, rad or m; others 0, followers follow
    std::map<std::string, double> velocities{};  // likewise, rad/s or m/s
    bool damping = true;                         // springs and viscous damping of joints act
    bool armature = true;                        // rotors of joints act
    std::string prefix{};                        // before all names, for several models in one graph
  };

  /// The body of a link: links welded to one another share one. Null: part of ground.
  RigidBody* body(const std::string& link) const;
  /// A marker on a link, at `point` of the link's frame (m), with axes `orientation` (marker axes to link axes).
  Marker marker(const std::string& link, const Vector3& point = Vector3::Zero(),
                const Matrix3& orientation = Matrix3::Identity()) const;
  /// The constraint of a revolute, prismatic or planar joint. SceneError for one that makes none: fixed, floating.
  const Constraint& joint(const std::string& name) const;
  /// The coordinate of a revolute joint (its angle) or prismatic joint (its displacement): what drives, motors, springs
  /// and sensors act on. Grows as the file says. SceneError for other joints.
  JointCoordinate coordinate(const std::string& joint) const;
  /// The file's primitive shapes and the bodies that bear them, in the bodies' axes: for Run::draw().
  std::vector<std::pair<const RigidBody*, DrawnShape>> shapes() const;
  const ModelDescription& description() const { return model_; }
  /// Of an Adams data set: MARKER/id. SceneError for one that is not there.
  Marker adams_marker(int id) const;
  /// Of an Adams data set: its REQUESTs and VARIABLEs in their order, in the units of the file; columns as
  /// REQUEST/1_x. Of others: none.
  const std::vector<Sensor>& outputs() const { return outputs_; }

 private:
  friend DrawnModel draw_adams_model(SystemGraph&, const ModelDescription&, const Options&);
  friend DrawnModel draw_model(SystemGraph&, const ModelDescription&, const Options&);
  DrawnModel(SystemGraph& graph, ModelDescription model) : graph_(&graph), model_(std::move(model)) {}

  SystemGraph* graph_;
  ModelDescription model_;
  std::vector<RigidBody*> bodies_;         // of each link
  std::vector<ModelPose> places_;          // of each link: in its body's frame; on ground: in the world
  std::vector<const Constraint*> joints_;  // of each joint, null where it makes none
  std::vector<JointCoordinate> coordinates_;
  std::map<int, Marker> adams_markers_;
  std::vector<Sensor> outputs_;
};

/// Draws a model into a graph: links welded by fixed joints as one rigid body of their common mass, other joints as
/// constraints of the catalogue, loops closed likewise, followers as CoordinateCoupling, springs and damping as
/// CoordinateSpring. Bodies have the name of the link that stands for them (ModelDescription::welded_to), joints their
/// own. An Adams data set: bodies "PART/2", everything else by its statement, "JOINT/1". The graph's gravity is the
/// scene's: give it that of the model. Throws SceneError for a link that moves and has no mass, an inertia that no real
/// body has, a name in use, and for a position or velocity of a joint that is unknown, follows another one or has no
/// coordinate; FileError, naming the line, for an element of an Adams data set that cannot be drawn.
DrawnModel draw_model(SystemGraph& graph, const ModelDescription& model, const DrawnModel::Options& options = {});

}  // namespace lithe
