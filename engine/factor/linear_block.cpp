#include "engine/factor/linear_block.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lithe {
namespace {

constexpr double kRoundings = 8;         // a pivot of as many last bits of what it was made from is round-off alone
constexpr double kMostCondition = 1e13;  // of D with rows and columns scaled: a factor of three digits serves Newton

/// y -= A x with A m x n, columns `stride` apart; M: m if the compiler may know it, else 0.
template <int M, class S>
void subtract_product(const S* A, int stride, int m, int n, const S* x, S* y) {
  if constexpr (M > 0) {
    S sum[M];
    for (int a = 0; a < M; ++a) sum[a] = y[a];
    for (int k = 0; k < n; ++k)
      for (int a = 0; a < M; ++a) sum[a] -= A[a + stride * k] * x[k];
    for (int a = 0; a < M; ++a) y[a] = sum[a];
  } else {
    for (int k = 0; k < n; ++k)
      for (int a = 0; a < m; ++a) y[a] -= A[a + stride * k] * x[k];
  }
}
template <class S>
void subtract_product(const S* A, int stride, int m, int n, const S* x, S* y) {
  if (m == 6) return subtract_product<6>(A, stride, m, n, x, y);  // a frame
  if (m == 3) return subtract_product<3>(A, stride, m, n, x, y);  // a pin
  subtract_product<0>(A, stride, m, n, x, y);
}

/// Widens [begin, end) by what of n columns of m values is not zero: by sixteen values at a time, for most are.
template <class S>
void widen(const S* values, int m, int n, int& begin, int& end) {
  constexpr int kBlock = 16;
  const auto is_zero = [&](int from) {
    bool any = false;
    for (int k = 0; k < kBlock; ++k) any |= values[from + k] != S(0);
    return !any;
  };
  int first = 0, last = m * n;
  while (first + kBlock <= last && is_zero(first)) first += kBlock;
  while (first < last && values[first] == S(0)) ++first;
  if (first == last) return;
  while (last - kBlock >= first && is_zero(last - kBlock)) last -= kBlock;
  while (values[last - 1] == S(0)) --last;
  begin = std::min(begin, first / m);
  end = std::max(end, (last - 1) / m + 1);
}

/// s with s_i s_j >= |D_ij|, nearly, and nearly equal in each row (Ruiz 2001): D / s sᵀ has no units.
template <class Scalar>
VectorX symmetric_scale(const Eigen::SparseMatrix<Scalar>& D) {
  VectorX scale = VectorX::Ones(D.cols()), largest(D.cols());
  for (int sweep = 0; sweep < 4; ++sweep) {
    largest.setZero();
    for (int k = 0; k < D.outerSize(); ++k)
      for (typename Eigen::SparseMatrix<Scalar>::InnerIterator entry(D, k); entry; ++entry) {
        const double size = std::abs(entry.value()) / (scale[entry.row()] * scale[entry.col()]);
        for (const auto i : {entry.row(), entry.col()}) largest[i] = std::max(largest[i], size);
      }
    for (int i = 0; i < scale.size(); ++i)
      if (largest[i] > 0) scale[i] *= std::sqrt(largest[i]);
  }
  return scale;
}

/// Whether |D⁻¹| in those scales, seen by one right-hand side of all directions, leaves digits. False for NaN.
template <class Scalar>
bool is_regular(const Eigen::SparseLU<Eigen::SparseMatrix<Scalar>>& factor, const VectorX& scale) {
  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> x = scale;
  for (int i = 0; i < x.size(); ++i)
    if (std::sin(1.7 * i * i) < 0) x[i] = -x[i];  // no mode of a mesh
  x = factor.solve(x).eval();
  return (x.array().abs() * scale.array() < kMostCondition).all();
}

}  // namespace

template <class Scalar>
LinearBlock<Scalar>::LinearBlock(const BlockStructure& structure, int linear)
    : structure_(structure), linear_(structure.linears[linear]) {
  int m = 0;
  for (int f = 0; f < linear_.frames; ++f, m += 6) parts_.push_back({structure.frames[linear_.frame + f].v, 6, m});
  for (std::size_t j = 0; j < structure.jacobians.size(); ++j) {
    const auto& G = structure.jacobians[j];
    if (G.linear != linear) continue;
    const auto& rows = structure.rows[G.rows];
    parts_.push_back({structure.velocity_count + rows.first, rows.count, m});
    rows_.push_back(G.rows);
    jacobians_.push_back(static_cast<int>(j));
    m += rows.count;
  }
  const int n = linear_.size;
  X_.setZero(m, n);
  T_.setZero(n, m);
  schur_.setZero(m, m);
  inverse_diagonal_.setOnes(n);
  if (!linear_.pattern) return;

  const auto& p = *linear_.pattern;
  permuted_.resize(n, std::max(m, 1));
  if (p.rows.size() == n * (n + 1) / 2) {
    full_.setIdentity(n, n);
    full_factor_.compute(full_);
    return;
  }
  sparse_ = std::make_unique<Sparse>();
  std::vector<Eigen::Triplet<Scalar>> entries;
  const auto mirrored = [&](int k) { return !Sparse::kReal && p.rows[k] != p.columns[k]; };
  for (int k = 0; k < p.rows.size(); ++k) {
    entries.emplace_back(p.rows[k], p.columns[k], 1.0);
    if (mirrored(k)) entries.emplace_back(p.columns[k], p.rows[k], 1.0);
  }
  sparse_->matrix.resize(n, n);
  sparse_->matrix.setFromTriplets(entries.begin(), entries.end());
  const auto place = [&](int row, int column) {
    return static_cast<int>(&sparse_->matrix.coeffRef(row, column) - sparse_->matrix.valuePtr());
  };
  for (int k = 0; k < p.rows.size(); ++k) {
    sparse_->place.push_back(place(p.rows[k], p.columns[k]));
    if constexpr (!Sparse::kReal) sparse_->place.push_back(place(p.columns[k], p.rows[k]));
  }
  if (BandedCholesky<Scalar>::suits(n, p))
    sparse_->band.emplace(n, p);
  else
    sparse_->factor.analyzePattern(sparse_->matrix);
}

template <class Scalar>
void LinearBlock<Scalar>::load(const std::vector<Scalar>& values, const std::vector<char>& dropped) {
  using View = Eigen::Map<const Matrix>;
  const int n = linear_.size;
  const bool framed = linear_.frames > 0;
  X_.middleCols(used_, used_count_).setZero();
  int begin = framed ? 0 : n, end = framed ? n : 0;
  if (!framed)
    for (const int j : jacobians_) {
      const auto& G = structure_.jacobians[j];
      widen(values.data() + G.linear_values, structure_.rows[G.rows].count, n, begin, end);
    }
  used_ = std::min(begin, end), used_count_ = end - used_;
  if (framed) {
    for (int f = 0; f < linear_.frames; ++f) {
      X_.template middleRows<6>(6 * f) = View(values.data() + linear_.frame_linear + 6 * n * f, 6, n);
      T_.template middleCols<6>(6 * f) = View(values.data() + linear_.linear_frame + 6 * n * f, n, 6);
    }
  } else if (used_count_ < n) {
    T_.setZero();
  }
  const auto offset = static_cast<std::size_t>(linear_.frames);
  for (std::size_t j = 0; j < jacobians_.size(); ++j) {
    const auto& G = structure_.jacobians[jacobians_[j]];
    const auto& rows = structure_.rows[G.rows];
    const Part& part = parts_[j + offset];
    auto own = X_.block(part.column, used_, rows.count, used_count_);
    own = View(values.data() + G.linear_values + rows.count * used_, rows.count, used_count_);
    for (int r = 0; r < rows.count; ++r)
      if (dropped[rows.first + r]) own.row(r).setZero();
    T_.block(used_, part.column, used_count_, rows.count) = own.transpose();
  }
}

template <class Scalar>
void LinearBlock<Scalar>::factorize(const std::vector<Scalar>& values, const std::vector<char>& dropped) {
  load(values, dropped);
  const int n = linear_.size, m = neighbour_size();
  const Scalar* D = values.data() + linear_.values;
  if (full()) {
    const auto& p = *linear_.pattern;
    for (int k = 0; k < p.rows.size(); ++k) full_(p.rows[k], p.columns[k]) = full_(p.columns[k], p.rows[k]) = D[k];
    factorize_full();
    solve_linear(T_);
  } else if (!sparse_) {
    for (int i = 0; i < n; ++i) inverse_diagonal_[i] = 1.0 / D[i];
    T_ = inverse_diagonal_.asDiagonal() * T_;
  } else {
    const std::size_t count = linear_.pattern->rows.size();
    if (sparse_->last.size() != count || !std::equal(D, D + count, sparse_->last.begin())) {
      sparse_->last.assign(D, D + count);
      factorize_sparse();
    }
    solve_linear(T_);
  }
  // schur = -X T by columns, each a sum of short contiguous vectors.
  schur_.setZero();
  for (int b = 0; b < m; ++b)
    subtract_product(X_.data() + m * used_, m, m, used_count_, T_.data() + n * b + used_, schur_.data() + m * b);
}

/// A pivot U_jj that is no larger than what rounding left of the sum it was made from, Σ |L_jk U_kj|, is no pivot.
template <class Scalar>
void LinearBlock<Scalar>::factorize_full() {
  full_factor_.compute(full_);
  const auto& LU = full_factor_.matrixLU();
  singular_ = false;
  for (int j = 0; j < LU.cols(); ++j) {
    const double pivot = std::abs(LU(j, j));
    double sum = pivot;
    for (int k = 0; k < j; ++k) sum += std::abs(LU(j, k)) * std::abs(LU(k, j));
    if (!(pivot > kRoundings * std::numeric_limits<double>::epsilon() * sum)) singular_ = true;
  }
}

template <class Scalar>
void LinearBlock<Scalar>::factorize_sparse() {
  Sparse& s = *sparse_;
  singular_ = s.is_pivoted = false;
  if (s.band && s.band->factorize(s.last.data())) return;
  constexpr std::size_t kPlaces = Sparse::kReal ? 1 : 2;  // of each entry
  for (std::size_t k = 0; k < s.place.size(); ++k) s.matrix.valuePtr()[s.place[k]] = s.last[k / kPlaces];
  if (!s.band) s.factor.factorize(s.matrix);
  if constexpr (!Sparse::kReal) {
    if (s.band) s.factor.compute(s.matrix), s.is_pivoted = true;
    singular_ = s.factor.info() != Eigen::Success;  // a complex shift keeps the eigenvalues of K off zero
  } else {
    s.is_pivoted = s.band || s.factor.info() != Eigen::Success || !has_sound_pivots();
    if (!s.is_pivoted) return;
    const typename Sparse::Entries both = s.matrix.template selfadjointView<Eigen::Lower>();
    if (!s.pivoted) {
      s.pivoted = std::make_unique<Eigen::SparseLU<typename Sparse::Entries>>();
      s.pivoted->analyzePattern(both);
    }
    s.pivoted->factorize(both);
    singular_ = s.pivoted->info() != Eigen::Success || !is_regular(*s.pivoted, symmetric_scale(both));
  }
}

/// Of Cholesky: L_jj² beside D_jj, from which sums of squares were taken.
template <class Scalar>
bool LinearBlock<Scalar>::has_sound_pivots() const {
  if constexpr (Sparse::kReal) {
    const auto& L = sparse_->factor.matrixL().nestedExpression();
    const auto& P = sparse_->factor.permutationP().indices();
    for (int k = 0; k < sparse_->matrix.outerSize(); ++k) {
      const double pivot = L.valuePtr()[L.outerIndexPtr()[P[k]]];  // the first of its column
      const double diagonal = sparse_->matrix.valuePtr()[sparse_->matrix.outerIndexPtr()[k]];
      if (!(pivot * pivot > kRoundings * std::numeric_limits<double>::epsilon() * diagonal)) return false;
    }
  }
  return true;
}

template <class Scalar>
void LinearBlock<Scalar>::solve_linear(Eigen::Ref<Matrix> columns) const {
  if (columns.cols() == 0) return;  // Eigen's SparseLU takes the address of the first one
  if (singular_) {
    columns.setConstant(std::numeric_limits<double>::quiet_NaN());
    return;
  }
  if (full()) {
    auto y = permuted_.leftCols(columns.cols());
    y.noalias() = full_factor_.permutationP() * columns;
    full_factor_.matrixLU().template triangularView<Eigen::UnitLower>().solveInPlace(y);
    full_factor_.matrixLU().template triangularView<Eigen::Upper>().solveInPlace(y);
    columns = y;
    return;
  }
  if (sparse_->band && !sparse_->is_pivoted) return sparse_->band->solve(columns);
  if constexpr (!Sparse::kReal) {
    columns = sparse_->factor.solve(columns).eval();
    return;
  } else {
    if (sparse_->is_pivoted) {
      columns = sparse_->pivoted->solve(columns).eval();
      return;
    }
    auto y = permuted_.leftCols(columns.cols());
    const auto& P = sparse_->factor.permutationP().indices();
    for (int i = 0; i < columns.rows(); ++i) y.row(P[i]) = columns.row(i);
    sparse_->factor.matrixL().solveInPlace(y);
    sparse_->factor.matrixU().solveInPlace(y);
    for (int i = 0; i < columns.rows(); ++i) columns.row(i) = y.row(P[i]);
  }
}

template <class Scalar>
void LinearBlock<Scalar>::forward(Scalar* x) const {
  Eigen::Map<Vector> own(x + linear_.v, linear_.size);
  if (!sparse_ && !full())
    own.array() *= inverse_diagonal_.array();
  else
    solve_linear(own);
  const int m = neighbour_size();
  for (const Part& part : parts_)
    subtract_product(X_.data() + part.column + m * used_, m, part.size, used_count_, own.data() + used_, x + part.x);
}

template <class Scalar>
void LinearBlock<Scalar>::backward(Scalar* x) const {
  Eigen::Map<Vector> own(x + linear_.v, linear_.size);
  for (const Part& part : parts_)
    for (int a = 0; a < part.size; ++a) own -= x[part.x + a] * T_.col(part.column + a);
}

template class LinearBlock<double>;
template class LinearBlock<std::complex<double>>;

}  // namespace lithe
