#pragma once

#include <memory>
#include <string>

#include "bodies/flexible/modal_basis.h"
#include "bodies/flexible/reduction.h"

namespace lithe {

/// What the frame and rigid sets leave free, u = T z, with its stiffness, mass and free rigid motions (body axes).
struct SupportedProblem {
  SparseMatrix T, K, M;
  MatrixX rigid;
};

/// The displacements of second order of a basis whose modes are there.
///   stiffened: K θ_kl = -f_kl, f_kl the nodal forces of the stress C E2(φ_k, φ_l), E2 the quadratic part of the
///     Green-Lagrange strain. A load F then meets the geometric stiffness -θ_klᵀ F = φ_kᵀ K_σ(K⁻¹ F) φ_l
///     (EQUATIONS.md 4.5), whatever it comes from: gravity, spin, joints.
///   quadratic: f_kl is the whole third derivative of the strain energy of a St. Venant-Kirchhoff body (static modal
///     derivatives: Idelsohn & Cardona 1985, Comput. Methods Appl. Mech. Eng. 49, 253), θ_kl is orthogonal to the
///     modes, and the energy on the manifold is kept to fourth order (Jain, Tiso et al. 2017, Mech. Syst. Signal
///     Process. 97).
/// Needs the elements and their materials, which must give the model's K; `stiffened` also takes the model's
/// stress_stiffness instead, for loads in the span of those given. SceneError where neither is there.
std::shared_ptr<const QuadraticDeflection> make_quadratic_deflection(const FiniteElementModel& model,
                                                                     const ModalBasis& basis,
                                                                     const SupportedProblem& problem,
                                                                     Deflection deflection, const std::string& where);

}  // namespace lithe
