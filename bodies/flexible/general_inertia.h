#pragma once

#include <vector>

#include "bodies/flexible/modal_basis.h"

namespace lithe {

/// Up to here max|S_ij - m_ij E| / max|S| is rounding: M is a scalar interpolation (docs/equations.md 2.1).
inline constexpr double kIsotropyBound = 1e-10;

/// Blocks S_ij = m_ij E, and no nodal rotations: the scalar masses m_ij say all about the inertia.
bool is_scalar_interpolation(const FiniteElementModel& model, const ModelCheck& sheet);

/// Rows and columns of the translations, 3n x 3n.
SparseMatrix translations(const SparseMatrix& A, int node_count);
/// m_i = tr(Σ_j S_ij)/3 of each node, a diagonal matrix n x n (docs/equations.md 2.4).
SparseMatrix lumped_mass(const SparseMatrix& S, int node_count);

/// Rigid motions about a point c, dofs x 6: unit translations e, unit rotations e x (r - c); nodal rotations turn by e.
MatrixX rigid_motions(const Matrix3X& nodes, const std::vector<RotationalDof>& rotations, const Vector3& center);

/// Mass, centre (mesh axes) and inertia about it, of any consistent mass: Phiᵀ M Phi, Phiᵀ M Y0, Y0ᵀ M Y0.
struct RigidMass {
  double mass = 0;
  Vector3 center = Vector3::Zero();
  Matrix3 inertia = Matrix3::Zero();
};
RigidMass rigid_mass(const FiniteElementModel& model);

/// Degrees of freedom in axes that are turned against the mesh: u_mesh = A u_body, `rotation` from body to mesh axes.
/// SceneError for a node of which one or two rotations alone are degrees of freedom.
SparseMatrix axes_turn(const FiniteElementModel& model, const Matrix3& rotation);

/// The integrals of a basis with nodal rotations or another mass S (body axes, dofs x dofs) than a scalar
/// interpolation: mass, s0, Ct, J0, C0, Mff by S, exact; J1, J2, C1 by the nodes' masses, basis.nodal_mass, the modes
/// moved rigidly so that these see the same momentum in them as S does. Momentum and energy are conserved by any such
/// set (docs/equations.md 2.4).
InertiaIntegrals general_inertia_integrals(const ModalBasis& basis, const SparseMatrix& S);

}  // namespace lithe
