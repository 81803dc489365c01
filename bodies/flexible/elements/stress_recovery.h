#pragma once

#include <map>
#include <string>
#include <vector>

#include "bodies/flexible/elements/solid_element.h"
#include "bodies/flexible/modal_basis.h"

namespace lithe {

/// How strain and stress follow from the displacement gradient H.
enum class StrainMeasure {
  small,           // ½ (H + Hᵀ), for displacements linear in η
  green_lagrange,  // E = ½ (H + Hᵀ + Hᵀ H), for displacements of second order, whose foreshortening small strain would
                   // take for compression; stress is the true (Cauchy) one, F S Fᵀ / det F with S = λ tr E + 2 μ E
};

/// At the integration points of an element, 6 x points each. Bricks: first natural coordinate fastest, as in CalculiX.
struct PointStress {
  Matrix6X strain, stress;
};
/// From nodal displacements 3n (or more) long, in their axes; internal coordinates are in equilibrium.
PointStress point_stress(const SolidElement& element, const Eigen::Ref<const VectorX>& displacements,
                         StrainMeasure measure = StrainMeasure::small);

/// Stresses and strains at the nodes of a flexible body, 6 x n: xx yy zz xy xz yz, Pa; engineering shear strain; axes
/// of the fields: body axes for a basis (turned_stress() gives other axes, with basis.rotation those of the mesh).
/// As CalculiX does: each element extrapolates from its integration points to its nodes, and a node takes the mean of
/// its elements; between two materials it takes that of the stiffer one alone. With small strain the stress modes are
/// made once, stress() is a product; else every call goes through the elements. No thermal or initial stress. (CalculiX
/// rounds its extrapolation to a few decimals: its nodal values differ by 2e-5 of the largest.)
class StressRecovery {
 public:
  /// Of all fields of a basis: η, or ξ = (η, 0) + ζ(η) of a quadratic deflection. Throws SceneError like
  /// make_solid_element(): elements without material above all.
  explicit StressRecovery(const ModalBasis& basis, StrainMeasure measure = StrainMeasure::small);
  /// Of displacement fields, dofs x k, in the axes of the model's nodes.
  StressRecovery(const FiniteElementModel& model, const MatrixX& fields, StrainMeasure measure = StrainMeasure::small);
  /// Stress modes from elsewhere (a file), 6n x k, rows 6 * node + component. There is no strain then.
  explicit StressRecovery(MatrixX stress_modes);

  int node_count() const { return nodes_; }
  int coordinate_count() const { return coordinates_; }
  /// Of the coordinates of all fields; SceneError for another number of them.
  Matrix6X stress(ConstVectorRef coordinates) const;
  Matrix6X strain(ConstVectorRef coordinates) const;

 private:
  void take_elements(const FiniteElementModel& model, const std::vector<int>& free_dofs, StrainMeasure measure);
  VectorX displacements(ConstVectorRef coordinates) const;
  Matrix6X nodal(const VectorX& displacements, Matrix6X PointStress::*quantity) const;
  void require_coordinates(ConstVectorRef coordinates) const;

  std::string name_;
  int nodes_ = 0, coordinates_ = 0;
  StrainMeasure measure_ = StrainMeasure::small;
  MatrixX stress_modes_;                // 6n x k, or through the elements
  MatrixX fields_;                      // dofs x k, only if needed later; empty for nodal coordinates
  std::vector<int> free_dofs_;          // of nodal coordinates
  std::vector<SolidElement> elements_;  // empty: by stress modes
  std::map<std::pair<size_t, size_t>, MatrixX> extrapolation_;  // by number of nodes and points: nodes x points
  std::vector<Material> node_materials_;                        // of the elements that a node's values come from
  VectorX shares_;                                              // 1 / number of those elements
};

/// Equivalent stress √(½ ((σ1-σ2)² + (σ2-σ3)² + (σ3-σ1)²)) of each column.
VectorX von_mises(const Matrix6X& stress);
/// Principal stresses of each column, largest first.
Matrix3X principal(const Matrix6X& stress);
/// σ' = R σ Rᵀ: from axes whose directions in the new axes are the columns of R.
Matrix6X turned_stress(const Matrix6X& stress, const Matrix3& rotation);

/// Largest von Mises stress over time: of each node, and of all with time and place.
struct StressExtrema {
  VectorX largest;  // by node index, Pa; empty before the first instant
  VectorX times;    // when, s
  double value = 0, time = 0;
  int node = -1;  // index
  /// Throws SceneError for another number of nodes than before, or NaN.
  void add(double at, const Matrix6X& stress);
};

}  // namespace lithe
