#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "bodies/flexible/finite_element_model.h"
#include "engine/math.h"

namespace lithe {

/// Where the body frame sits in the deforming body (EQUATIONS.md section 5.2). Nodes by label.
struct ThreeNodeFrame { int origin, on_x, in_xy; };   // eqs. (65)-(68): rows a_xyz, b_yz, c_z of B vanish
struct TangentFrame { std::vector<int> nodes; };      // one-node frame: clamped to these nodes (average motion and rotation of
                                                      // three or more non-collinear ones; a single node: its element neighbours)
struct HingeFrame { std::vector<int> nodes; };        // modes of the body pinned at these nodes, the free swing dropped
struct MeanAxisFrame {};                              // free-free modes, origin at the undeformed centre of mass
using BodyFrame = std::variant<MeanAxisFrame, ThreeNodeFrame, TangentFrame, HingeFrame>;

inline constexpr int kAllNodal = -1;  // mode count: every nodal coordinate that the frame leaves free

/// Everything a flexible body needs from its finite-element model, in body axes; frozen and shared.
struct ModalBasis {
  std::string name;
  Vector3 origin = Vector3::Zero();        // of the body frame, in mesh axes
  Matrix3 rotation = Matrix3::Identity();  // body axes to mesh axes
  std::vector<int> node_ids;
  std::map<std::string, std::vector<int>> node_sets;
  std::vector<ElementBlock> elements;
  Matrix3X nodes;                          // r0, 3 x n, body axes
  SparseMatrix nodal_mass;                 // m_ij, n x n: S_ij = m_ij E
  MatrixX modes;                           // B, 3n x nm, body axes; empty when nodal
  bool nodal = false;                      // B selects the free nodal coordinates: B = E(:, free_dofs)
  std::vector<int> free_dofs;              // when nodal
  SparseMatrix stiffness;                  // K^ = Bᵀ K B, nm x nm (diagonal matrix for eigenmodes)
  SparseMatrix modal_mass;                 // Mff = Bᵀ S B, nm x nm (identity for eigenmodes)
  bool diagonal = false;                   // K^ diagonal and Mff = E
  VectorX frequencies;                     // Hz, eigenfrequencies with the frame's supports (size nm; empty when nodal)
  bool free_swing_dropped = false;         // HingeFrame: one zero-frequency mode was left out

  int mode_count() const { return static_cast<int>(stiffness.rows()); }
  /// B_i, the 3 x nm rows of node index i.
  Matrix3X node_modes(int node) const;
  int node_index(int id) const;
  const std::vector<int>& node_set(const std::string& set) const;
};

/// Reduces a model to `mode_count` eigenmodes of the frame (or kAllNodal, or 0 for a rigid body).
/// Mass-orthonormal modes, shift-invert Lanczos (Spectra) over a sparse Cholesky factor (CHOLMOD).
/// Throws SceneError for unknown nodes, collinear frame nodes, more modes than coordinates, a support that leaves a
/// mechanism, or a model that require_sound() refuses.
std::shared_ptr<const ModalBasis> make_basis(const FiniteElementModel& model, const BodyFrame& frame, int mode_count);

/// A basis given column by column (modes from a file, a test): K^ and Mff are computed, nothing is orthogonalised.
/// nodes, modes, mass and stiffness already in body axes.
std::shared_ptr<const ModalBasis> basis_from_modes(std::string name, const Matrix3X& nodes, const SparseMatrix& nodal_mass,
                                                   const SparseMatrix& modal_stiffness, const MatrixX& modes);

/// Eigenfrequencies in Hz of the model with the given degrees of freedom fixed, the lowest `count`, rigid ones as 0.
VectorX frequencies(const FiniteElementModel& model, const std::vector<int>& fixed_dofs, int count);

}  // namespace lithe
