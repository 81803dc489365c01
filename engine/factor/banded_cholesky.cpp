#include "engine/factor/banded_cholesky.h"

#include <algorithm>
#include <complex>
#include <limits>
#include <type_traits>

namespace lithe {
namespace {

constexpr int kWidest = 24;       // a sparse factor with its own order does better beyond
constexpr double kWaste = 4;      // values of the band over entries, at most
constexpr double kRoundings = 8;  // a pivot of as many last bits of what it was made from is round-off alone

// Dot products of what lies in one row, the latest entry last: nothing waits for more than one product. B: subdiagonals
// if the compiler may know them, else 0. D and L of entry (row - k, row - i) lie k - i - i * stride behind the row's
// diagonal.

/// Row j of L, and 1 / d_j in place of D_jj; false without a sound pivot.
template <int B, class S>
bool eliminate(S* row, int stride, int left, double least) {
  const int n = B > 0 ? B : left;
  S w[B > 0 ? B + 1 : kWidest + 1];  // L_jk d_k, k to the left
  S pivot = row[0];
  for (int k = n; k > 0; --k) {
    S* of_k = row - k * stride;
    S sum = of_k[k];
    for (int i = n; i > k; --i) sum -= w[i] * row[i - k - i * stride];
    w[k] = sum;
    of_k[k] = sum * of_k[0];
    pivot -= sum * of_k[k];
  }
  row[0] = 1.0 / pivot;
  if constexpr (std::is_same_v<S, double>) return pivot > least;
  return std::abs(pivot) > least;
}

template <int B, class S>
void forward(const S* L, int stride, int above, S* x) {
  const int n = B > 0 ? B : above;
  S sum = x[0];
  for (int k = n; k > 0; --k) sum -= L[k - k * stride] * x[-k];
  x[0] = sum;
}

template <int B, class S>
void backward(const S* L, int below, S* x) {
  const int n = B > 0 ? B : below;
  S sum = L[0] * x[0];
  for (int k = n; k > 0; --k) sum -= L[k] * x[k];
  x[0] = sum;
}

/// Calls step(B) with the band as a constant: 5 and 8 are those of a cable without and with bending stiffness.
template <class Step>
void with_band(int band, const Step& step) {
  if (band == 8) return step(std::integral_constant<int, 8>());
  if (band == 5) return step(std::integral_constant<int, 5>());
  step(std::integral_constant<int, 0>());
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
      place_(pattern.columns * (band_ + 1) + (pattern.rows - pattern.columns)),
      values_(Matrix::Zero(band_ + 1, size)) {}

template <class Scalar>
bool BandedCholesky<Scalar>::factorize(const Scalar* entries) {
  values_.setZero();
  for (Eigen::Index k = 0; k < place_.size(); ++k) values_.data()[place_[k]] = entries[k];
  diagonal_ = values_.row(0).cwiseAbs();
  const int stride = band_ + 1, outer = std::min(band_, size_);
  bool sound = true;
  const auto row = [&](auto B, int j) {
    const double least = kRoundings * std::numeric_limits<double>::epsilon() * diagonal_[j];
    sound = eliminate<B>(values_.data() + stride * j, stride, std::min(j, band_), least);
  };
  for (int j = 0; j < outer && sound; ++j) row(std::integral_constant<int, 0>(), j);
  with_band(band_, [&](auto B) {
    for (int j = outer; j < size_ && sound; ++j) row(B, j);
  });
  return sound;
}

template <class Scalar>
void BandedCholesky<Scalar>::solve(Eigen::Ref<Matrix> columns) const {
  const int stride = band_ + 1, outer = std::min(band_, size_), inner = size_ - outer;
  constexpr std::integral_constant<int, 0> any;
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    Scalar* x = columns.col(c).data();
    const Scalar* L = values_.data();
    for (int j = 0; j < outer; ++j) forward<any>(L + stride * j, stride, j, x + j);
    with_band(band_, [&](auto B) {
      for (int j = outer; j < size_; ++j) forward<B>(L + stride * j, stride, band_, x + j);
    });
    for (int j = size_ - 1; j >= inner; --j) backward<any>(L + stride * j, size_ - 1 - j, x + j);
    with_band(band_, [&](auto B) {
      for (int j = inner - 1; j >= 0; --j) backward<B>(L + stride * j, band_, x + j);
    });
  }
}

template class BandedCholesky<double>;
template class BandedCholesky<std::complex<double>>;

}  // namespace lithe
