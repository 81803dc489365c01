#pragma once

#include "engine/base/lanes.h"

/// The kernels of block_kernels.h on blocks of real numbers of up to six rows and columns. A column of a block is one
/// register of four for up to three rows, two for up to six: three numbers each and one without meaning, always loaded
/// and stored whole, so that no load waits for a store of another width.
namespace lithe::kernels::lane {

using lanes::Columns;
using lanes::load3;
using lanes::load4;
using lanes::store4;

/// Of a column of M rows.
template <int M>
inline constexpr int kStride = M <= 3 ? 4 : 8;
inline constexpr int place(int i) { return i + (i >= 3); }

/// Rows of one register: 3, and what is left.
template <int M>
inline constexpr int kHead = M < 3 ? M : 3;

/// N numbers of a plain vector, N <= 3.
template <int N>
Lanes load(const double* a) {
  if constexpr (N == 3) return load3(a);
  if constexpr (N == 2) {
    lanes::Pair low;
    std::memcpy(&low, a, sizeof low);
    return __builtin_shufflevector(low, lanes::Pair{0, 0}, 0, 1, 2, 3);
  }
  return Lanes{a[0], 0, 0, 0};
}
template <int N>
void store(const Lanes& a, double* to) {
  if constexpr (N == 3) {
    lanes::store3(a, to);
  } else if constexpr (N == 2) {
    const lanes::Pair low = __builtin_shufflevector(a, a, 0, 1);
    std::memcpy(to, &low, sizeof low);
  } else {
    to[0] = a[0];
  }
}

/// One column of M rows in registers.
template <int M>
struct Column {
  static constexpr int kRegisters = M <= 3 ? 1 : 2;
  Lanes part[kRegisters];

  static Column of_block(const double* a) {
    Column c;
    for (int i = 0; i < kRegisters; ++i) c.part[i] = load4(a + 4 * i);
    return c;
  }
  static Column of_vector(const double* a) {
    Column c;
    c.part[0] = load<kHead<M>>(a);
    if constexpr (kRegisters == 2) c.part[1] = load<M - 3>(a + 3);
    return c;
  }
  void to_block(double* to) const {
    for (int i = 0; i < kRegisters; ++i) store4(part[i], to + 4 * i);
  }
  void to_vector(double* to) const {
    store<kHead<M>>(part[0], to);
    if constexpr (kRegisters == 2) store<M - 3>(part[1], to + 3);
  }
  Column operator*(double s) const {
    Column c;
    for (int i = 0; i < kRegisters; ++i) c.part[i] = part[i] * s;
    return c;
  }
  void add(const Column& b, double s) {
    for (int i = 0; i < kRegisters; ++i) part[i] += b.part[i] * s;
  }
  Column operator-(const Column& b) const {
    Column c;
    for (int i = 0; i < kRegisters; ++i) c.part[i] = part[i] - b.part[i];
    return c;
  }
  Column operator-() const {
    Column c;
    for (int i = 0; i < kRegisters; ++i) c.part[i] = -part[i];
    return c;
  }
};

/// A b, b by its components.
template <int M, int K>
struct Factor {
  Column<M> column[K];
  explicit Factor(const double* A) {
    for (int l = 0; l < K; ++l) column[l] = Column<M>::of_block(A + kStride<M> * l);
  }
  /// `b`: a column of a block, or a plain vector.
  template <bool Block>
  Column<M> times(const double* b) const {
    Column<M> sum = column[0] * b[0];
    for (int l = 1; l < K; ++l) sum.add(column[l], b[Block ? place(l) : l]);
    return sum;
  }
};

/// C -= A B, or C = -A B where nothing is there yet.
template <int M, int K, int N, bool Fresh>
void product(double* C, const double* A, const double* B, int, int, int) {
  const Factor<M, K> a(A);
  for (int j = 0; j < N; ++j) {
    const Column<M> sum = a.template times<true>(B + kStride<K> * j);
    double* c = C + kStride<M> * j;
    if constexpr (Fresh)
      (-sum).to_block(c);
    else
      (Column<M>::of_block(c) - sum).to_block(c);
  }
}

/// B <- P B.
template <int K, int N>
void apply(const double* P, double* B, int, int) {
  const Factor<K, K> p(P);
  for (int j = 0; j < N; ++j) {
    double* b = B + kStride<K> * j;
    p.template times<true>(b).to_block(b);
  }
}

/// y -= A x, plain vectors.
template <int M, int K>
void multiply_vector(double* y, const double* A, const double* x, int, int) {
  (Column<M>::of_vector(y) - Factor<M, K>(A).template times<false>(x)).to_vector(y);
}

/// y = P y, a plain vector.
template <int K>
void apply_vector(const double* P, double* y, int) {
  Factor<K, K>(P).template times<false>(y).to_vector(y);
}

/// Columns J to J + 2 of rows 0 to 2 or 3 to 5 of a K x K block; beyond K those of the unit matrix.
template <int K, int Part, int J>
Columns quarter(const double* P) {
  Columns out;
  for (int j = 0; j < 3; ++j)
    out.c[j] = J + j < K ? load4(P + kStride<K> * (J + j) + 4 * Part)
                         : Lanes{Part == J / 3 && j == 0 ? 1.0 : 0.0, Part == J / 3 && j == 1 ? 1.0 : 0.0,
                                 Part == J / 3 && j == 2 ? 1.0 : 0.0, 0};
  return out;
}
template <int K, int Part, int J>
void put(const Columns& A, double* P) {
  constexpr int rows = K - 3 * Part < 3 ? K - 3 * Part : 3;
  for (int j = 0; j < 3 && J + j < K; ++j) {
    Lanes a = A.c[j];
    if constexpr (rows == 2) a = __builtin_shufflevector(a, Lanes{0, 0, 0, 0}, 0, 1, 4, 5);
    if constexpr (rows == 1) a = __builtin_shufflevector(a, Lanes{0, 0, 0, 0}, 0, 4, 5, 6);
    store4(a, P + kStride<K> * (J + j) + 4 * Part);
  }
}

/// P <- P⁻¹ by 3 x 3 blocks and cofactors.
template <int K>
void invert(double* P, int) {
  if constexpr (K <= 3) {
    put<K, 0, 0>(lanes::inverse(quarter<K, 0, 0>(P)), P);
  } else {
    const Columns a = lanes::inverse(quarter<K, 0, 0>(P)), B = quarter<K, 0, 3>(P), C = quarter<K, 1, 0>(P);
    const Columns b = a * B, c = C * a;
    const Columns d = lanes::inverse(quarter<K, 1, 3>(P) - C * b);
    const Columns bd = b * d;
    put<K, 0, 0>(a + bd * c, P);
    put<K, 1, 0>(-1.0 * (d * c), P);
    put<K, 0, 3>(-1.0 * bd, P);
    put<K, 1, 3>(d, P);
  }
}

/// to = A with A M x N, its columns `stride` apart.
template <int M, int N>
void copy(const double* A, double* to, int stride) {
  for (int j = 0; j < N; ++j) Column<M>::of_vector(A + stride * j).to_block(to + kStride<M> * j);
}
/// to = Aᵀ.
template <int M, int N>
void copy_transposed(const double* A, double* to, int stride) {
  static_assert(N == 3 || N == 6);
  for (int i = 0; i < M; ++i)
    for (int part = 0; part < N / 3; ++part) {
      const double* a = A + i + 3 * stride * part;
      store4(lanes::of(a[0], a[stride], a[2 * stride]), to + kStride<N> * i + 4 * part);
    }
}

}  // namespace lithe::kernels::lane
