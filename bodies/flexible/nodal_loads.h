#pragma once

#include <string>

#include "bodies/flexible/finite_element_model.h"
#include "bodies/flexible/flexible_body.h"
#include "engine/observe/snapshot.h"

namespace lithe {

/// On which nodes the loads of a flexible body are in equilibrium.
enum class LoadGeometry {
  undeformed,  // of the mesh: for a linear static deck
  deformed,    // where they are: for a deck with large deflection (NLGEOM)
};

/// What loads a flexible body at one state, at its nodes: for the finite-element code that it came from. Axes of the
/// mesh, which turn with the body frame.
struct NodalLoads {
  double time = 0;         // s
  Matrix3X forces;         // 3 x n, N
  Matrix3X displacements;  // 3 x n, m, of the body relative to its frame
  /// Resultant of what was spread as inertia forces (below), moment about the origin of the body frame: how far from
  /// exact the loads were before, or which torques have no nodes to act on.
  Vector3 spread_force = Vector3::Zero(), spread_moment = Vector3::Zero();
};

/// Loads of gravity and inertia, of joints, force elements and damping, in equilibrium (inertia relief):
///   f_i = Σ_j m_ij (g - a_j) + forces of the markers on their nodes
/// each marker's force by the weights of its nodes, its torque by forces around its axis (as FlexibleBody::average()
/// follows them); loads on the frame marker go to the degrees of freedom that the frame holds. What this leaves open is
/// spread as the inertia forces S L x of an acceleration x of the body's own coordinates, so that the nodes L of the
/// geometry say exactly
///   Σ f = 0,   Σ r_i × f_i = 0,   Bᵀ f = K^ η   (deformed and quadratic: Pᵀ [B, Ψ]ᵀ f = ∂V/∂η)
/// namely: torques about a line of nodes and at single nodes, loads on mean axes, damping, the product of
/// deformation and load where the mesh is undeformed, what a lumped mass lacks. So K u = f can be solved with any
/// statically determinate support, without reaction, and u has the modal coordinates η of the body with the static
/// response of all other modes (mode acceleration; Craig & Kurdila, Fundamentals of Structural Dynamics, 11.4).
/// Accelerations and multipliers are those of the snapshot. SceneError for a body with nodal rotations (their moments
/// are not known to the basis).
NodalLoads nodal_loads(const FlexibleBody& body, Snapshot& snapshot, LoadGeometry geometry = LoadGeometry::undeformed);

/// The loads as a *CLOAD block for *INCLUDE in a step of a CalculiX or Abaqus deck of the model's nodes, with its time
/// and, as a comment, a *BOUNDARY of six degrees of freedom: statically determinate, of those that the body frame holds
/// as far as there are (then the deck's displacements are those of the body frame, else up to a rigid motion). Numbers
/// of up to 17 digits in the 20 columns that CalculiX reads. SceneError for loads of another number of nodes; FileError
/// if the file cannot be written.
void write_calculix_loads(const std::string& path, const FiniteElementModel& model, const NodalLoads& loads);

}  // namespace lithe
