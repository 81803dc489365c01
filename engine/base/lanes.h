#pragma once

#include "engine/base/math.h"

namespace lithe {

/// A three-vector in one register of four numbers, the fourth zero: what small kernels are written in where Eigen's
/// Vector3, which fills no register, is too slow. Element by element +, -, * as the compilers (GCC, Clang) have them.
using Lanes = double __attribute__((vector_size(32)));

namespace lanes {

inline Lanes of(double x, double y, double z) { return Lanes{x, y, z, 0}; }
inline Lanes of(const Vector3& a) { return Lanes{a[0], a[1], a[2], 0}; }
inline Lanes from(const double* a) { return Lanes{a[0], a[1], a[2], 0}; }
inline Lanes none() { return Lanes{0, 0, 0, 0}; }
inline void store(const Lanes& a, double* to) { to[0] = a[0], to[1] = a[1], to[2] = a[2]; }
inline Vector3 vector(const Lanes& a) { return {a[0], a[1], a[2]}; }

inline double sum(const Lanes& a) { return a[0] + a[1] + a[2]; }
inline double dot(const Lanes& a, const Lanes& b) { return sum(a * b); }
inline Lanes cross(const Lanes& a, const Lanes& b) {
  const Lanes c = a * __builtin_shufflevector(b, b, 1, 2, 0, 3) - __builtin_shufflevector(a, a, 1, 2, 0, 3) * b;
  return __builtin_shufflevector(c, c, 1, 2, 0, 3);
}

/// A 3 x 3 matrix by its columns.
struct Columns {
  Lanes c[3];
  Lanes operator*(const Lanes& x) const { return c[0] * x[0] + c[1] * x[1] + c[2] * x[2]; }
  Lanes operator*(const Vector3& x) const { return c[0] * x[0] + c[1] * x[1] + c[2] * x[2]; }
  /// Aᵀ x.
  Lanes transposed_times(const Lanes& x) const { return of(dot(c[0], x), dot(c[1], x), dot(c[2], x)); }
};
inline Columns columns(const Matrix3& A) { return {{of(A.col(0)), of(A.col(1)), of(A.col(2))}}; }

/// A spatial vector, of motion (acceleration, ω̇) or of force (force, torque).
struct Spatial {
  Lanes linear, angular;
  Spatial& operator+=(const Spatial& b) { return linear += b.linear, angular += b.angular, *this; }
  Spatial& operator-=(const Spatial& b) { return linear -= b.linear, angular -= b.angular, *this; }
};
inline Spatial operator+(Spatial a, const Spatial& b) { return a += b; }
inline Spatial operator*(const Spatial& a, double s) { return {a.linear * s, a.angular * s}; }
inline double dot(const Spatial& a, const Spatial& b) { return sum(a.linear * b.linear + a.angular * b.angular); }

}  // namespace lanes
}  // namespace lithe
