#pragma once

#include <algorithm>

namespace lithe::brick {

/// Four elements are computed at once: one number of each in a vector register. Functions take lanes by reference, as
/// the way vectors are passed by value depends on the processor.
inline constexpr int kLanes = 4;
using Lanes = double __attribute__((vector_size(kLanes * sizeof(double))));

inline constexpr int kNodes = 8, kModes = 3, kShapes = kNodes + kModes, kPoints = 8;

struct Modes {  // displacement of the incompatible modes of four elements, m: alpha[3 * mode + axis]
  Lanes alpha[3 * kModes];
};

inline void clear(Lanes* x, int n) {
  for (int i = 0; i < n; ++i) x[i] = Lanes{};
}

/// 3 x 3 of lanes, row-major.
struct Lanes33 {
  Lanes at[9];
  Lanes& operator()(int i, int j) { return at[3 * i + j]; }
  const Lanes& operator()(int i, int j) const { return at[3 * i + j]; }
};

/// F += Σ_a x_a ⊗ g_a over `count` shapes with values x (3 each) and gradients g.
inline void add_gradient(const Lanes* x, const Lanes (*g)[3], int count, Lanes33& F) {
  for (int a = 0; a < count; ++a)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) F(i, j) += x[3 * a + i] * g[a][j];
}

/// y = A g.
inline void multiply(const Lanes33& A, const Lanes* g, Lanes* y) {
  for (int i = 0; i < 3; ++i) y[i] = A(i, 0) * g[0] + A(i, 1) * g[1] + A(i, 2) * g[2];
}
inline void multiply(const Lanes33& A, const Lanes33& B, Lanes33& C) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) C(i, j) = A(i, 0) * B(0, j) + A(i, 1) * B(1, j) + A(i, 2) * B(2, j);
}

/// A = L D Lᵀ of a symmetric n x n matrix in place, row-major, lower triangle: L below the diagonal, 1/D on it. No
/// pivoting: A is definite wherever the material is stable.
template <int N>
inline void factorize(Lanes (&A)[N][N]) {
  for (int j = 0; j < N; ++j) {
    Lanes scaled[N];
    for (int k = 0; k < j; ++k) {
      scaled[k] = A[j][k];
      A[j][k] = scaled[k] * A[k][k];  // A[k][k] holds 1/D
      A[j][j] -= scaled[k] * A[j][k];
    }
    for (int i = j + 1; i < N; ++i)
      for (int k = 0; k < j; ++k) A[i][j] -= A[i][k] * A[j][k];
    A[j][j] = 1.0 / A[j][j];
  }
}
/// x <- L⁻¹ x.
template <int N>
inline void forward(const Lanes (&A)[N][N], Lanes* x) {
  for (int i = 0; i < N; ++i)
    for (int k = 0; k < i; ++k) x[i] -= A[i][k] * x[k];
}
/// x <- A⁻¹ x.
template <int N>
inline void solve(const Lanes (&A)[N][N], Lanes* x) {
  forward(A, x);
  for (int i = N - 1; i >= 0; --i) {
    x[i] *= A[i][i];
    for (int k = i + 1; k < N; ++k) x[i] -= A[k][i] * x[k];
  }
}

inline double largest(const Lanes& x) {
  double most = 0;
  for (int l = 0; l < kLanes; ++l) most = std::max(most, x[l] < 0 ? -x[l] : x[l]);
  return most;
}

}  // namespace lithe::brick
