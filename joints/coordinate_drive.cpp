#include "joints/coordinate_drive.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/error.h"
#include "engine/model/adjustable.h"

namespace lithe {

CoordinateDrive::CoordinateDrive(CoordinateSet coordinate, Parameters parameters)
    : coordinate_(std::move(coordinate)), motion_(std::move(parameters.motion)) {
  coordinate_.require_one("a drive");
  if (!motion_)
    throw SceneError("has no motion", "", "give .motion = ramp(0, 2), harmonic(...), or a function of time");
  require::without_jumps(motion_, "motion");
}

void CoordinateDrive::evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const {
  const MeasuredCoordinate x = coordinate_.measure(0, markers, rows);
  const Motion f = motion_(time);
  const double gap = x.value - f.value;
  rows.add(coordinate_.is_angle(0) ? std::remainder(gap, 2 * std::numbers::pi) : gap, {x.on_A, x.on_B},
           x.bias - f.acceleration, -f.rate);
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<CoordinateDrive>();

}  // namespace lithe
