#pragma once

#include "engine/base/math.h"

/// Inertia of a rigid piece with the mass matrix M about a point that moves with it, in its axes; twists and wrenches
/// are (translation, rotation).
namespace lithe::rigid_piece {

/// M V_dot - ad(V)ᵀ M V: what moves it (Euler and Poincaré).
Vector6 inertia_force(const Matrix6& mass, const Vector6& twist, const Vector6& rate);
/// The derivative of -ad(V)ᵀ M V by V.
Matrix6 momentum_rates(const Matrix6& mass, const Vector6& twist);
/// The derivative of V_dot = (-ω × v, 0) by V: that of a point without acceleration that does not spin up.
Matrix6 rate_by_twist(const Vector6& twist);
/// That of inertia_force() there.
Matrix6 gyroscopic(const Matrix6& mass, const Vector6& twist);

}  // namespace lithe::rigid_piece
