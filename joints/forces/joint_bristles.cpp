#include "joints/forces/joint_bristles.h"

#include <algorithm>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {
namespace {

// N that the state of the load counts in: a load of some kN is as large as a bristle's deflection to error control.
constexpr double kUnit = 1e3;

}  // namespace

JointBristles::JointBristles(Parameters parameters)
    : surface_(CoordinateSet(std::move(parameters.coordinates)),
               {parameters.joint, parameters.radius, parameters.bending_arm, parameters.preload}),
      law_({{parameters.coefficient, parameters.static_coefficient, parameters.stribeck_speed},
            parameters.breakaway_deflection,
            parameters.damping_time,
            parameters.elastic_share}),
      load_time_(parameters.load_time) {
  require::positive(load_time_, "load_time");
  require::not_negative(parameters.viscous, "viscous");
  viscous_ = surface_.viscous(parameters.viscous);
}

void JointBristles::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const int joint_markers = surface_.marker_count();
  const MarkerView &bristles = markers[joint_markers], &follower = markers[joint_markers + 1];
  const JointSurface::Sliding sliding = surface_.sliding(markers, rows);
  const Vector3& z = bristles.v;
  // Steps that do not resolve τ_n may leave the load below zero, where friction would push the way it slides.
  const double followed = kUnit * std::max(follower.v[0], 0.0);
  const BristleLaw::Value value = law_.at(sliding.speed, z);

  // Loads, since they have derivatives by all velocities, states among them; a row's tension has them by its own.
  rows.add_load(bristles, force(value.rate));
  Wrench wrenches[kMaxMarkers];
  surface_.fill(sliding, -(followed * value.force + viscous_ * sliding.speed), wrenches);
  for (int m = 0; m < joint_markers; ++m) rows.add_load(markers[m], wrenches[m]);
  rows.add_energy(followed * law_.energy(z));

  // A row, since it knows the joint's reaction.
  const auto [N, by] = surface_.press(markers, rows.reaction());
  Wrench* row = rows.open();
  std::fill_n(row, marker_count(), Wrench{Vector3::Zero(), Vector3::Zero()});
  row[joint_markers + 1] = force(Vector3::UnitX());
  rows.finish((follower.v[0] - N / kUnit) / load_time_, 0, 1 / load_time_);
  rows.depends_on_reaction(-1 / (kUnit * load_time_) * by);
}

VectorX JointBristles::start(double load, const Vector3& deflection) {
  VectorX states(4);
  states << deflection, load / kUnit;
  return states;
}

template std::unique_ptr<ForceBatch> make_force_batch<JointBristles>();

JointBristles& add_joint_bristles(SystemGraph& graph, Located name, std::vector<JointCoordinate> coordinates,
                                  const FirstOrderStates& states, JointBristles::Parameters parameters) {
  std::vector<Marker> markers = CoordinateSet(coordinates).markers();
  if (markers.empty() && parameters.joint) markers = parameters.joint->markers();
  markers.insert(markers.end(), {states.point(0), states.point(1)});
  parameters.coordinates = std::move(coordinates);
  return graph.add<JointBristles>(std::move(name), std::move(markers), std::move(parameters));
}

}  // namespace lithe
