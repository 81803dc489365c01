#pragma once

#include <string>
#include <vector>

#include "bodies/flexible/frames.h"

namespace lithe {

/// Nodes averaged with weights (RBE3; docs/equations.md 7.1). Mean motion of the nodes, and the loads that work on it:
///   translation Σ w_i u_i,   rotation D⁻¹ Σ w_i ρ_i × u_i,   ρ_i = r_i - c,   D = Σ w_i (ρ_i·ρ_i E - ρ_i ρ_iᵀ)
///   force F and torque N give node i   f_i = w_i (F + (D⁻¹ N) × ρ_i).
/// For nodes on a line D has no inverse about it: the pseudo-inverse leaves that rotation zero.
struct NodeAverage {
  std::vector<int> nodes;  // indices
  VectorX weights;         // sum 1
  Vector3 center = Vector3::Zero();
  Matrix3X arms;  // ρ, a column a node
  Matrix3 spread_inverse = Matrix3::Zero();
  bool on_a_line = false;

  /// No weights: equal ones. SceneError for no node, for another number of weights than nodes, for negative weights.
  NodeAverage(const Matrix3X& positions, std::vector<int> indices, const std::vector<double>& weights,
              const std::string& where);
  /// Nodal forces (dofs x 6) of unit forces and torques along the axes. Its transpose takes the mean motion of u.
  MatrixX unit_loads(int dof_count) const;
};

/// The motions that the frame and rigid sets (node indices) leave free: u = T z, the columns of T orthonormal. One
/// coordinate z for each free degree of freedom of nodes in no set, `loose` of them, then up to six for each set: the
/// motions as one rigid piece that the frame allows (RBE2).
struct FreeMotions {
  SparseMatrix T;
  int loose = 0;
};
/// SceneError for a node in two sets.
FreeMotions free_motions(const FramePlacement& placed, const std::vector<RotationalDof>& rotations,
                         const std::vector<std::vector<int>>& rigid_sets);

/// Largest departure of a set's displacements (3m x k, a column a mode) from a rigid motion of its nodes (3 x m).
VectorX deformation(const Matrix3X& nodes, const MatrixX& displacements);

}  // namespace lithe
