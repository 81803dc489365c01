#pragma once

#include "engine/model/force_element.h"

namespace lithe {

/// A force or torque on a coordinate x, and its derivatives by x and ẋ.
struct CoordinateEffort {
  double value, by_value, by_rate;
};

/// Pushes coordinate i of an element whose markers begin with those of its coordinates. What the effort owes to its own
/// coordinate, by_value x + by_rate ẋ, is a compliant row, which Newton's matrix has for flexible bodies too; the rest
/// a load.
void push_coordinate(const CoordinateSet& coordinates, int i, const CoordinateEffort& effort,
                     std::span<const MarkerView> markers, ForceRows& rows);

}  // namespace lithe
