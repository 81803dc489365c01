#pragma once

#include <string>
#include <vector>

#include "bodies/flexible/reduction.h"

namespace lithe {

/// A body frame placed in a model: its pose, and the degrees of freedom in body axes that it fixes
/// (docs/equations.md 5.2).
struct FramePlacement {
  Vector3 origin = Vector3::Zero();        // in mesh axes
  Matrix3 rotation = Matrix3::Identity();  // body axes to mesh axes
  Matrix3X nodes;                          // in body axes
  std::vector<int> fixed_dofs;             // ascending; B has zero rows here
  MatrixX rigid;      // dofs x k, rigid motions the fixed_dofs leave free: 6 for mean axes, the swing
                      // of a hinge (1), the turns about one pinned node (3), else none
  MatrixX means;      // dofs x 6 or without columns: meansᵀ u = 0 holds the rigid motions instead of fixed_dofs
  std::string where;  // "model 'rod', three-node frame (1, 13, 2)", for messages
};

/// Throws SceneError for unknown or collinear frame nodes and for a tangent frame that leaves the body free to move.
FramePlacement place_frame(const FiniteElementModel& model, const BodyFrame& frame);

/// Rigid motions (dofs x k, k = 0..6) that vanish at the fixed degrees of freedom.
MatrixX rigid_motions_left(const Matrix3X& nodes, const std::vector<RotationalDof>& rotations,
                           const std::vector<int>& fixed_dofs);

}  // namespace lithe
