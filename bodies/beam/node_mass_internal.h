#pragma once

#include "engine/base/math.h"

/// Inertia of a rigid piece with the mass matrix M about a point that moves with it, in its axes; twists and wrenches
/// are (translation, rotation).
namespace lithe::rigid_piece {

/// M V_dot - ad(V)ᵀ M V: what moves it (Euler and Poincaré).
Vector6 inertia_force(const Matrix6& mass, const Vector6& twist, const Vector6& rate);
/// Its derivative by the twist, where the point has no acceleration and the piece no angular acceleration.
Matrix6 gyroscopic(const Matrix6& mass, const Vector6& twist);
/// The rate of the twist then: (-ω × v, 0).
Vector6 rate_without_acceleration(const Vector6& twist);

}  // namespace lithe::rigid_piece
