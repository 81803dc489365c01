#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bodies/flexible/finite_element_model.h"
#include "engine/base/math.h"

namespace lithe {

/// The inertia invariants of a floating-frame body (docs/equations.md 2.3): all that M and f_v need, independent of the
/// number of nodes. Symmetric 3x3 matrices are stored as (xx yy zz xy xz yz). k, l run over modes.
struct InertiaIntegrals {
  double mass = 0;
  Vector3 s0 = Vector3::Zero();  // first moment, kg m
  Matrix3X Ct;                   // 3 x nm, Phiᵀ S B
  Vector6 J0 = Vector6::Zero();  // inertia about the frame origin
  Matrix6X J1;                   // 6 x nm, column k = J1_k
  MatrixX J2;                    // (6 nm) x nm, rows 6k..6k+5 of column l = J2_kl; ∂J/∂η_k = J1_k + 2 η_l J2_kl
  Matrix3X C0;                   // 3 x nm
  MatrixX C1;                    // (3 nm) x nm, rows 3k..3k+2 of column l = C1_k e_l
  MatrixX Mff;                   // nm x nm
  bool antisymmetric = true;     // C1_k e_l = -C1_l e_k (scalar interpolation)

  int mode_count() const { return static_cast<int>(Ct.cols()); }
};

/// Second-order deflection: displacements of the nodes and strain energy (docs/equations.md 4.5, 6). With the pairs
/// w = ½ ηηᵀ packed by columns of the upper triangle (pair k <= l at l (l + 1)/2 + k; w_kk = ½ η_k², w_kl = η_k η_l):
///   u = [B, Ψ] ξ,   ξ = (η, 0) + C w,   V = ½ ηᵀ K^ η + ⅙ wᵀ Q w
/// The body is the linear one of the modes [B, Ψ] whose coordinates follow η.
struct QuadraticDeflection {
  MatrixX fields;              // Ψ, dofs x r, mass-orthonormal, orthogonal to B
  MatrixX curvature;           // C, (nm + r) x pairs
  MatrixX quartic;             // Q, pairs x pairs: fourth derivatives of the strain energy; empty: none
  InertiaIntegrals integrals;  // of [B, Ψ]
  int field_count() const { return static_cast<int>(fields.cols()); }
};

/// Everything a flexible body needs from its finite-element model, in body axes; frozen and shared.
struct ModalBasis {
  std::string name;
  Vector3 origin = Vector3::Zero();        // of the body frame, in mesh axes
  Matrix3 rotation = Matrix3::Identity();  // body axes to mesh axes
  std::vector<int> node_ids;
  std::map<std::string, std::vector<int>> node_sets;
  std::vector<ElementBlock> elements;
  std::shared_ptr<const DrawnSkin> skin;  // body axes; null: drawn by its elements
  Matrix3X nodes;                         // r0, 3 x n, body axes
  std::vector<RotationalDof> rotations;   // rows 3n, 3n + 1, ... of the modes; about body axes
  SparseMatrix nodal_mass;     // m_ij, n x n: S_ij = m_ij E; for other S the nodes' masses (docs/equations.md 2.4)
  MatrixX modes;               // B, dofs x nm, body axes; empty when nodal
  bool nodal = false;          // B selects the free nodal coordinates: B = E(:, free_dofs)
  std::vector<int> free_dofs;  // when nodal
  SparseMatrix stiffness;      // K^ = Bᵀ K B, nm x nm (diagonal matrix for eigenmodes)
  SparseMatrix modal_mass;     // Mff = Bᵀ S B, nm x nm (identity for eigenmodes)
  MatrixX damping;             // Bᵀ C B of a damping matrix that came with the model, nm x nm; empty: none
  bool diagonal = false;       // K^ diagonal and Mff = E
  InertiaIntegrals integrals;  // of all modes; empty when nodal, or in a basis made by hand: computed then
  std::shared_ptr<const QuadraticDeflection> deflection;  // null: displacements linear in η
  VectorX frequencies;              // Hz, of the modes with the frame's supports (size nm; empty when nodal)
  bool free_swing_dropped = false;  // HingeFrame: zero-frequency motion (one swing, or three turns) left out

  int mode_count() const { return static_cast<int>(stiffness.rows()); }
  /// B_i, the 3 x nm rows of node index i; with `all_fields` those of [B, Ψ] of a quadratic deflection.
  Matrix3X node_modes(int node, bool all_fields = false) const;
  /// The same of the rotations of the node, 3 x nm; no columns if it has none.
  Matrix3X node_rotation_modes(int node, bool all_fields = false) const;
  int node_index(int id) const;
  const std::vector<int>& node_set(const std::string& set) const;
};

}  // namespace lithe
