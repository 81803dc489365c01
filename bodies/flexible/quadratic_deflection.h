#pragma once

#include <memory>
#include <string>

#include "bodies/flexible/modal_basis.h"
#include "bodies/flexible/reduction.h"

namespace lithe {

/// The motions that the frame and rigid sets leave free, u = T z, with stiffness, mass and free rigid motions (body
/// axes).
struct SupportedProblem {
  SparseMatrix T, K, M;
  MatrixX rigid;
  MatrixX held{};  // means that the frame holds instead: heldᵀ z = 0; none: no columns
};

/// The second-order displacements for the modes of a basis, for a St. Venant-Kirchhoff body.
///   K θ_kl = -s_kl, s_kl: v ↦ 2 ∫ C E2(φ_k, φ_l) : ∇v, E2 the quadratic part of the Green-Lagrange strain
/// θ is the displacement that best relieves the second-order stress (a bent beam gets shorter, its sections turn
/// without stretching). Any load F (gravity, spin, joints) then produces the geometric stiffness -θ_klᵀ F =
/// φ_kᵀ K_σ(K⁻¹ F) φ_l (docs/equations.md 4.5), and the strain energy has no third-order part: φ_kᵀ K θ_lm cancels it.
/// `stiffened` leaves it at ½ ηᵀ K^ η; `quadratic` adds the fourth order. (Quadratic manifolds: Jain, Tiso, Rutzmoser &
/// Rixen 2017, Computers & Structures 188; their modal derivatives solve for more than s_kl.) Needs the elements and
/// their materials, which must give the model's K; `stiffened` also takes the model's stress_stiffness instead, for
/// loads in the span of those given, or its second_order_forces (beams). `mass`: of the model, in body axes.
/// SceneError if none is available.
std::shared_ptr<const QuadraticDeflection> make_quadratic_deflection(
    const FiniteElementModel& model, const ModalBasis& basis, const SupportedProblem& problem, const SparseMatrix& mass,
    const Reduction& reduction, const std::string& where);

}  // namespace lithe
