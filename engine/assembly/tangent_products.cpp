#include "engine/assembly/evaluator.h"
#include "engine/assembly/tangent_factors.h"
#include "engine/base/error.h"
#include "engine/factor/block_products.h"

namespace lithe {
namespace {

/// Rows and columns of the constraints are each other's transpose already, linear blocks are symmetric.
template <class Scalar>
void transpose_blocks(const BlockStructure& blocks, Scalar* values) {
  using Block = Eigen::Map<Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>>;
  const auto swap_transposed = [&](int upper, int lower, int rows, int columns) {
    Block U(values + upper, rows, columns), L(values + lower, columns, rows);
    for (int i = 0; i < columns; ++i)
      for (int k = 0; k < rows; ++k) std::swap(U(k, i), L(i, k));
  };
  for (const auto& f : blocks.frames) Block(values + f.values, 6, 6).transposeInPlace();
  for (const auto& l : blocks.linears)
    for (int f = 0, at = 0; f < l.frames; ++f, at += 6 * l.size)
      swap_transposed(l.frame_linear + at, l.linear_frame + at, 6, l.size);
  for (const auto& c : blocks.couplings) swap_transposed(c.ab, c.ba, 6, 6);
}

}  // namespace

void TangentFactors::form_tangent(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                                  const VectorX* increment) {
  if (evaluator_.reacts())
    throw SceneError("the tangent of a scene with friction by reactions has no transpose here",
                     "TangentFactors::form_tangent", "leave it out, or take differences of whole runs");
  evaluator_.write_tangent(weights, v_dot, lambda, increment);
}

void TangentFactors::factorize_transposed(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                                          const VectorX* increment) {
  form_tangent(weights, v_dot, lambda, increment);
  factorize_transposed(work_.values);
  if (!contacts_) return;
  contacts_->form(weights, increment);
  contact_correction_->form(
      *contacts_, weights.position, weights.velocity, unknown_count(), [&](double* x) { factor_.solve(x); },
      /*transposed=*/true);
}

void TangentFactors::factorize_transposed(const std::vector<double>& formed) {
  if (&formed != &work_.values) work_.values = formed;
  transpose_blocks(blocks_, work_.values.data());
  if (contact_correction_) contact_correction_->clear();
  factor_.factorize(work_.values);
  if (!factor_.weak_rows().empty()) exchange_weak_rows();
}

void TangentFactors::factorize_complex_transposed(const ComplexTangentWeights& weights, ConstVectorRef v_dot,
                                                  ConstVectorRef lambda) {
  form_complex(weights, v_dot, lambda, nullptr);
  transpose_blocks(blocks_, complex_->values.data());
  complex_->factor.drop_rows(redundant_rows_);
  complex_->factor.factorize(complex_->values);
}

void TangentFactors::add_tangent_product(const std::vector<double>& formed, const VectorX& x, VectorX& out,
                                         bool transposed) const {
  const auto& blocks = blocks_;
  const double* values = formed.data();
  const auto add = [&](int to, int from, const Eigen::Map<const MatrixX>& block) {
    out.segment(to, block.rows()).noalias() += block * x.segment(from, block.cols());
  };
  const auto add_transposed = [&](int to, int from, const Eigen::Map<const MatrixX>& block) {
    out.segment(to, block.cols()).noalias() += block.transpose() * x.segment(from, block.rows());
  };
  /// Block (row, column) and its mirror image (column, row).
  const auto add_pair = [&](int row, int column, int upper, int lower, int rows, int columns) {
    const Eigen::Map<const MatrixX> U(values + upper, rows, columns), L(values + lower, columns, rows);
    if (transposed)
      add_transposed(column, row, U), add_transposed(row, column, L);
    else
      add(row, column, U), add(column, row, L);
  };
  for (const auto& f : blocks.frames) {
    const Eigen::Map<const Matrix6> S(values + f.values);
    if (transposed)
      out.segment<6>(f.v).noalias() += S.transpose() * x.segment<6>(f.v);
    else
      out.segment<6>(f.v).noalias() += S * x.segment<6>(f.v);
  }
  for (const auto& l : blocks.linears) {
    for (int f = 0, at = 0; f < l.frames; ++f, at += 6 * l.size)
      add_pair(blocks.frames[l.frame + f].v, l.v, l.frame_linear + at, l.linear_frame + at, 6, l.size);
    if (!l.pattern) {
      for (int i = 0; i < l.size; ++i) out[l.v + i] += values[l.values + i] * x[l.v + i];
    } else {
      for (int k = 0; k < l.pattern->rows.size(); ++k) {
        const int r = l.pattern->rows[k], c = l.pattern->columns[k];
        out[l.v + r] += values[l.values + k] * x[l.v + c];
        if (r != c) out[l.v + c] += values[l.values + k] * x[l.v + r];
      }
    }
  }
  for (const auto& c : blocks.couplings) add_pair(blocks.frames[c.a].v, blocks.frames[c.b].v, c.ab, c.ba, 6, 6);
  // Compliant rows: Gcᵀ (1/C) Gc, -C on their diagonal.
  if (work_.tension.size() == 0) return;
  const int rows = static_cast<int>(work_.residual.size());
  VectorX tension = VectorX::Zero(work_.tension.size());
  for (const auto& G : blocks.jacobians) {
    const auto& row = blocks.rows[G.rows];
    if (row.first < rows) continue;
    auto to = tension.segment(row.first - rows, row.count);
    if (G.frame >= 0)
      to.noalias() += Eigen::Map<const MatrixX>(values + G.values, row.count, 6) * x.segment<6>(G.velocity);
    if (G.linear >= 0) {
      const auto& L = blocks.linears[G.linear];
      to.noalias() += Eigen::Map<const MatrixX>(values + G.linear_values, row.count, L.size) * x.segment(L.v, L.size);
    }
  }
  for (const auto& row : blocks.rows)
    for (int i = 0; row.compliant >= 0 && i < row.count; ++i)
      tension[row.first - rows + i] /= -values[row.compliant + i];
  add_row_forces(blocks, formed, rows, nullptr, tension.data(), out.data());
}

}  // namespace lithe
