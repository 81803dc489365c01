#pragma once

#include "engine/model/appearance.h"
#include "joints/gears/gear_geometry.h"

namespace lithe {

/// A gear with its teeth about z, to be drawn: the middle of one tooth at `angle` from x, rad. A ring gear is hollow.
DrawnShape gear_shape(const GearGeometry& pair, const InvoluteGear& gear, double angle);

}  // namespace lithe
