#pragma once

#include <array>
#include <utility>

#include "engine/base/math.h"

/// Small dense kernels on column-major blocks of real or complex numbers, chosen by size once, when the elimination is
/// planned. Sizes 1 to 6 are known to the compiler; larger blocks (rare: long rows) take the plain loops.
namespace lithe::kernels {

inline constexpr int kFixed = 6;

// Sums begin with a product: GCC 12 copies what an array begins with in halves of a register and stalls as it reads the
// whole.

/// C -= A B with A m x k, B k x n.
template <class S>
using Product = void (*)(S* C, const S* A, const S* B, int m, int k, int n);
/// B <- P B with P k x k, B k x n.
template <class S>
using Apply = void (*)(const S* P, S* B, int k, int n);
/// y -= A x with A m x k.
template <class S>
using MultiplyVector = void (*)(S* y, const S* A, const S* x, int m, int k);
/// y = P y with P k x k.
template <class S>
using ApplyVector = void (*)(const S* P, S* y, int k);
/// P <- P⁻¹ without pivoting: pivots are inertias or compliances, definite by the order of elimination.
template <class S>
using Invert = void (*)(S* P, int k);

template <class S, int M, int K, int N>
void product(S* C, const S* A, const S* B, int m, int k, int n) {
  if constexpr (M > 0) m = M, k = K, n = N;
  for (int j = 0; j < n; ++j) {
    if constexpr (M > 0) {
      S sum[M];
      for (int i = 0; i < M; ++i) sum[i] = A[i] * B[K * j];
      for (int l = 1; l < K; ++l)
        for (int i = 0; i < M; ++i) sum[i] += A[i + M * l] * B[l + K * j];
      for (int i = 0; i < M; ++i) C[i + M * j] -= sum[i];
    } else {
      for (int l = 0; l < k; ++l)
        for (int i = 0; i < m; ++i) C[i + m * j] -= A[i + m * l] * B[l + k * j];
    }
  }
}

template <class S, int K, int N>
void apply(const S* P, S* B, int k, int n) {
  if constexpr (K > 0) k = K, n = N;
  S sum[K > 0 ? K : 64];
  for (int j = 0; j < n; ++j) {
    S* b = B + k * j;
    for (int i = 0; i < k; ++i) sum[i] = 0;
    for (int l = 0; l < k; ++l)
      for (int i = 0; i < k; ++i) sum[i] += P[i + k * l] * b[l];
    for (int i = 0; i < k; ++i) b[i] = sum[i];
  }
}

template <class S, int M, int K>
void multiply_vector(S* y, const S* A, const S* x, int m, int k) {
  if constexpr (M > 0) m = M, k = K;
  if constexpr (M > 0) {
    S sum[M];
    for (int i = 0; i < M; ++i) sum[i] = A[i] * x[0];
    for (int l = 1; l < K; ++l)
      for (int i = 0; i < M; ++i) sum[i] += A[i + M * l] * x[l];
    for (int i = 0; i < M; ++i) y[i] -= sum[i];
  } else {
    for (int l = 0; l < k; ++l)
      for (int i = 0; i < m; ++i) y[i] -= A[i + m * l] * x[l];
  }
}

/// By 3x3 blocks and cofactors: exact scaling behaviour, no branches.
template <class S, int K>
void invert(S* P, int k) {
  if constexpr (K > 0 && K <= 3) {
    Eigen::Map<Eigen::Matrix<S, K, K>> A(P);
    A = A.inverse().eval();
  } else if constexpr (K > 3) {
    constexpr int R = K - 3;
    Eigen::Map<Eigen::Matrix<S, K, K>> A(P);
    const Eigen::Matrix<S, 3, 3> a = A.template topLeftCorner<3, 3>().inverse();
    const Eigen::Matrix<S, 3, R> b = a * A.template topRightCorner<3, R>();
    const Eigen::Matrix<S, R, 3> c = A.template bottomLeftCorner<R, 3>() * a;
    const Eigen::Matrix<S, R, R> schur = A.template bottomRightCorner<R, R>() - A.template bottomLeftCorner<R, 3>() * b;
    const Eigen::Matrix<S, R, R> d = schur.inverse();
    A.template bottomRightCorner<R, R>() = d;
    const Eigen::Matrix<S, 3, R> bd = b * d;
    A.template topRightCorner<3, R>() = -bd;
    A.template bottomLeftCorner<R, 3>().noalias() = -d * c;
    A.template topLeftCorner<3, 3>() = a + bd * c;
  } else {  // Gauss-Jordan in place
    for (int p = 0; p < k; ++p) {
      const S pivot = 1.0 / P[p + k * p];
      P[p + k * p] = 1;
      for (int j = 0; j < k; ++j) P[p + k * j] *= pivot;
      for (int i = 0; i < k; ++i) {
        if (i == p) continue;
        const S f = P[i + k * p];
        P[i + k * p] = 0;
        for (int j = 0; j < k; ++j) P[i + k * j] -= f * P[p + k * j];
      }
    }
  }
}

template <class S, int K>
void apply_vector(const S* P, S* y, int k) {
  apply<S, K, K ? 1 : 0>(P, y, k, 1);
}

/// to = A, transposed = Aᵀ with A rows x 6.
template <class S, int Rows>
void copy_both_fixed(const S* A, S* to, S* transposed, int rows) {
  const Eigen::Map<const Eigen::Matrix<S, Rows ? Rows : Eigen::Dynamic, 6>> from(A, rows, 6);
  Eigen::Map<Eigen::Matrix<S, Rows ? Rows : Eigen::Dynamic, 6>>(to, rows, 6) = from;
  Eigen::Map<Eigen::Matrix<S, 6, Rows ? Rows : Eigen::Dynamic>>(transposed, 6, rows) = from.transpose();
}
template <class S>
void copy_both(const S* A, S* to, S* transposed, int rows) {
  switch (rows) {
    case 1:
      return copy_both_fixed<S, 1>(A, to, transposed, rows);
    case 3:
      return copy_both_fixed<S, 3>(A, to, transposed, rows);
    case 5:
      return copy_both_fixed<S, 5>(A, to, transposed, rows);
    default:
      return copy_both_fixed<S, 0>(A, to, transposed, rows);
  }
}

/// y += Aᵀ x with A rows x columns.
template <int Rows>
void add_transposed_fixed(double* y, const double* A, const double* x, int rows, int columns) {
  if constexpr (Rows > 0) rows = Rows;
  for (int c = 0; c < columns; ++c) {
    double sum = 0;
    for (int r = 0; r < rows; ++r) sum += A[r + rows * c] * x[r];
    y[c] += sum;
  }
}
inline void add_transposed(double* y, const double* A, const double* x, int rows, int columns) {
  switch (rows) {
    case 1:
      return add_transposed_fixed<1>(y, A, x, rows, columns);
    case 3:
      return add_transposed_fixed<3>(y, A, x, rows, columns);
    case 5:
      return add_transposed_fixed<5>(y, A, x, rows, columns);
    default:
      return add_transposed_fixed<0>(y, A, x, rows, columns);
  }
}

/// y += A x with A rows x columns.
template <int Rows>
void add_product_fixed(double* y, const double* A, const double* x, int rows, int columns) {
  if constexpr (Rows > 0) {
    double sum[Rows];
    for (int r = 0; r < Rows; ++r) sum[r] = y[r];
    for (int c = 0; c < columns; ++c)
      for (int r = 0; r < Rows; ++r) sum[r] += A[r + Rows * c] * x[c];
    for (int r = 0; r < Rows; ++r) y[r] = sum[r];
  } else {
    for (int c = 0; c < columns; ++c)
      for (int r = 0; r < rows; ++r) y[r] += A[r + rows * c] * x[c];
  }
}
inline void add_product(double* y, const double* A, const double* x, int rows, int columns) {
  switch (rows) {
    case 1:
      return add_product_fixed<1>(y, A, x, rows, columns);
    case 3:
      return add_product_fixed<3>(y, A, x, rows, columns);
    case 5:
      return add_product_fixed<5>(y, A, x, rows, columns);
    default:
      return add_product_fixed<0>(y, A, x, rows, columns);
  }
}

// ---- choice by size ----

template <class S, int... I>
Product<S> choose_product(int m, int k, int n, std::integer_sequence<int, I...>) {
  static constexpr Product<S> table[] = {product<S, I / 36 + 1, I / 6 % 6 + 1, I % 6 + 1>...};
  return table[(m - 1) * 36 + (k - 1) * 6 + (n - 1)];
}
template <class S>
Product<S> choose_product(int m, int k, int n) {
  if (m > kFixed || k > kFixed || n > kFixed) return product<S, 0, 0, 0>;
  return choose_product<S>(m, k, n, std::make_integer_sequence<int, 216>{});
}
template <class S, int... I>
Apply<S> choose_apply(int k, int n, std::integer_sequence<int, I...>) {
  static constexpr Apply<S> table[] = {apply<S, I / 6 + 1, I % 6 + 1>...};
  return table[(k - 1) * 6 + (n - 1)];
}
template <class S>
Apply<S> choose_apply(int k, int n) {
  if (k > kFixed || n > kFixed) return apply<S, 0, 0>;
  return choose_apply<S>(k, n, std::make_integer_sequence<int, 36>{});
}
template <class S, int... I>
MultiplyVector<S> choose_multiply_vector(int m, int k, std::integer_sequence<int, I...>) {
  static constexpr MultiplyVector<S> table[] = {multiply_vector<S, I / 6 + 1, I % 6 + 1>...};
  return table[(m - 1) * 6 + (k - 1)];
}
template <class S>
MultiplyVector<S> choose_multiply_vector(int m, int k) {
  if (m > kFixed || k > kFixed) return multiply_vector<S, 0, 0>;
  return choose_multiply_vector<S>(m, k, std::make_integer_sequence<int, 36>{});
}
template <class S>
Invert<S> choose_invert(int k) {
  static constexpr Invert<S> table[] = {invert<S, 0>, invert<S, 1>, invert<S, 2>, invert<S, 3>,
                                        invert<S, 4>, invert<S, 5>, invert<S, 6>};
  return table[k > kFixed ? 0 : k];
}
template <class S>
ApplyVector<S> choose_apply_vector(int k) {
  static constexpr ApplyVector<S> table[] = {apply_vector<S, 0>, apply_vector<S, 1>, apply_vector<S, 2>,
                                             apply_vector<S, 3>, apply_vector<S, 4>, apply_vector<S, 5>,
                                             apply_vector<S, 6>};
  return table[k > kFixed ? 0 : k];
}

}  // namespace lithe::kernels
