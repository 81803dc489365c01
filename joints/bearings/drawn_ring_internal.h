#pragma once

#include "engine/model/appearance.h"

namespace lithe {

/// A tube about z, as pages draw rings of bearings.
DrawnShape drawn_ring(double inner_radius, double outer_radius, double width);

}  // namespace lithe
