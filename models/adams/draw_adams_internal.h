#pragma once

#include <map>
#include <vector>

#include "engine/model/joint_coordinate.h"
#include "engine/observe/sensors.h"
#include "models/model_description.h"

namespace lithe {
class SystemGraph;
class RigidBody;
class Constraint;
}  // namespace lithe

namespace lithe::adams {

/// What was drawn, in the order of the description's links and joints.
struct Drawn {
  std::vector<RigidBody*> bodies;
  std::vector<ModelPose> places;
  std::vector<const Constraint*> joints;
  std::vector<JointCoordinate> coordinates;
  std::map<int, Marker> markers;
  std::vector<Sensor> outputs;
};
Drawn draw(SystemGraph& graph, const ModelDescription& model, const std::string& prefix);

}  // namespace lithe::adams
