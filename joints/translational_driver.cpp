#include "joints/translational_driver.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/error.h"

namespace lithe {

TranslationalDriver::TranslationalDriver(Parameters parameters) : motion_(std::move(parameters.motion)) {
  if (!motion_)
    throw SceneError("has no motion", "", "give .motion = [](double t) { return Motion{value, rate, acceleration}; }");
}

void TranslationalDriver::evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const {
  const Motion f = motion_(time);
  in_plane(markers[0], markers[0].z(), markers[1], rows);
  rows.drive_last(f.value, f.rate, f.acceleration);
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<TranslationalDriver>();

}  // namespace lithe
