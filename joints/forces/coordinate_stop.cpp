#include "joints/forces/coordinate_stop.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

CoordinateStop::CoordinateStop(CoordinateSet coordinate, Parameters parameters)
    : coordinate_(std::move(coordinate)), parameters_(parameters) {
  coordinate_.require_one("a stop");
  if (!(parameters_.lower < parameters_.upper))
    throw SceneError("the lower limit is not below the upper", "", "give .lower, .upper or both, m or rad");
  if (std::isinf(parameters_.lower) && std::isinf(parameters_.upper))
    throw SceneError("has no limit", "", "give .lower, .upper or both, m or rad");
  require::positive(parameters_.stiffness, "stiffness");
  require::not_negative(parameters_.dissipation, "dissipation");
  require::finite(parameters_.exponent, "exponent");
  if (parameters_.exponent < 1) throw SceneError("exponent is below 1", "", "give 1.5 (Hertz), or 1 (linear)");
}

void CoordinateStop::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const MeasuredCoordinate x = coordinate_.measure(0, markers, rows);
  const auto& [lower, upper, k, n, d] = parameters_;
  const double side = x.value > upper ? 1 : -1;
  const double depth = x.value > upper ? x.value - upper : lower - x.value;
  if (!(depth > 0)) return rows.add({x.on_A, x.on_B}, 0, 0, 0, 0);
  const double speed = side * x.rate, elastic = k * std::pow(depth, n), factor = 1 + d * speed;
  const bool pushes = factor > 0;
  rows.add({x.on_A, x.on_B}, pushes ? side * elastic * factor : 0, pushes ? n * elastic / depth * factor : 0,
           pushes ? elastic * d : 0, elastic * depth / (n + 1));
}

std::vector<CoordinateSwitch> CoordinateStop::switches() const {
  std::vector<CoordinateSwitch> limits;
  for (double limit : {parameters_.lower, parameters_.upper})
    if (std::isfinite(limit)) limits.push_back({coordinate_[0], limit});
  return limits;
}

template std::unique_ptr<ForceBatch> make_force_batch<CoordinateStop>();

}  // namespace lithe
