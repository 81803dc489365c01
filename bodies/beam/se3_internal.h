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
Analytic right_inverse_at(const Vector6& d);  // T⁻¹; its blocks of -d are those of d, turned_back()

/// The matrix [F, G; 0, F]: of such a function, of its derivatives, and of the bracket of twists.
struct Blocks {
  Matrix3 F, G;
  Vector6 operator*(const Vector6& x) const {
    Vector6 y;
    y << F * x.head<3>() + G * x.tail<3>(), F * x.tail<3>();
    return y;
  }
  /// [Fᵀ, Gᵀ; 0, Fᵀ].
  Blocks turned_back() const { return {F.transpose(), G.transpose()}; }
  Matrix6 matrix() const {
    Matrix6 M;
    M << F, G, Matrix3::Zero(), F;
    return M;
  }
};
Blocks blocks(const Analytic& c, const Vector6& d);
/// ∂([F, G; 0, F] x)/∂d.
Blocks rates(const Analytic& c, const Vector6& d, const Vector6& x);

/// log(A⁻¹ B) of two poses, turned against each other by less than half a turn.
Vector6 log_between(const Vector3& p_A, const Matrix3& R_A, const Vector3& p_B, const Matrix3& R_B);

}  // namespace lithe::se3
