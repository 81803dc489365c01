#pragma once

#include <array>
#include <type_traits>
#include <utility>

#include "engine/base/math.h"
#include "engine/factor/lane_kernels.h"

/// Small dense kernels on column-major blocks of real or complex numbers, chosen by size once, when the elimination is
/// planned. Blocks of real numbers with up to six rows have columns of whole registers (lane_kernels.h); larger blocks
/// (rare: long rows) and complex ones take the plain loops.
namespace lithe::kernels {

inline constexpr int kFixed = 6;
inline constexpr int kRoom = 64;  // rows of a joint or force: no block is larger

/// Where an entry lies in a block of m rows: at place(i, m) + stride(m) · j.
template <class S>
int stride(int m) {
  return std::is_same_v<S, double> && m <= kFixed ? (m <= 3 ? 4 : 8) : m;
}
template <class S>
int place(int i, int m) {
  return std::is_same_v<S, double> && m <= kFixed ? lane::place(i) : i;
}

/// C -= A B with A m x k, B k x n; or C = -A B.
template <class S>
using Product = void (*)(S* C, const S* A, const S* B, int m, int k, int n);
/// B <- P B with P k x k, B k x n.
template <class S>
using Apply = void (*)(const S* P, S* B, int k, int n);
/// y -= A x with A m x k; y and x without gaps.
template <class S>
using MultiplyVector = void (*)(S* y, const S* A, const S* x, int m, int k);
/// y = P y with P k x k.
template <class S>
using ApplyVector = void (*)(const S* P, S* y, int k);
/// P <- P⁻¹ without pivoting: pivots are inertias or compliances, definite by the order of elimination.
template <class S>
using Invert = void (*)(S* P, int k);

// ---- any size ----

/// y -= A x, where x and y may be columns of blocks, with their gaps.
template <class S>
void subtract_column(S* y, const S* A, const S* x, int m, int k, bool x_of_block, bool y_of_block) {
  const int head = std::min(m, 3), gap = place<S>(3, m) - 3, y_gap = y_of_block ? gap : 0;
  for (int l = 0; l < k; ++l) {
    const S* a = A + stride<S>(m) * l;
    const S f = x[x_of_block ? place<S>(l, k) : l];
    for (int i = 0; i < head; ++i) y[i] -= a[i] * f;
    for (int i = head; i < m; ++i) y[i + y_gap] -= a[i + gap] * f;
  }
}
/// R rows and N columns of C -= A B in registers, each number in the order of subtract_column: the same bits. A and C
/// have columns `rows` apart, those of B are as of a block of k rows.
template <int R, int N>
void subtract_tile(double* C, const double* A, const double* B, int rows, int k) {
  double sum[N][R];
  for (int j = 0; j < N; ++j)
    for (int i = 0; i < R; ++i) sum[j][i] = C[i + rows * j];
  const int apart = stride<double>(k);
  for (int l = 0; l < k; ++l) {
    const double *a = A + rows * l, *b = B + place<double>(l, k);
    for (int j = 0; j < N; ++j)
      for (int i = 0; i < R; ++i) sum[j][i] -= a[i] * b[apart * j];
  }
  for (int j = 0; j < N; ++j)
    for (int i = 0; i < R; ++i) C[i + rows * j] = sum[j][i];
}
template <int N>
void subtract_columns(double* C, const double* A, const double* B, int rows, int k) {
  int i = 0;
  for (; i + 8 <= rows; i += 8) subtract_tile<8, N>(C + i, A + i, B, rows, k);
  for (; i + 4 <= rows; i += 4) subtract_tile<4, N>(C + i, A + i, B, rows, k);
  for (; i < rows; ++i) subtract_tile<1, N>(C + i, A + i, B, rows, k);
}
/// C -= A B; `rows`: whole columns of C and A, gaps and all.
inline void subtract_product(double* C, const double* A, const double* B, int rows, int k, int n) {
  int j = 0;
  for (; j + 4 <= n; j += 4) subtract_columns<4>(C + rows * j, A, B + stride<double>(k) * j, rows, k);
  for (; j < n; ++j) subtract_columns<1>(C + rows * j, A, B + stride<double>(k) * j, rows, k);
}
template <class S, bool Fresh>
void product_any(S* C, const S* A, const S* B, int m, int k, int n) {
  if (Fresh) std::fill_n(C, stride<S>(m) * n, S(0));
  if constexpr (std::is_same_v<S, double>) {
    subtract_product(C, A, B, stride<S>(m), k, n);
  } else {
    for (int j = 0; j < n; ++j) subtract_column<S>(C + m * j, A, B + k * j, m, k, true, true);
  }
}
template <class S>
void apply_any(const S* P, S* B, int k, int n) {
  constexpr int kAtOnce = 4;
  S sum[kAtOnce * kRoom];
  const int rows = stride<S>(k);
  for (int j = 0; j < n; j += kAtOnce) {
    S* b = B + rows * j;
    const int columns = std::min(n - j, kAtOnce);
    product_any<S, true>(sum, P, b, k, k, columns);
    for (int i = 0; i < rows * columns; ++i) b[i] = -sum[i];
  }
}
template <class S>
void multiply_vector_any(S* y, const S* A, const S* x, int m, int k) {
  if constexpr (std::is_same_v<S, double>)
    if (m > kFixed && k > kFixed) return subtract_product(y, A, x, m, k, 1);
  subtract_column<S>(y, A, x, m, k, false, false);
}
template <class S>
void apply_vector_any(const S* P, S* y, int k) {
  S sum[kRoom] = {};
  multiply_vector_any<S>(sum, P, y, k, k);
  for (int i = 0; i < k; ++i) y[i] = -sum[i];
}
/// Gauss-Jordan in place; no gaps.
template <class S>
void invert_any(S* P, int k) {
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
/// to = A (m x n, columns `from` apart), or its transpose.
template <class S>
void copy_any(const S* A, S* to, int m, int n, int from) {
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < m; ++i) to[place<S>(i, m) + stride<S>(m) * j] = A[i + from * j];
}
template <class S>
void copy_transposed_any(const S* A, S* to, int m, int n, int from) {
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < m; ++i) to[place<S>(j, n) + stride<S>(n) * i] = A[i + from * j];
}

// ---- complex blocks of known size ----

// Sums begin with a product: GCC 12 copies what an array begins with in halves of a register and stalls as it reads the
// whole.

/// out = A b with A M x K.
template <class S, int M, int K>
void times(const S* A, const S* b, S* out) {
  for (int i = 0; i < M; ++i) out[i] = A[i] * b[0];
  for (int l = 1; l < K; ++l)
    for (int i = 0; i < M; ++i) out[i] += A[i + M * l] * b[l];
}
template <class S, int M, int K, int N, bool Fresh>
void product(S* C, const S* A, const S* B, int, int, int) {
  S sum[M];
  for (int j = 0; j < N; ++j) {
    times<S, M, K>(A, B + K * j, sum);
    for (int i = 0; i < M; ++i) C[i + M * j] = Fresh ? -sum[i] : C[i + M * j] - sum[i];
  }
}
template <class S, int K, int N>
void apply(const S* P, S* B, int, int) {
  S sum[K];
  for (int j = 0; j < N; ++j) {
    times<S, K, K>(P, B + K * j, sum);
    for (int i = 0; i < K; ++i) B[i + K * j] = sum[i];
  }
}
template <class S, int M, int K>
void multiply_vector(S* y, const S* A, const S* x, int, int) {
  S sum[M];
  times<S, M, K>(A, x, sum);
  for (int i = 0; i < M; ++i) y[i] -= sum[i];
}
template <class S, int K>
void apply_vector(const S* P, S* y, int) {
  apply<S, K, 1>(P, y, K, 1);
}

/// By 3x3 blocks and cofactors: exact scaling behaviour, no branches.
template <class S, int K>
void invert(S* P, int) {
  Eigen::Map<Eigen::Matrix<S, K, K>> A(P);
  if constexpr (K <= 3) {
    A = A.inverse().eval();
  } else {
    constexpr int R = K - 3;
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
  }
}

// ---- a point: three numbers of a plain vector, and s E in the first three rows and columns of a block ----

template <class S>
struct Three {
  Eigen::Matrix<S, 3, 1> a;
  explicit Three(const S* x) : a(x[0], x[1], x[2]) {}
  Three operator*(S s) const {
    Three out = *this;
    out.a *= s;
    return out;
  }
  void subtract(const S* x, int sign) {
    for (int i = 0; i < 3; ++i) a[i] -= static_cast<double>(sign) * x[i];
  }
  void subtract_from(S* y, int sign) const {
    for (int i = 0; i < 3; ++i) y[i] -= static_cast<double>(sign) * a[i];
  }
  void store(S* y) const {
    for (int i = 0; i < 3; ++i) y[i] = a[i];
  }
};
template <>
struct Three<double> {
  Lanes a;
  explicit Three(const double* x) : a(lanes::load3(x)) {}
  Three operator*(double s) const {
    Three out = *this;
    out.a *= s;
    return out;
  }
  void subtract(const double* x, int sign) { a = sign > 0 ? a - lanes::load3(x) : a + lanes::load3(x); }
  void subtract_from(double* y, int sign) const {
    lanes::store3(sign > 0 ? lanes::load3(y) - a : lanes::load3(y) + a, y);
  }
  void store(double* y) const { lanes::store3(a, y); }
};

template <class S>
struct Diagonal3 {
  S s;
  explicit Diagonal3(S s) : s(s) {}
  void add_to(S* block, int stride) const {
    for (int k = 0; k < 3; ++k) block[k * (stride + 1)] += s;
  }
  /// Of a block where nothing is yet.
  void put(S* block, int stride, int columns) const {
    std::fill_n(block, stride * columns, S(0));
    add_to(block, stride);
  }
};
/// Whole registers, as all other kernels read and write them.
template <>
struct Diagonal3<double> {
  lanes::Columns s;
  explicit Diagonal3(double s) : s(lanes::scalar(s)) {}
  void add_to(double* block, int stride) const {
    for (int k = 0; k < 3; ++k) lanes::store4(lanes::load4(block + k * stride) + s.c[k], block + k * stride);
  }
  void put(double* block, int stride, int columns) const {
    if (stride * columns > 12) std::fill_n(block, stride * columns, 0.0);
    for (int k = 0; k < 3; ++k) lanes::store4(s.c[k], block + k * stride);
  }
};

// ---- products with blocks of the values, which have no gaps ----

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

template <class S, bool Fresh, int... I>
Product<S> choose_product(int m, int k, int n, std::integer_sequence<int, I...>) {
  if constexpr (std::is_same_v<S, double>) {
    static constexpr Product<S> table[] = {lane::product<I / 36 + 1, I / 6 % 6 + 1, I % 6 + 1, Fresh>...};
    return table[(m - 1) * 36 + (k - 1) * 6 + (n - 1)];
  } else {
    static constexpr Product<S> table[] = {product<S, I / 36 + 1, I / 6 % 6 + 1, I % 6 + 1, Fresh>...};
    return table[(m - 1) * 36 + (k - 1) * 6 + (n - 1)];
  }
}
template <class S>
Product<S> choose_product(int m, int k, int n, bool fresh) {
  if (m > kFixed || k > kFixed || n > kFixed) return fresh ? product_any<S, true> : product_any<S, false>;
  constexpr auto sizes = std::make_integer_sequence<int, 216>{};
  return fresh ? choose_product<S, true>(m, k, n, sizes) : choose_product<S, false>(m, k, n, sizes);
}
template <class S, int... I>
Apply<S> choose_apply(int k, int n, std::integer_sequence<int, I...>) {
  if constexpr (std::is_same_v<S, double>) {
    static constexpr Apply<S> table[] = {lane::apply<I / 6 + 1, I % 6 + 1>...};
    return table[(k - 1) * 6 + (n - 1)];
  } else {
    static constexpr Apply<S> table[] = {apply<S, I / 6 + 1, I % 6 + 1>...};
    return table[(k - 1) * 6 + (n - 1)];
  }
}
template <class S>
Apply<S> choose_apply(int k, int n) {
  if (k > kFixed || n > kFixed) return apply_any<S>;
  return choose_apply<S>(k, n, std::make_integer_sequence<int, 36>{});
}
template <class S, int... I>
MultiplyVector<S> choose_multiply_vector(int m, int k, std::integer_sequence<int, I...>) {
  if constexpr (std::is_same_v<S, double>) {
    static constexpr MultiplyVector<S> table[] = {lane::multiply_vector<I / 6 + 1, I % 6 + 1>...};
    return table[(m - 1) * 6 + (k - 1)];
  } else {
    static constexpr MultiplyVector<S> table[] = {multiply_vector<S, I / 6 + 1, I % 6 + 1>...};
    return table[(m - 1) * 6 + (k - 1)];
  }
}
template <class S>
MultiplyVector<S> choose_multiply_vector(int m, int k) {
  if (m > kFixed || k > kFixed) return multiply_vector_any<S>;
  return choose_multiply_vector<S>(m, k, std::make_integer_sequence<int, 36>{});
}
template <class S, int... I>
Invert<S> choose_invert(int k, std::integer_sequence<int, I...>) {
  if constexpr (std::is_same_v<S, double>) {
    static constexpr Invert<S> table[] = {lane::invert<I + 1>...};
    return table[k - 1];
  } else {
    static constexpr Invert<S> table[] = {invert<S, I + 1>...};
    return table[k - 1];
  }
}
template <class S>
Invert<S> choose_invert(int k) {
  return k > kFixed ? invert_any<S> : choose_invert<S>(k, std::make_integer_sequence<int, 6>{});
}
template <class S, int... I>
ApplyVector<S> choose_apply_vector(int k, std::integer_sequence<int, I...>) {
  if constexpr (std::is_same_v<S, double>) {
    static constexpr ApplyVector<S> table[] = {lane::apply_vector<I + 1>...};
    return table[k - 1];
  } else {
    static constexpr ApplyVector<S> table[] = {apply_vector<S, I + 1>...};
    return table[k - 1];
  }
}
template <class S>
ApplyVector<S> choose_apply_vector(int k) {
  return k > kFixed ? apply_vector_any<S> : choose_apply_vector<S>(k, std::make_integer_sequence<int, 6>{});
}

/// Copies a block of the values, m x n with columns `from` apart, to one of the factor and, where that is not null, its
/// transpose. n is 3 or 6 where they are used.
template <class S>
using CopyBlock = void (*)(const S* A, S* to, S* to_transposed, int m, int n, int from);
template <class S>
void copy_block_any(const S* A, S* to, S* to_transposed, int m, int n, int from) {
  copy_any(A, to, m, n, from);
  if (to_transposed) copy_transposed_any(A, to_transposed, m, n, from);
}
template <int M, int N>
void copy_block(const double* A, double* to, double* to_transposed, int, int, int from) {
  lane::copy<M, N>(A, to, from);
  if (to_transposed) lane::copy_transposed<M, N>(A, to_transposed, from);
}
template <class S, int... I>
CopyBlock<S> choose_copy(int m, int n, std::integer_sequence<int, I...>) {
  if constexpr (std::is_same_v<S, double>) {
    static constexpr CopyBlock<S> table[] = {copy_block<I / 2 + 1, 3 * (I % 2 + 1)>...};
    return table[2 * (m - 1) + n / 3 - 1];
  } else {
    return copy_block_any<S>;
  }
}
template <class S>
CopyBlock<S> choose_copy(int m, int n) {
  if (m > kFixed || (n != 3 && n != 6)) return copy_block_any<S>;
  return choose_copy<S>(m, n, std::make_integer_sequence<int, 12>{});
}

}  // namespace lithe::kernels
