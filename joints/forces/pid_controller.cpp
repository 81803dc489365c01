#include "joints/forces/pid_controller.h"

#include <algorithm>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

PidController::PidController(CoordinateSet coordinates, Parameters parameters)
    : coordinates_(std::move(coordinates)), parameters_(std::move(parameters)) {
  if (coordinates_.count() != 2)
    throw SceneError("a controller needs two coordinates", "",
                     "give the coordinate to move and that of an IntegralState: {hinge.angle(), memory.coordinate()}");
  if (!parameters_.target)
    throw SceneError("has no target", "", "give .target = constant(1), ramp(...), tabulated(...)");
  require::not_negative(parameters_.proportional, "proportional");
  require::not_negative(parameters_.integral, "integral");
  require::not_negative(parameters_.derivative, "derivative");
  if (!(parameters_.limit > 0)) throw SceneError("limit is not positive", "", "give the largest force, N or N m");
}

void PidController::evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const {
  const MeasuredCoordinate x = coordinates_.measure(0, markers, rows), memory = coordinates_.measure(1, markers, rows);
  const Motion w = parameters_.target(time);
  const double error = w.value - x.value, kp = parameters_.proportional, kd = parameters_.derivative;
  const double wanted = kp * error + parameters_.integral * memory.rate + kd * (w.rate - x.rate);
  const double given = std::clamp(wanted, -parameters_.limit, parameters_.limit);
  const bool limited = given != wanted;
  rows.add({x.on_A, x.on_B, {Vector3::Zero(), Vector3::Zero()}, {Vector3::Zero(), Vector3::Zero()}}, -given,
           limited ? 0 : kp, limited ? 0 : kd, 0);
  if (!limited || wanted * error < 0) {
    rows.add_load(markers[2], error * memory.on_A);
    rows.add_load(markers[3], error * memory.on_B);
  }
}

template std::unique_ptr<ForceBatch> make_force_batch<PidController>();

}  // namespace lithe
