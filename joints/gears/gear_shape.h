#pragma once

#include "engine/model/appearance.h"
#include "joints/gears/gear_geometry.h"

namespace lithe {

/// Where the middle of a tooth of A and of a tooth of B stands from the pitch point, in circular pitches, positive
/// about the own z axis, at a phase of mesh as drawn (ToothContact::phase): a tooth of one is in a space of the other.
struct GearPhase {
  double A, B;
  GearPhase(const GearGeometry& pair, double phase);
};

/// A gear with its teeth about z, to be drawn: the middle of one tooth at `angle` from x, rad. A ring gear is hollow.
DrawnShape gear_shape(const GearGeometry& pair, const InvoluteGear& gear, double angle);

/// Where a bevel gear is, along the z axis of its marker.
struct BevelCone {
  int teeth;                     // z
  double angle, distance, apex;  // of the cone, rad; from the apex to the middle of the face, m; of the apex, m
};
/// A straight bevel gear with its teeth, those of its virtual spur gear on the back cone.
DrawnShape bevel_gear_shape(const GearGeometry& virtual_pair, const InvoluteGear& virtual_gear, const BevelCone& cone,
                            double angle);

}  // namespace lithe
