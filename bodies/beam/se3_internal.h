#pragma once

#include "engine/base/math.h"

/// Maps of the group of rigid motions SE(3), for coordinates d = (u, φ): translation, rotation; so are twists and, by
/// duality, wrenches. With dual numbers φ + ε u for φ they are functions of SO(3):  f(φ + ε u) = f(φ) + ε f'(φ) u.
/// V. Sonneville, A. Cardona, O. Brüls, Comput. Methods Appl. Mech. Engrg. 268 (2014) 451, appendix.
namespace lithe::se3 {

/// A rigid motion: place and axes.
struct Pose {
  Vector3 p;
  Matrix3 R;
};
Pose exp(const Vector6& d);

/// A function [f(φ), f'(φ) u; 0, f(φ)] of d, f = E + odd φ~ + even φ~², by its coefficients and their first and second
/// derivatives by t = |φ|².
struct Analytic {
  double odd, odd_rate, odd_second, even, even_rate, even_second;
};
Analytic right_at(const Vector6& d);  // T, the right Jacobian: exp(d) moves by the twist T(d) d_dot, axes of its end
Analytic right_inverse_at(const Vector6& d);  // T⁻¹; of -d, blocks F and G are those of d, transposed

/// [F, G; 0, F].
struct Blocks {
  Matrix3 F, G;
};
Blocks blocks(const Analytic& c, const Vector6& d);
/// ∂([F, G; 0, F] x)/∂d = [D, E; 0, D].
struct Rates {
  Matrix3 D, E;
};
Rates rates(const Analytic& c, const Vector6& d, const Vector6& x);

/// log(A⁻¹ B) of two poses, turned against each other by less than half a turn.
Vector6 log_between(const Vector3& p_A, const Matrix3& R_A, const Vector3& p_B, const Matrix3& R_B);

}  // namespace lithe::se3
