#pragma once

#include <vector>

#include "plugins/inertial_body/brick_mesh.h"
#include "plugins/inertial_body/lanes.h"

namespace lithe::brick {

/// All bricks of a body. The motion of one, total Lagrangian, X the place in the undeformed mesh:
///   F = Σ_a x_a ⊗ ∂N_a/∂X + Σ_k α_k ⊗ g_k,   E = ½ (FᵀF - 1),   U = Σ w (½ λ tr²E + μ E:E)
/// with the trilinear N_a of 8 nodes, 2 x 2 x 2 Gauss points and three incompatible modes 1 - ξ_k² whose gradients are
/// taken with the Jacobian of the centre, g_k = -2 ξ_k (det J0/det J) J0⁻ᵀ e_k (Taylor, Beresford & Wilson 1976: so
/// that distorted bricks pass the patch test). The modes carry no mass: each element keeps them where ∂U/∂α = 0, so
/// that U is a function of the nodes alone and all forces are its gradient. The element of CalculiX' C3D8I.
class Bricks {
 public:
  /// Throws SceneError for an element that is inside out, naming it.
  explicit Bricks(const BrickMesh& mesh);

  int batch_count() const { return static_cast<int>(batches_.size()); }
  int element_count() const { return element_count_; }
  /// Lower triangle of the nodal blocks that elements couple; degree of freedom 3 * node + axis.
  const LinearPattern& pattern() const { return pattern_; }
  /// Consistent mass along pattern(), and its scalar blocks m_ij summed over j: the mass at each node, kg.
  const VectorX& mass() const { return mass_; }
  const VectorX& nodal_mass() const { return nodal_mass_; }

  /// Finds the modes that are in equilibrium with nodes at x (3 x n, m), starting from none, so that they depend on x
  /// alone. False if an element is too distorted for that.
  bool find_modes(const double* x, std::vector<Modes>& modes) const;
  /// f += ∂U/∂x; returns U.
  double add_elastic_force(const double* x, const std::vector<Modes>& modes, double* f) const;
  /// f += β ∂R/∂v with R = ½ ∫ Ė:C:Ė, least over α̇: viscous, and blind to rigid motion however large.
  void add_viscous_force(const double* x, const std::vector<Modes>& modes, const double* v, double beta,
                         double* f) const;
  enum class Stiffness { tangent, material };  // with or without the stress's own part
  /// values += weight · ∂²U/∂x² along pattern(); material: of R, ∂²R/∂v².
  void add_stiffness(const double* x, const std::vector<Modes>& modes, Stiffness which, double weight,
                     double* values) const;

  /// F at a Gauss point (0 ... 7, fastest in ξ, then η, then ζ) of an element.
  Matrix3 deformation_gradient(int element, int point, const double* x, const std::vector<Modes>& modes) const;
  /// Volume that the point stands for in the undeformed mesh, m³.
  double weight(int element, int point) const { return batches_[element / kLanes].weight[point][element % kLanes]; }

 private:
  struct Batch {
    Lanes gradient[kPoints][kShapes][3];
    Lanes weight[kPoints];
    double size = 0;  // of its smallest element, m
    int count = 0;    // elements; the lanes beyond repeat the last
    int node[kNodes][kLanes];
    /// Of each pair of nodes a >= b: where in pattern() the rows of the larger node index begin, in the three columns
    /// of the smaller; `swapped` if the larger is b.
    int place[kNodes * (kNodes + 1) / 2][kLanes][3];
    bool swapped[kNodes * (kNodes + 1) / 2][kLanes];
  };
  void gather(const Batch& batch, const double* x, Lanes* out) const;
  void set_reference(const BrickMesh& mesh, int element, Batch& batch, int lane);
  void set_pattern(const BrickMesh& mesh);
  void set_mass(const BrickMesh& mesh);
  bool find_modes(const Batch& batch, const double* x, Modes& modes) const;
  double strain_energy_and_stress(const Batch& batch, int point, const Lanes33& F, Lanes33& S) const;

  std::vector<Batch> batches_;
  int element_count_ = 0;
  bool has_modes_ = true;
  double lambda_ = 0, mu_ = 0;
  LinearPattern pattern_;
  VectorX mass_, nodal_mass_;
};

}  // namespace lithe::brick
