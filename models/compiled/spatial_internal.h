#pragma once

#include <array>

namespace lithe {

/// Three components, over any scalar: a number of a calculation that is written down has no Eigen.
template <class S>
using CompiledVector = std::array<S, 3>;

template <class S>
CompiledVector<S> operator+(const CompiledVector<S>& a, const CompiledVector<S>& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <class S>
CompiledVector<S> compiled_cross(const CompiledVector<S>& a, const CompiledVector<S>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// A symmetric 3 x 3 matrix, its lower half.
template <class S>
struct CompiledSymmetric {
  S xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
  S& at(int i, int j) { return i == j ? (i == 0 ? xx : i == 1 ? yy : zz) : i + j == 1 ? xy : i + j == 2 ? xz : yz; }
  const S& at(int i, int j) const { return const_cast<CompiledSymmetric*>(this)->at(i, j); }
  CompiledVector<S> times(const CompiledVector<S>& a) const {
    return {xx * a[0] + xy * a[1] + xz * a[2], xy * a[0] + yy * a[1] + yz * a[2], xz * a[0] + yz * a[1] + zz * a[2]};
  }
  CompiledSymmetric inverse() const {
    const S A = yy * zz - yz * yz, B = xz * yz - xy * zz, C = xy * yz - xz * yy;
    const S scale = S(1) / (xx * A + xy * B + xz * C);
    CompiledSymmetric I;
    I.xx = A * scale, I.xy = B * scale, I.xz = C * scale;
    I.yy = (xx * zz - xz * xz) * scale, I.yz = (xy * xz - xx * yz) * scale, I.zz = (xx * yy - xy * xy) * scale;
    return I;
  }
};

/// A rotation by an angle of known cosine and sine in the plane of two axes: about z (0, 1) or x (1, 2). It takes
/// components along the turned axes to those along the axes before the turn; `back` the other way.
template <class S>
struct CompiledTurn {
  int i, j;
  S c, s;
  bool quarters = false;  // by one or more: entries change places and signs alone

  CompiledVector<S> apply(CompiledVector<S> a) const {
    const S x = c * a[i] - s * a[j], y = s * a[i] + c * a[j];
    a[i] = x, a[j] = y;
    return a;
  }
  CompiledVector<S> back(CompiledVector<S> a) const {
    const S x = c * a[i] + s * a[j], y = c * a[j] - s * a[i];
    a[i] = x, a[j] = y;
    return a;
  }
  /// R A Rᵀ: the trace of the plane's block stays, and w moves from one diagonal entry to the other.
  void apply(CompiledSymmetric<S>& A) const {
    const int k = 3 - i - j;
    S &a = A.at(i, i), &d = A.at(j, j), &b = A.at(i, j), &x = A.at(k, i), &y = A.at(k, j);
    if (quarters) {
      const S first = c * c * a + s * s * d;
      d = s * s * a + c * c * d, a = first, b = (c * c - s * s) * b;
    } else {
      const S w = s * (a - d) + (S(2) * c) * b, moved = s * w;
      b = c * w - b;
      a = a - moved, d = d + moved;
    }
    const S turned = c * x - s * y;
    y = s * x + c * y, x = turned;
  }
  /// R A Rᵀ of any matrix: besides, the difference of the two other entries stays.
  void apply(std::array<CompiledVector<S>, 3>& A) const {
    const int k = 3 - i - j;
    S &a = A[i][i], &d = A[j][j], &b = A[i][j], &e = A[j][i];
    if (quarters) {
      const S first = c * c * a + s * s * d, second = c * c * b - s * s * e;
      d = s * s * a + c * c * d, e = c * c * e - s * s * b, a = first, b = second;
    } else {
      const S sum = b + e, w = s * (a - d) + c * sum, moved = s * w, more = c * w - sum;
      a = a - moved, d = d + moved;
      b = b + more, e = e + more;
    }
    const S row = c * A[k][i] - s * A[k][j], column = c * A[i][k] - s * A[j][k];
    A[k][j] = s * A[k][i] + c * A[k][j], A[k][i] = row;
    A[j][k] = s * A[i][k] + c * A[j][k], A[i][k] = column;
  }
};

}  // namespace lithe
