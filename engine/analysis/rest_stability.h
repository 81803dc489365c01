#pragma once

#include "engine/analysis/equilibrium.h"
#include "engine/analysis/static_equations.h"

namespace lithe {

/// Fills in whether the rest of `found` is stable: the smallest ω² of K d = ω² M d with G d = 0, K = ∂F/∂q by
/// differences of the balance over `length` (m, rad, of fourth order).
///
/// Davidson's method (1975): the lowest Ritz pair of a space that grows by (K + σM)⁻¹ of its residual, with the tangent
/// factor of the search. Up to kMostVectors freedoms the space becomes all of them. Beyond, that nothing lower was
/// missed is what a Cholesky factor of K + σM + Gᵀ ρ G tells: where it exists, K + σM is positive on what the joints
/// allow (Finsler 1937). Where it does not, shifts σ of all sizes are tried: a negative ω² is the extreme one for some.
void judge_rest(StaticEquations& balance, double length, Equilibrium& found);

}  // namespace lithe
