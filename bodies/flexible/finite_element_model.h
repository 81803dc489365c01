#pragma once

#include <Eigen/SparseCore>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bodies/material.h"
#include "engine/base/math.h"

namespace lithe {

using SparseMatrix = Eigen::SparseMatrix<double>;
struct DrawnSkin;  // bodies/flexible/drawn_skin.h

/// Elements of one type and material: connectivity by node index (0-based), CalculiX/Abaqus node order. For pictures;
/// with a material, also for stress and geometric stiffness (bodies/flexible/elements).
struct ElementBlock {
  std::string type;                     // "C3D8", "C3D8I", "C3D20", "C3D10", ...
  std::vector<std::vector<int>> nodes;  // node indices of each element
  Material material{};
};

/// A rotation of a node that is a degree of freedom beside its translations (beams, shells).
struct RotationalDof {
  int node;  // index
  int axis;  // 0, 1, 2: about x, y, z of the mesh
};

/// Stress stiffness of the body under one load, as a finite-element code gives it: K(loaded) - K(unloaded).
struct StressStiffness {
  VectorX load;         // nodal forces, one a degree of freedom, mesh axes, N
  SparseMatrix matrix;  // dofs x dofs, N/m, both triangles
};

/// A finite-element model at t = 0: nodes, M_A and K_A in the axes of the mesh (Vlasenko & Kasper,
/// I-II). Degree of freedom 3 * node + axis for translations, then one for each of `rotations`; no support is applied:
/// K has six zero eigenvalues.
struct FiniteElementModel {
  std::string name;                                 // where it came from, for messages
  std::vector<int> node_ids;                        // labels of the FE code, by node index
  Matrix3X nodes;                                   // 3 x n positions, metres
  std::vector<RotationalDof> rotations;             // degrees of freedom 3n, 3n + 1, ...; none for solids
  SparseMatrix stiffness;                           // dofs x dofs, N/m, both triangles
  SparseMatrix mass;                                // dofs x dofs, kg, both triangles, consistent or lumped
  SparseMatrix damping;                             // dofs x dofs, N s/m, or empty: none given
  std::vector<StressStiffness> stress_stiffness{};  // for bodies whose elements are not known; may be empty
  /// Third derivatives of the strain energy, of elements that are not solids: for modes (dofs x nm, mesh axes; rotation
  /// vectors at nodes) the forces v ↦ ∂²ε/∂η_k∂η_l · ∂σ/∂v, dofs x pairs as QuadraticDeflection counts them. May be
  /// empty.
  std::function<MatrixX(const MatrixX& modes)> second_order_forces{};
  std::map<std::string, std::vector<int>> node_sets;  // node labels by set name
  std::vector<ElementBlock> elements;                 // may be empty
  std::shared_ptr<const DrawnSkin> skin{};            // of line elements, mesh axes; null: they are drawn as lines

  int node_count() const { return static_cast<int>(nodes.cols()); }
  int dof_count() const { return 3 * node_count() + static_cast<int>(rotations.size()); }
  /// Index of a node label; throws SceneError naming the model and the nearest labels.
  int node_index(int id) const;
  /// Node labels of a set; throws SceneError listing the known sets.
  const std::vector<int>& node_set(const std::string& set) const;
};

/// The results of checking a model, each figure on its natural scale (docs/equations.md section 2.1).
struct ModelCheck {
  std::string name;  // of the model
  int nodes = 0;
  int rotations = 0;                  // nodal rotations among the degrees of freedom
  double mass = 0;                    // kg, Phiᵀ M Phi
  Vector3 center = Vector3::Zero();   // centre of mass, mesh axes
  Matrix3 inertia = Matrix3::Zero();  // about the centre of mass, mesh axes
  double stiffness_asymmetry = 0;     // max|K - Kᵀ| / max|K|
  double mass_asymmetry = 0;
  double rigid_residual[6] = {};  // |K r| / (|K| |r|), max norms: three translations, three rotations about the centre
  double mass_isotropy = 0;       // of the translations, max|S_ij - tr(S_ij)/3 E| / max|S|: scalar interpolation if
                                  // <= 1e-10; else, and with rotations, J1, J2, C1 are of lumped masses (2.4)
  double row_sum_deviation = 0;   // eqs. (19)-(20): max|sum_j S_ij - k_i E| / max|k_i|
  bool mass_positive = false;     // Cholesky of M succeeds
  int stiffness_negative = 0;     // negative eigenvalues of K + small shift M beyond round-off
  std::string report() const;     // the sheet a user reads
};

/// Index of a label, and a set by name, as FiniteElementModel and ModalBasis look them up; `name` is for the error.
int find_node_index(const std::string& name, const std::vector<int>& node_ids, int id);
const std::vector<int>& find_node_set(const std::string& name, const std::map<std::string, std::vector<int>>& node_sets,
                                      const std::string& set);

/// Block sums m_ij = tr(S_ij)/3 of a nodal mass matrix, n x n: the scalar mass where S_ij = m_ij E.
SparseMatrix scalar_mass(const SparseMatrix& mass);
/// Rigid motions of nodes about a point c, 3n x 6: three unit translations e, three unit rotations e x (r - c).
MatrixX rigid_motions(const Matrix3X& nodes, const Vector3& center);

/// Whether check() factorises K to count its negative eigenvalues; not needed if the caller factorises K next.
enum class Definiteness { counted, not_looked_at };
/// Checks a model. Throws SceneError only if it cannot be checked (sizes that do not match, NaN, unknown labels).
ModelCheck check(const FiniteElementModel& model, Definiteness definiteness = Definiteness::counted);
/// check(), then throws SceneError if the model is unusable: asymmetry, mass <= 0, a rigid motion with
/// stiffness, indefinite M or K, asymmetric damping. Names the figure, the bound and how to fix it.
ModelCheck require_sound(const FiniteElementModel& model, Definiteness definiteness = Definiteness::counted);

}  // namespace lithe
