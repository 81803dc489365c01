#include "joints/forces/joint_coulomb_friction.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

JointCoulombFriction::JointCoulombFriction(Parameters parameters)
    : surface_(CoordinateSet(std::move(parameters.coordinates)),
               {parameters.joint, parameters.radius, parameters.bending_arm, parameters.preload}),
      law_({parameters.coefficient, parameters.static_coefficient, parameters.stribeck_speed}) {
  if (parameters.static_coefficient != 0 && parameters.static_coefficient < parameters.coefficient)
    throw SceneError("static_coefficient is " + std::to_string(parameters.static_coefficient) + ", below coefficient",
                     "",
                     "surfaces stick by at least what they slide with: give at least " +
                         std::to_string(parameters.coefficient) + ", or leave it out");
  require::not_negative(parameters.viscous, "viscous");
  viscous_ = surface_.viscous(parameters.viscous);
}

/// Rows tell how the surfaces slide and carry the viscous part. What acted in the last step is a load: loads have
/// derivatives by all velocities, that of the state among them.
void JointCoulombFriction::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const JointSurface::Sliding sliding = surface_.sliding(markers, rows);
  const int joint_markers = surface_.marker_count();
  Wrench wrenches[kMaxMarkers];
  surface_.fill(sliding, markers[joint_markers].v, wrenches);
  for (int m = 0; m < joint_markers; ++m) rows.add_load(markers[m], wrenches[m]);
  for (int k = 0; k < surface_.directions(); ++k) {
    Wrench* row = rows.open();
    row[joint_markers] = {Vector3::Zero(), Vector3::Zero()};
    surface_.fill(sliding, Vector3::Unit(k), row);
    rows.finish(viscous_ * sliding.speed[k], 0, viscous_);
  }
}

template std::unique_ptr<ForceBatch> make_force_batch<JointCoulombFriction>();

JointCoulombFriction& add_joint_coulomb_friction(SystemGraph& graph, Located name,
                                                 std::vector<JointCoordinate> coordinates,
                                                 JointCoulombFriction::Parameters parameters) {
  std::vector<Marker> markers = CoordinateSet(coordinates).markers();
  if (markers.empty() && parameters.joint) markers = parameters.joint->markers();
  Located of_states = name;
  of_states.text += " force";
  const auto& force = graph.add<FirstOrderStates>(of_states, {.start = VectorX::Zero(3)});
  markers.push_back(force.point(0));
  parameters.coordinates = std::move(coordinates);
  return graph.add<JointCoulombFriction>(std::move(name), std::move(markers), std::move(parameters));
}

}  // namespace lithe
