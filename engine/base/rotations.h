#pragma once

#include "engine/base/math.h"

/// Rotation matrices from the data of drawings and other programs. Each takes components along the rotated axes to
/// components along the fixed ones, as marker and body orientations do; angles in radians.
namespace lithe {

/// Euler angles 3-1-3 (precession, nutation, spin): about z, then about the new x, then about the new z.
///   R = Rz(precession) Rx(nutation) Rz(spin)
/// Adams' B313; the usual Euler angles.
Matrix3 rotation_from_euler_313(double precession, double nutation, double spin);
/// Euler angles 3-2-1 (yaw, pitch, roll; Tait-Bryan, Cardan): about z, then about the new y, then about the new x.
///   R = Rz(yaw) Ry(pitch) Rx(roll)
Matrix3 rotation_from_euler_321(double yaw, double pitch, double roll);

/// The rotation nearest to a matrix that was printed with five digits or more: its polar factor, which differs least
/// in the sum of squares (Higham, Functions of Matrices, 2008, ch. 8). Throws SceneError for a matrix that is no
/// rotation to 1e-4 (max|RᵀR - E|), left-handed ones included.
Matrix3 nearest_rotation(const Matrix3& printed);

/// Axes whose z points along `z`, for the markers of a joint: its axis. Their x is the part of `x` at right angles to
/// z; without `x` it comes from the world axis that is farthest from z. Lengths do not matter. Throws SceneError for a
/// vector without direction, and for an `x` along z.
Matrix3 axes_along(const Vector3& z, const Vector3& x = Vector3::Zero());

}  // namespace lithe
