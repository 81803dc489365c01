#include "joints/forces/coordinate_motor.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/error.h"

namespace lithe {

CoordinateMotor::CoordinateMotor(CoordinateSet coordinate, Parameters parameters)
    : coordinate_(std::move(coordinate)), parameters_(std::move(parameters)) {
  coordinate_.require_one("a motor");
  if (!parameters_.effort)
    throw SceneError("has no law", "", "give .effort = [](double time, double coordinate, double rate) { ... }");
}

void CoordinateMotor::evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const {
  const MeasuredCoordinate x = coordinate_.measure(0, markers, rows);
  const auto& effort = parameters_.effort;
  const double dx = 1e-6 * (1 + std::abs(x.value)), dv = 1e-6 * (1 + std::abs(x.rate));
  const double by_x = (effort(time, x.value + dx, x.rate) - effort(time, x.value - dx, x.rate)) / (2 * dx);
  const double by_v = (effort(time, x.value, x.rate + dv) - effort(time, x.value, x.rate - dv)) / (2 * dv);
  rows.add({x.on_A, x.on_B}, -effort(time, x.value, x.rate), -by_x, -by_v, 0);
}

template std::unique_ptr<ForceBatch> make_force_batch<CoordinateMotor>();

}  // namespace lithe
