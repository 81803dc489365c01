#pragma once

#include <cstring>

#include "engine/base/math.h"

namespace lithe {

/// A three-vector in one register of four numbers, of which the fourth means nothing: what small kernels are written in
/// where Eigen's Vector3, which fills no register, is too slow. Element by element +, -, * as the compilers (GCC,
/// Clang) have them.
using Lanes = double __attribute__((vector_size(32)));

namespace lanes {

// The fourth is a copy of the third, not zero: to set it to zero costs an instruction, and one that valgrind 3.19,
// which counts instructions (tools/bench), does not know in all its forms.
inline Lanes of(double x, double y, double z) { return Lanes{x, y, z, z}; }
inline Lanes of(const Vector3& a) { return Lanes{a[0], a[1], a[2], a[2]}; }
inline Lanes from(const double* a) { return Lanes{a[0], a[1], a[2], a[2]}; }
inline Lanes none() { return Lanes{0, 0, 0, 0}; }
inline void store(const Lanes& a, double* to) { to[0] = a[0], to[1] = a[1], to[2] = a[2]; }
inline Vector3 vector(const Lanes& a) { return {a[0], a[1], a[2]}; }

// A processor hands a store on to a load that reads no more than that store wrote; a wider load waits until the store
// has reached the cache, a dozen cycles. So what is read soon after it was written is written and read by the same
// pieces: three numbers as two and one, four as one.
using Pair = double __attribute__((vector_size(16)));

/// Three numbers in a row.
inline Lanes load3(const double* a) {
  Pair low;
  std::memcpy(&low, a, sizeof low);
  const Pair high{a[2], a[2]};
  return __builtin_shufflevector(low, high, 0, 1, 2, 3);
}
inline void store3(const Lanes& a, double* to) {
  const Pair low = __builtin_shufflevector(a, a, 0, 1);
  std::memcpy(to, &low, sizeof low);
  to[2] = a[2];
}
/// Four numbers in a row.
inline Lanes load4(const double* a) {
  Lanes x;
  std::memcpy(&x, a, sizeof x);
  return x;
}
inline void store4(const Lanes& a, double* to) { std::memcpy(to, &a, sizeof a); }

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
  Lanes transposed_times(const Lanes& x) const;
};
inline Columns columns(const Matrix3& A) { return {{of(A.col(0)), of(A.col(1)), of(A.col(2))}}; }

/// A 3 x 3 matrix in memory, column after column, `stride` apart.
inline Columns load3x3(const double* a, int stride = 3) {
  return {{load3(a), load3(a + stride), load3(a + 2 * stride)}};
}
inline void store3x3(const Columns& A, double* to, int stride = 3) {
  store3(A.c[0], to), store3(A.c[1], to + stride), store3(A.c[2], to + 2 * stride);
}
inline Columns transposed(const Columns& A) {
  const Lanes even = __builtin_shufflevector(A.c[0], A.c[1], 0, 4, 2, 6),
              odd = __builtin_shufflevector(A.c[0], A.c[1], 1, 5, 3, 7),
              odd_2 = __builtin_shufflevector(A.c[2], A.c[2], 1, 1, 3, 3);
  return {{__builtin_shufflevector(even, A.c[2], 0, 1, 4, 5), __builtin_shufflevector(odd, odd_2, 0, 1, 4, 5),
           __builtin_shufflevector(even, A.c[2], 2, 3, 6, 7)}};
}
inline Lanes Columns::transposed_times(const Lanes& x) const {
  const Columns rows = transposed({{c[0] * x, c[1] * x, c[2] * x}});
  return rows.c[0] + rows.c[1] + rows.c[2];
}
inline Columns operator*(const Columns& A, const Columns& B) { return {{A * B.c[0], A * B.c[1], A * B.c[2]}}; }
inline Columns operator+(const Columns& A, const Columns& B) {
  return {{A.c[0] + B.c[0], A.c[1] + B.c[1], A.c[2] + B.c[2]}};
}
inline Columns operator-(const Columns& A, const Columns& B) {
  return {{A.c[0] - B.c[0], A.c[1] - B.c[1], A.c[2] - B.c[2]}};
}
inline Columns operator*(double s, const Columns& A) { return {{s * A.c[0], s * A.c[1], s * A.c[2]}}; }
/// a bᵀ.
inline Columns dyad(const Lanes& a, const Lanes& b) { return {{a * b[0], a * b[1], a * b[2]}}; }
/// s E.
inline Columns scalar(double s) { return {{s * Lanes{1, 0, 0, 0}, s * Lanes{0, 1, 0, 0}, s * Lanes{0, 0, 1, 0}}}; }
/// a~, of which column j is a × e_j.
inline Columns skewed(const Lanes& a) {
  const Lanes none{0, 0, 0, 0};
  return {{__builtin_shufflevector(a, none, 4, 2, 1, 4) * Lanes{1, 1, -1, 1},
           __builtin_shufflevector(a, none, 2, 4, 0, 4) * Lanes{-1, 1, 1, 1},
           __builtin_shufflevector(a, none, 1, 0, 4, 4) * Lanes{1, -1, 1, 1}}};
}
/// By cofactors: its rows are the cross products of the columns of A, over det A.
inline Columns inverse(const Columns& A) {
  const Lanes row = cross(A.c[1], A.c[2]);
  const double scale = 1 / dot(A.c[0], row);
  return scale * transposed({{row, cross(A.c[2], A.c[0]), cross(A.c[0], A.c[1])}});
}

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
