#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/motion_law.h"

namespace lithe {

/// Prescribes a joint coordinate as a function of time, whatever force that takes.
///   g = x - f(t), one row. For angles whole turns do not count, so f may start anywhere near the drawing.
///   graph.add<CoordinateDrive>("motor", {crank.angle()}, {.motion = ramp(0, 150)});
/// Its multiplier is minus the force (N) or torque (N m) that it needs: drive_force(drive)
/// (engine/analysis/kinematics.h).
class CoordinateDrive final : public Joint</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    MotionLaw motion;  // f(t), m or rad (engine/model/motion_law.h); an Input that does not jump
  };
  /// Throws SceneError without a motion, for an input that is held between samples, and for more than one coordinate.
  CoordinateDrive(CoordinateSet coordinate, Parameters parameters);

  std::vector<MeasuredAngle> angles() const override { return coordinate_.angles(); }
  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const override;

 private:
  const CoordinateSet coordinate_;
  const MotionLaw motion_;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<CoordinateDrive>();

}  // namespace lithe
