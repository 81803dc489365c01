#pragma once

#include "engine/model/body.h"

namespace lithe {

/// A rigid body that moves in a plane: q = (x, y, θ), its centre of mass along two axes of the plane, measured from the
/// origin of the world, and its rotation about the normal.
class PlanarBody : public Body {
 public:
  struct Plane {
    double mass = 1, inertia = 1;        // kg; kg m² about the normal
    Matrix3 axes = Matrix3::Identity();  // columns: two axes of the plane, its normal; world axes
    Vector3 height{0, 0, 0};             // of the plane above the origin
  };
  const Plane& plane() const { return plane_; }
  /// Centre of mass, world axes.
  Vector3 center(const double* q) const {
    return plane_.height + plane_.axes.col(0) * q[0] + plane_.axes.col(1) * q[1];
  }

 protected:
  explicit PlanarBody(const Plane& plane) : plane_(plane) {}

 private:
  const Plane plane_;
};

}  // namespace lithe
