#include "engine/factor/banded_cholesky.h"

#include <algorithm>
#include <complex>
#include <limits>

namespace lithe {
namespace {

constexpr int kWidest = 24;       // a sparse factor with its own order does better beyond
constexpr double kWaste = 4;      // values of the band over entries, at most
constexpr double kRoundings = 8;  // a pivot of as many last bits of what it was made from is round-off alone
constexpr int kColumns = 3;       // of a solution at once: those of a pin
constexpr double kLeast = kRoundings * std::numeric_limits<double>::epsilon();

bool is_sound(double pivot, double diagonal) { return pivot > kLeast * std::abs(diagonal); }
bool is_sound(const std::complex<double>& pivot, const std::complex<double>& diagonal) {
  return std::abs(pivot) > kLeast * std::abs(diagonal);
}

/// Calls step(B) with the band as a constant: 5 and 8 are those of a cable without and with bending stiffness.
template <class Step>
auto with_band(int band, const Step& step) {
  if (band == 8) return step(std::integral_constant<int, 8>());
  if (band == 5) return step(std::integral_constant<int, 5>());
  return step(std::integral_constant<int, 0>());
}

/// The band as what with_band() knows of it.
template <int B>
auto as_constant(int band) {
  if constexpr (B > 0)
    return std::integral_constant<int, B>();
  else
    return band;
}

}  // namespace

template <class Scalar>
int BandedCholesky<Scalar>::band_of(const LinearPattern& pattern) {
  return pattern.rows.size() > 0 ? (pattern.rows - pattern.columns).maxCoeff() : 0;
}

template <class Scalar>
bool BandedCholesky<Scalar>::suits(int size, const LinearPattern& pattern) {
  const int band = band_of(pattern);
  return band <= kWidest && (band + 1.0) * size <= kWaste * static_cast<double>(pattern.rows.size());
}

template <class Scalar>
BandedCholesky<Scalar>::BandedCholesky(int size, const LinearPattern& pattern)
    : size_(size),
      band_(band_of(pattern)),
      outer_((size_ - band_) / 2),
      inner_(size_ - 2 * outer_),
      values_(static_cast<std::size_t>(outer_ * (band_ + 1) + (inner_ * inner_ + 1) / 2)),
      middle_(reinterpret_cast<Scalar*>(values_.data() + outer_ * (band_ + 1))),
      middle_diagonal_(static_cast<std::size_t>(inner_)),
      y_(static_cast<std::size_t>((outer_ + band_) * kColumns)) {
  const int middle = 2 * outer_ * (band_ + 1);
  std::vector<char> filled(static_cast<std::size_t>(middle + inner_ * inner_));
  for (int k = 0; k < pattern.rows.size(); ++k) {
    const int row = pattern.rows[k], column = pattern.columns[k];
    const bool front = column < outer_, back = row >= size_ - outer_;
    const int from_end = front ? column : size_ - 1 - row;
    places_.push_back(front || back ? 2 * (from_end * (band_ + 1) + row - column) + (front ? 0 : 1)
                                    : middle + inner_ * (row - outer_) + column - outer_);
    filled[static_cast<std::size_t>(places_.back())] = true;
  }
  for (std::size_t place = 0; place < filled.size(); ++place)
    if (!filled[place]) empty_.push_back(static_cast<int>(place));
}

template <class Scalar>
typename BandedCholesky<Scalar>::Ends BandedCholesky<Scalar>::ends(Scalar front, Scalar back) {
  if constexpr (std::is_same_v<Scalar, double>)
    return Ends{front, back};
  else
    return Ends(front, back);
}

/// By rows, with dot products whose latest entry comes last: nothing waits for more than one product. L and D of (j -
/// k, j - i), i >= k, lie i - k below the diagonal of column j - i. The middle's first and last rows have their L
/// beside the ends, and take from their D what those leave. B: the band if the compiler may know it, else 0.
template <class Scalar>
template <int B>
bool BandedCholesky<Scalar>::eliminate_ends() {
  const int band = B > 0 ? B : band_, stride = band + 1;
  Ends* const e = values_.data();
  Ends w[B > 0 ? B + 1 : kWidest + 1];  // L_jk d_k of the column k to the left
  bool sound = true;
  // Of the `count` columns to the left of row j all but the last `without`; returns w · L.
  const auto eliminate = [&](auto count, int j, int without) {
    const int diagonal = stride * j;
    Ends product = ends(0, 0);
#pragma GCC unroll 8  // w in registers
    for (int k = count; k > without; --k) {
      Ends* const column = e + (diagonal - stride * k);
      Ends sum = column[k];
#pragma GCC unroll 8
      for (int i = count; i > k; --i) sum -= w[i] * e[diagonal - stride * i + i - k];
      w[k] = sum;
      column[k] = sum * column[0];
      product += sum * column[k];
    }
    return product;
  };
  const auto row = [&](auto count, int j) {
    Ends& diagonal = e[stride * j];
    const Ends pivot = diagonal - eliminate(count, j, 0);
    sound = sound && is_sound(pivot[0], diagonal[0]) && is_sound(pivot[1], diagonal[1]);
    diagonal = ends(1, 1) / pivot;
  };
  const int begin = std::min(band, outer_);
  for (int j = 0; j < begin; ++j) row(j, j);
  for (int j = begin; j < outer_; ++j) row(as_constant<B>(band), j);
  for (int i = 0; i < band; ++i) {
    const int j = outer_ + i, count = std::min(j, band);
    eliminate(count, j, i);
    for (int l = 0; l <= i; ++l) {
      Ends sum = ends(0, 0);
      for (int k = count; k > i; --k) sum += w[k] * e[stride * (j - k) + l - i + k];
      middle_[inner_ * i + l] -= sum[0];
      middle_[inner_ * (inner_ - 1 - l) + inner_ - 1 - i] -= sum[1];
    }
  }
  return sound;
}

template <class Scalar>
bool BandedCholesky<Scalar>::eliminate_middle() {
  Scalar w[kWidest + 1];
  for (int j = 0; j < inner_; ++j) {
    Scalar* const row = middle_ + inner_ * j;
    Scalar pivot = row[j];
    for (int k = 0; k < j; ++k) {
      const Scalar* const above = middle_ + inner_ * k;
      w[k] = row[k];
      for (int i = 0; i < k; ++i) w[k] -= w[i] * above[i];
      row[k] = w[k] * above[k];
      pivot -= w[k] * row[k];
    }
    if (!is_sound(pivot, middle_diagonal_[static_cast<std::size_t>(j)])) return false;
    row[j] = 1.0 / pivot;
  }
  return true;
}

template <class Scalar>
bool BandedCholesky<Scalar>::factorize(const Scalar* entries) {
  auto* const values = reinterpret_cast<Scalar*>(values_.data());
  for (std::size_t k = 0; k < places_.size(); ++k) values[places_[k]] = entries[k];
  for (const int place : empty_) values[place] = Scalar(0);
  for (int i = 0; i < inner_; ++i) middle_diagonal_[static_cast<std::size_t>(i)] = middle_[(inner_ + 1) * i];
  return with_band(band_, [&](auto B) { return eliminate_ends<B>(); }) && eliminate_middle();
}

template <class Scalar>
void BandedCholesky<Scalar>::solve_middle(Scalar* x) const {
  const Scalar* const L = middle_;
  for (int j = 0; j < inner_; ++j) {
    Scalar sum = x[j];
    for (int k = 0; k < j; ++k) sum -= L[inner_ * j + k] * x[k];
    x[j] = sum;
  }
  for (int j = inner_ - 1; j >= 0; --j) {
    Scalar sum = L[(inner_ + 1) * j] * x[j];
    for (int k = inner_ - 1; k > j; --k) sum -= L[inner_ * k + j] * x[k];
    x[j] = sum;
  }
}

template <class Scalar>
template <int B, int Columns>
void BandedCholesky<Scalar>::solve(Scalar* x, Eigen::Index stride_x) const {
  const int band = B > 0 ? B : band_, stride = band + 1;
  const Ends* const e = values_.data();
  Ends* const y = y_.data();
  // Takes from row j what the `count` columns to its left give, all but the last `without`.
  const auto forward = [&](auto count, int j, int without) {
    Ends sum[Columns];
    for (int c = 0; c < Columns; ++c) sum[c] = y[Columns * j + c];
    for (int k = count; k > without; --k)
      for (int c = 0; c < Columns; ++c) sum[c] -= e[stride * (j - k) + k] * y[Columns * (j - k) + c];
    for (int c = 0; c < Columns; ++c) y[Columns * j + c] = sum[c];
  };
  for (int j = 0; j < outer_; ++j)
    for (int c = 0; c < Columns; ++c) y[Columns * j + c] = ends(x[c * stride_x + j], x[c * stride_x + size_ - 1 - j]);
  const int begin = std::min(band, outer_);
  for (int j = 0; j < begin; ++j) forward(j, j, 0);
  for (int j = begin; j < outer_; ++j) forward(as_constant<B>(band), j, 0);
  for (int i = 0; i < band; ++i) {
    for (int c = 0; c < Columns; ++c) y[Columns * (outer_ + i) + c] = ends(0, 0);
    forward(std::min(outer_ + i, band), outer_ + i, i);
  }
  for (int c = 0; c < Columns; ++c) {
    Scalar* const middle = x + c * stride_x + outer_;
    for (int i = 0; i < band; ++i) {
      const Ends left = y[Columns * (outer_ + i) + c];
      middle[i] += left[0];
      middle[inner_ - 1 - i] += left[1];
    }
    solve_middle(middle);
    for (int i = 0; i < band; ++i) y[Columns * (outer_ + i) + c] = ends(middle[i], middle[inner_ - 1 - i]);
  }
  for (int j = outer_ - 1; j >= 0; --j) {
    Ends sum[Columns];
    for (int c = 0; c < Columns; ++c) sum[c] = y[Columns * j + c] * e[stride * j];
    for (int k = band; k > 0; --k)
      for (int c = 0; c < Columns; ++c) sum[c] -= e[stride * j + k] * y[Columns * (j + k) + c];
    for (int c = 0; c < Columns; ++c) y[Columns * j + c] = sum[c];
  }
  for (int j = 0; j < outer_; ++j)
    for (int c = 0; c < Columns; ++c) {
      x[c * stride_x + j] = y[Columns * j + c][0];
      x[c * stride_x + size_ - 1 - j] = y[Columns * j + c][1];
    }
}

template <class Scalar>
void BandedCholesky<Scalar>::solve(Eigen::Ref<Matrix> columns) const {
  const Eigen::Index stride = columns.outerStride();
  with_band(band_, [&](auto B) {
    Eigen::Index c = 0;
    for (; c + kColumns <= columns.cols(); c += kColumns) solve<B, kColumns>(columns.col(c).data(), stride);
    for (; c < columns.cols(); ++c) solve<B, 1>(columns.col(c).data(), stride);
  });
}

template class BandedCholesky<double>;
template class BandedCholesky<std::complex<double>>;

}  // namespace lithe
