#pragma once

#include <vector>

#include "engine/model/constraint.h"
#include "engine/model/rigid_frame_body.h"
#include "engine/simplify/stand_in.h"

namespace lithe {

/// A marker of a rigid body that moves in a plane, or of ground.
struct MarkerInPlane {
  FramePose pose;        // world axes
  int body;              // markers of one body have the same number; -1: ground
  Vector3 center;        // of mass
  RigidInertia inertia;  // world axes
  Matrix3 plane;         // columns: two axes of the plane, its normal
};

/// Rows of a constraint that say something to bodies which move in their planes, sorted. The others have no Jacobian
/// there, or one that depends on those kept, in any pose that the planes allow: some are looked at.
std::vector<int> rows_in_plane(const Constraint& constraint, const std::vector<MarkerInPlane>& markers);

}  // namespace lithe
