#include "joints/forces/coordinate_spring.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

CoordinateSpring::CoordinateSpring(CoordinateSet coordinate, Parameters parameters)
    : coordinate_(std::move(coordinate)), parameters_(std::move(parameters)) {
  coordinate_.require_one("a spring");
  parameters_.stiffness.require(require::not_negative, "stiffness");
  parameters_.damping.require(require::not_negative, "damping");
  parameters_.preload.require_finite("preload");
  if (parameters_.free_value) parameters_.free_value->require_finite("free_value");
}

void CoordinateSpring::evaluate(double t, std::span<const MarkerView> markers, ForceRows& rows) const {
  const MeasuredCoordinate x = coordinate_.measure(0, markers, rows);
  const double k = parameters_.stiffness.at(t), c = parameters_.damping.at(t), preload = parameters_.preload.at(t);
  const double stretch = x.value - free_value_.at(t);
  const Tension more = parameters_.law ? parameters_.law(stretch, x.rate) : Tension{};
  rows.add({x.on_A, x.on_B}, k * stretch + c * x.rate + preload + more.force, k + more.stiffness, c + more.damping,
           (0.5 * k * stretch + preload) * stretch + more.energy);
}

void CoordinateSpring::initialize(std::span<const MarkerView> markers) {
  free_value_ = parameters_.free_value.value_or(coordinate_.measure(0, markers, {}).value);
}

template std::unique_ptr<ForceBatch> make_force_batch<CoordinateSpring>();

}  // namespace lithe
