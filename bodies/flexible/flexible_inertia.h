#pragma once

#include <memory>

#include "bodies/flexible/inertia_integrals.h"
#include "engine/base/math.h"
#include "engine/model/marker.h"

namespace lithe {

/// What M and f_v need of the deformed body at one state, body axes (docs/equations.md 2.3, 3.2, 3.3).
struct InertiaTerms {
  Vector3 s = Vector3::Zero();       // first moment about the frame origin
  Vector3 s_rate = Vector3::Zero();  // Ct η̇
  Matrix3 J = Matrix3::Zero();       // inertia about the frame origin
  Matrix3 J_rate = Matrix3::Zero();
  Matrix3X Cr;                          // rotation-deformation coupling, 3 x nm
  Vector3 h = Vector3::Zero();          // Cr η̇
  Vector3 Cr_rate_h = Vector3::Zero();  // Ċr η̇; zero for scalar interpolation
  VectorX quadratic;                    // f_v, modal rows
  Matrix3X G_omega;                     // columns (∂J/∂η_k) ω
  Matrix3X G_omega_dot;                 // columns (∂J/∂η_k) ω̇, for the tangent
  Matrix3X u;                           // columns C1_k η̇
  Matrix3X Cr_rate;                     // Ċr = η̇_k C1_k
  VectorX slopes;                       // by invariants: ∂J/∂η_k (xx yy zz xy xz yz), one after another
  Eigen::MatrixX3d r, u_nodal, mr, mu;  // nodal form only: positions, velocities, and the mass times them, n x 3

  explicit InertiaTerms(int modes);
};

/// Inertia of a flexible body as a function of its deformation, in two forms: by invariants, whose cost does not
/// depend on the mesh, and by nodes, for a body that keeps all its nodal coordinates.
class FlexibleInertia {
 public:
  virtual ~FlexibleInertia() = default;
  /// Level::position fills s, J, Cr; above, the rest.
  virtual void evaluate(const double* eta, const double* eta_rate, const Vector3& omega, Level level,
                        InertiaTerms& terms) const = 0;
  /// Columns (∂J/∂η_k) x at the state evaluated last.
  virtual void inertia_slopes(const InertiaTerms& terms, const Vector3& x, Matrix3X& columns) const = 0;
  double mass = 0;
  Matrix3X Ct;  // 3 x nm, constant
};

/// By inertia invariants: about 12 nm² multiply-adds.
class ModalInertia final : public FlexibleInertia {
 public:
  explicit ModalInertia(InertiaIntegrals integrals);
  void evaluate(const double* eta, const double* eta_rate, const Vector3& omega, Level level,
                InertiaTerms& terms) const override;
  void inertia_slopes(const InertiaTerms& terms, const Vector3& x, Matrix3X& columns) const override;
  const InertiaIntegrals& integrals() const { return I_; }

 private:
  InertiaIntegrals I_;
};

/// By nodes and scalar mass, for B that selects nodal coordinates (docs/equations.md 2.2, 3.1): linear in the
/// entries of m_ij.
class NodalInertia final : public FlexibleInertia {
 public:
  explicit NodalInertia(std::shared_ptr<const ModalBasis> basis);
  void evaluate(const double* eta, const double* eta_rate, const Vector3& omega, Level level,
                InertiaTerms& terms) const override;
  void inertia_slopes(const InertiaTerms& terms, const Vector3& x, Matrix3X& columns) const override;

 private:
  std::shared_ptr<const ModalBasis> basis_;
};

}  // namespace lithe
