#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/math.h"

/// The conditions of one contact: projections onto its cone and discs, and its exact solution when all other contacts
/// are held.
namespace lithe::friction_block {

using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

/// Nearest point of Coulomb's cone |x_t| <= μ x_n; axis 0 is the normal.
inline Vector3 project_on_cone(const Vector3& x, double friction) {
  const double across = std::hypot(x[1], x[2]);
  if (x[0] >= 0 && across <= friction * x[0]) return x;
  if (x[0] + friction * across <= 0) return Vector3::Zero();
  const double normal = (x[0] + friction * across) / (1 + friction * friction);
  const double shrink = across > 0 ? friction * normal / across : 0;
  return {normal, shrink * x[1], shrink * x[2]};
}

/// Nearest point of the disc |x| <= radius; on a line: of the interval.
template <class Vector>
Vector project_on_disc(const Vector& x, double radius) {
  const double length = x.norm();
  return length <= radius ? x : Vector(x * (radius / length));
}

/// Impulse r of one contact under u = W r + q and Coulomb's law: separate if q_n >= 0, else stick if
/// the impulse that stops it lies in the cone, else slide in the direction that r itself brings about (Bonnefon and
/// Daviet, Quartic formulation of Coulomb 3D frictional contact, 2011; here Newton's method on the angle). Stick before
/// slide also answers Painlevé's rod, whose sliding impulse would have to pull. W may be singular.
Vector3 solve(const Matrix3& W, const Vector3& q, double friction);

/// Moment m of |m| <= limit under u = W m + q: u = 0, or m = -limit u / |u|.
Vector2 solve_disc(const Matrix2& W, const Vector2& q, double limit);

/// The same about one axis.
inline double solve_interval(double W, double q, double limit) {
  if (limit <= 0) return 0;
  if (W <= 0) return q > 0 ? -limit : q < 0 ? limit : 0;
  return std::clamp(-q / W, -limit, limit);
}

}  // namespace lithe::friction_block
