#pragma once

#include "engine/model/body.h"

namespace lithe {

/// A rigid body that moves in a plane: q = (x, y, θ), its centre of mass along two axes of the plane, counted from the
/// origin of the world, and its turn about the normal.
class PlanarBody : public Body {
 public:
  struct Plane {
    double mass = 1, inertia = 1;             // kg; kg m² about the normal
    Matrix3 axes = Matrix3::Identity();       // columns: two axes of the plane, its normal; world axes
    Vector3 height{0, 0, 0};                  // of the plane above the origin
  };
  virtual Plane plane() const = 0;
};

}  // namespace lithe
