#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "bodies/flexible/modal_basis.h"
#include "engine/base/math.h"
#include "engine/model/deformable_body.h"

namespace lithe {

/// Where the body frame sits in the deforming body (docs/equations.md section 5.2). Nodes by label.
/// Origin at the first node, x axis to the second, the third in the x-y plane: rows a_xyz, b_yz, c_z of B vanish, eqs.
/// (65)-(68).
struct ThreeNodeFrame {
  int origin, on_x, in_xy;
};
/// One-node frame: clamped to these nodes, three or more off one line; mesh axes at their mean. A single node is
/// clamped together with all its elements. The nodes keep their distances: a face that is pulled or bent cannot shrink
/// across (Poisson's strain), nor warp when it is twisted, which stiffens what is near. That is a body welded to
/// something rigid; where it is not, a MeanTangentFrame holds the same face by its mean alone.
struct TangentFrame {
  std::vector<int> nodes;
};
/// Modes of the body pinned at these nodes, the free swing (one pinned node: the three free turns) dropped; mesh axes
/// at their mean.
struct HingeFrame {
  std::vector<int> nodes;
};
/// Free-free modes, mesh axes at the undeformed centre of mass.
struct MeanAxisFrame {};

/// Nodes by label, and how much each counts in an average; no weights: all alike.
struct WeightedNodes {
  std::vector<int> ids;
  std::vector<double> weights{};
};
/// Held by the mean motion of these nodes, three or more off one line: mesh axes at their mean, and of the rigid motion
/// that fits their displacements best (least squares, weighted) position and rotation are zero. Six conditions and no
/// more, so that the nodes strain as they like: a face that is pulled shrinks across (Poisson), a twisted one warps.
/// Modes and static shapes are those of a body that a FixedJoint holds at FlexibleBody::average() of the same nodes.
struct MeanTangentFrame {
  WeightedNodes nodes;
};
using BodyFrame = std::variant<MeanAxisFrame, ThreeNodeFrame, TangentFrame, HingeFrame, MeanTangentFrame>;

/// Static shapes for the interfaces that are `loaded`, six each (docs/equations.md 6).
enum class InterfaceModes {
  attachment,     // free interfaces: deflections under unit forces and torques (Rubin, Craig-Chang)
  craig_bampton,  // fixed interfaces: rigid sets moved by unit displacements and rotations, modes with all of them held
  krylov,  // moment matching about s = 0: K⁻¹ F, K⁻¹ M K⁻¹ F, ..., and no eigenmodes but those asked for
};

/// What a basis holds beside the eigenmodes of its frame, and how it deflects.
struct Reduction {
  /// Sets whose nodes keep their shape, in every mode (RBE2): FlexibleBody::rigid() makes the marker.
  std::vector<std::vector<int>> rigid{};
  /// Each gets six static modes, the deflections under unit forces and torques spread as by FlexibleBody::average():
  /// what is tied or loaded there yields exactly as the mesh does at rest, however few eigenmodes there are. What a
  /// free body cannot bear at rest is balanced by its inertia (inertia relief).
  std::vector<WeightedNodes> loaded{};
  InterfaceModes interface_modes = InterfaceModes::attachment;
  int krylov_blocks = 2;  // K⁻¹ F and K⁻¹ M K⁻¹ F
  /// Shapes from elsewhere, dofs x k, mesh axes (a file, a test): taken into the basis, minus what the frame holds.
  MatrixX given_modes{};
  Deflection deflection = Deflection::linear;
  /// Displacements of second order smaller than this part of the largest are left out, pairs of modes compared at equal
  /// strain energy.
  double deflection_tolerance = 0.02;
};

inline constexpr int kAllNodal = -1;  // mode count: every nodal coordinate that the frame leaves free

/// Reduces a model to `mode_count` eigenmodes of the frame (or kAllNodal, or 0 for a rigid body), and static modes of
/// the loaded interfaces. Both together are made orthogonal, lowest first: K^ stays diagonal and Mff = E (Craig &
/// Kurdila, Fundamentals of Structural Dynamics, 17.6-17.8). kAllNodal: B selects the degrees of freedom that the frame
/// leaves free; under a HingeFrame one more row is held for each free rigid motion, where that motion is largest
/// (farthest from the axis, along the swing). Not with mean axes, not with rigid sets; it contains all static modes.
/// Mass-orthonormal modes, shift-invert Lanczos (Spectra) over a sparse Cholesky factor (CHOLMOD).
/// Throws SceneError for unknown nodes, collinear frame nodes, more modes than coordinates, a support that leaves a
/// mechanism, a node in two rigid sets, or a model that require_sound() refuses.
std::shared_ptr<const ModalBasis> make_basis(const FiniteElementModel& model, const BodyFrame& frame, int mode_count,
                                             const Reduction& reduction = {});

/// A basis given column by column (modes from a file, a test): Mff is computed, nothing is orthogonalised.
/// nodes, modes, mass (scalar m_ij, n x n) and stiffness already in body axes; the stiffness is K^ = Bᵀ K B, nm x nm,
/// or the nodal K, 3n x 3n, from which K^ is computed. Nodes are labelled 1..n. SceneError for sizes that do not match,
/// an asymmetric stiffness or linearly dependent modes.
std::shared_ptr<const ModalBasis> basis_from_modes(std::string name, const Matrix3X& nodes,
                                                   const SparseMatrix& nodal_mass, const SparseMatrix& modal_stiffness,
                                                   const MatrixX& modes);

/// Eigenfrequencies in Hz of the model with the given degrees of freedom fixed (3 * node index + axis), the lowest
/// `count`, rigid ones as 0. SceneError for a model that require_sound() refuses.
VectorX frequencies(const FiniteElementModel& model, const std::vector<int>& fixed_dofs, int count);

}  // namespace lithe
