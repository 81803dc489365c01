#pragma once

#include <string>
#include <vector>

#include "bodies/flexible/finite_element_model.h"
#include "engine/base/math.h"

namespace lithe {

/// One integration point of a solid element.
struct SolidPoint {
  double volume;      // weight times Jacobian determinant, m³; the volumes of an element add up to its own
  MatrixX gradients;  // (nodes + internal) x 3: ∂N/∂x, 1/m, mesh axes; the internal (incompatible) shapes come last
};

/// A solid element with its geometry and material at hand: what stiffness, stress and large deflection are made of.
///   ∇u(point) = Σ_a u_a gradients_aᵀ over nodes and internal shapes
/// Types: C3D4, C3D8, C3D8I (Wilson-Taylor incompatible modes: nine internal coordinates, condensed), C3D10, C3D20,
/// C3D20R; node order and integration of CalculiX/Abaqus.
struct SolidElement {
  std::vector<int> nodes;  // node indices of the model
  Material material;
  std::vector<SolidPoint> points;
  int internal = 0;  // internal shapes, three coordinates each
  MatrixX
      internal_from_nodal;  // (3 internal) x (3 nodes): internal coordinates that follow u without force, -Kii⁻¹ Kin
  MatrixX internal_compliance;  // (3 internal)²: Kii⁻¹

  /// All coordinates (3 (nodes + internal)) of nodal displacements 3n (or more) long: those of the nodes, then the
  /// internal ones that follow them.
  VectorX coordinates_of(const Eigen::Ref<const VectorX>& displacements) const;
};

/// True for the types above.
bool is_solid_type(const std::string& type);
/// Number of nodes of a solid type; 0 for others.
int solid_node_count(const std::string& type);

/// Throws SceneError for an unknown type, a wrong number of nodes, an element turned inside out or without volume
/// (naming it), or a material that is not: E > 0, -1 < ν < ½.
SolidElement make_solid_element(const std::string& type, const std::vector<int>& nodes, const Matrix3X& positions,
                                const Material& material);
/// Of all blocks of a model, in order.
std::vector<SolidElement> make_solid_elements(const FiniteElementModel& model);

/// Hooke's law: stress (xx yy zz xy yz xz; Pa) from small strain in the same order with engineering shear γ.
Matrix6 elasticity(const Material& material);
/// The same of tensors: λ tr E + 2 μ E.
Matrix3 hooke(const Matrix3& strain, const Material& material);
/// Tangent at rest, nodal: 3a x 3a, internal coordinates condensed.
MatrixX stiffness(const SolidElement& element);

/// Where the consistent mass is integrated.
enum class MassIntegration {
  exact,             // at enough points for elements with straight edges
  stiffness_points,  // at those of the stiffness, as CalculiX 2.20: less for C3D4, C3D10 and C3D20R, whose total mass
                     // stays, but whose mass matrix may be singular on a mesh of few elements
};
/// Consistent mass m_ab of one displacement component, a x a, kg.
MatrixX scalar_mass(const std::string& type, const std::vector<int>& nodes, const Matrix3X& positions,
                    const Material& material, MassIntegration integration = MassIntegration::exact);

/// Where the stiffness of the elements is furthest from the model's K: |ΔK_ij| / √(K_ii K_jj), at node (index) of i.
/// Both K and every element's share of it are positive semidefinite, so no entry of a share exceeds that scale: a part
/// of it is a part of the material, whatever the shape of the body and its modes. Round-off leaves some 1e-15 times the
/// mesh's extent over the size of an element.
struct StiffnessDifference {
  double largest = 0;
  int node = 0;
};
StiffnessDifference stiffness_difference(const FiniteElementModel& model);

/// Fills K and M of a model from its elements and their materials. Throws SceneError like make_solid_element, and for
/// a model without elements.
void assemble_matrices(FiniteElementModel& model, MassIntegration integration = MassIntegration::exact);

}  // namespace lithe
