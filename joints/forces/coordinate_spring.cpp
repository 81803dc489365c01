#include "joints/forces/coordinate_spring.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

CoordinateSpring::CoordinateSpring(CoordinateSet coordinate, Parameters parameters)
    : coordinate_(std::move(coordinate)), parameters_(std::move(parameters)) {
  coordinate_.require_one("a spring");
  require::not_negative(parameters_.stiffness, "stiffness");
  require::not_negative(parameters_.damping, "damping");
  require::finite(parameters_.preload, "preload");
  if (parameters_.free_value) require::finite(*parameters_.free_value, "free_value");
}

void CoordinateSpring::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const MeasuredCoordinate x = coordinate_.measure(0, markers, rows);
  const double k = parameters_.stiffness, c = parameters_.damping, preload = parameters_.preload;
  const double stretch = x.value - free_value_;
  const Tension more = parameters_.law ? parameters_.law(stretch, x.rate) : Tension{};
  rows.add({x.on_A, x.on_B}, k * stretch + c * x.rate + preload + more.force, k + more.stiffness, c + more.damping,
           (0.5 * k * stretch + preload) * stretch + more.energy);
}

void CoordinateSpring::initialize(std::span<const MarkerView> markers) {
  free_value_ = parameters_.free_value ? *parameters_.free_value : coordinate_.measure(0, markers, {}).value;
}

template std::unique_ptr<ForceBatch> make_force_batch<CoordinateSpring>();

}  // namespace lithe
