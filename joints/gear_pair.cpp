#include "joints/gear_pair.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/initial_pose.h"
#include "engine/model/joint_coordinate.h"

namespace lithe {

GearPair::GearPair(Parameters parameters) : parameters_(parameters) {
  const auto& [a, b] = parameters_;
  require::finite(a, "radius_A");
  require::finite(b, "radius_B");
  if (a == 0 || b == 0 || a + b == 0)
    throw SceneError("radii " + std::to_string(a) + " and " + std::to_string(b) + " make no pair of gears", "",
                     "give two pitch radii in metres, that of a ring gear negative");
}

void GearPair::evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const {
  const auto &A = markers[0], &B = markers[1];
  const auto& [a, b] = parameters_;
  const MeasuredCoordinate at_A = measure(JointCoordinate::Kind::bearing, 2, A, B),
                           at_B = measure(JointCoordinate::Kind::bearing, 2, B, A);
  rows.add(a * rows.wound(0, at_A.value) + b * rows.wound(1, at_B.value) - offset_,
           {a * at_A.on_A + b * at_B.on_B, a * at_A.on_B + b * at_B.on_A}, a * at_A.bias + b * at_B.bias);
}

void GearPair::initialize(std::span<const MarkerView> m) {
  initial::same_direction(m[0].z(), m[1].z(), "z");
  const auto& [a, b] = parameters_;
  const double apart = (m[1].p - m[0].p).norm(), mesh = std::abs(a + b);
  if (std::abs(apart - mesh) > 0.01 * mesh)
    throw SceneError("the centres are " + std::to_string(apart) + " m apart; gears of these radii mesh at " +
                         std::to_string(mesh) + " m",
                     "", "move the markers or fix the radii (that of a ring gear is negative)");
  offset_ = a * initial::angle(measure(JointCoordinate::Kind::bearing, 2, m[0], m[1]).value) +
            b * initial::angle(measure(JointCoordinate::Kind::bearing, 2, m[1], m[0]).value);
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<GearPair>();

}  // namespace lithe
