#include "joints/forces/coordinate_effort.h"

#include <algorithm>

namespace lithe {

void push_coordinate(const CoordinateSet& coordinates, int i, const CoordinateEffort& effort,
                     std::span<const MarkerView> markers, ForceRows& rows) {
  const MeasuredCoordinate x = coordinates.measure(i, markers, rows);
  const double in_row = effort.by_value * x.value + effort.by_rate * x.rate;
  const auto at = 2 * static_cast<std::size_t>(i);
  Wrench* W = rows.open();
  std::fill_n(W, markers.size(), Wrench{Vector3::Zero(), Vector3::Zero()});
  W[at] = x.on_A, W[at + 1] = x.on_B;
  rows.finish(-in_row, -effort.by_value, -effort.by_rate);
  rows.add_load(markers[at], (effort.value - in_row) * x.on_A);
  rows.add_load(markers[at + 1], (effort.value - in_row) * x.on_B);
}

}  // namespace lithe
