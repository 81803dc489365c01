#include "joints/coordinate_coupling.h"

#include <algorithm>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

CoordinateCoupling::CoordinateCoupling(CoordinateSet coordinates, Parameters parameters)
    : coordinates_(std::move(coordinates)), parameters_(std::move(parameters)) {
  const std::size_t count = parameters_.factors.size();
  if (count == 0 || static_cast<int>(count) != coordinates_.count() || 2 * coordinates_.count() > kMaxMarkers)
    throw SceneError(
        std::to_string(count) + " factors are given for " + std::to_string(coordinates_.count()) + " coordinates", "",
        "give one to four coordinates, and a factor for each");
  for (double factor : parameters_.factors) require::finite(factor, "factors");
  if (std::all_of(parameters_.factors.begin(), parameters_.factors.end(), [](double c) { return c == 0; }))
    throw SceneError("all factors are 0", "", "give a factor that is not 0: it would tie nothing");
  if (parameters_.offset) require::finite(*parameters_.offset, "offset");
}

void CoordinateCoupling::evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const {
  Wrench* W = rows.open();
  double residual = -offset_, bias = 0;
  for (int i = 0; i < coordinates_.count(); ++i) {
    const MeasuredCoordinate x = coordinates_.measure(i, markers, rows);
    const double c = parameters_.factors[i];
    residual += c * x.value;
    bias += c * x.bias;
    W[2 * i] = c * x.on_A;
    W[2 * i + 1] = c * x.on_B;
  }
  rows.finish_written(residual, bias);
}

void CoordinateCoupling::initialize(std::span<const MarkerView> markers) {
  offset_ = 0;
  for (int i = 0; i < coordinates_.count(); ++i)
    offset_ += parameters_.factors[i] * coordinates_.measure(i, markers, {}).value;
  if (parameters_.offset) offset_ = *parameters_.offset;
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<CoordinateCoupling>();

}  // namespace lithe
