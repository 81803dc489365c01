#include "engine/assembly/least_norm.h"

#include <algorithm>
#include <limits>

#include "engine/assembly/evaluator.h"
#include "engine/factor/block_products.h"

namespace lithe {
namespace {

constexpr double kCompliance = 1e-7;  // δ, beside rows of length 1 in metres and radians
constexpr double kNoRow = -1e30;      // diagonal of a row that takes no part

}  // namespace

/// Every row gets a diagonal of its own; what couples bodies or rows otherwise has no place here.
BlockStructure LeastNorm::with_compliance(const BlockStructure& structure) {
  BlockStructure with = structure;
  for (auto& row : with.rows)
    if (row.compliant < 0) row.compliant = with.reserve(row.count);
  with.couplings.clear();
  with.row_couplings.clear();
  return with;
}

LeastNorm::LeastNorm(const BlockStructure& structure)
    : structure_(with_compliance(structure)),
      factor_(structure_),
      values_(structure_.value_count, 0.0),
      x_(VectorX::Zero(structure_.velocity_count + structure_.row_count)) {
  // Unit blocks for the bodies, δ for the constraints; force rows take no part.
  for (const auto& frame : structure_.frames)
    for (int i = 0; i < 6; ++i) values_[frame.values + 7 * i] = 1;
  for (const auto& linear : structure_.linears) {
    const int count = linear.pattern ? static_cast<int>(linear.pattern->rows.size()) : linear.size;
    for (int k = 0; k < count; ++k)
      values_[linear.values + k] = !linear.pattern || linear.pattern->rows[k] == linear.pattern->columns[k] ? 1 : 0;
  }
  for (std::size_t r = 0; r < structure_.rows.size(); ++r)
    std::fill_n(values_.begin() + structure_.rows[r].compliant, structure_.rows[r].count,
                structure.rows[r].compliant < 0 ? -kCompliance : kNoRow);
}

void LeastNorm::load(const std::vector<double>& values) {
  for (const auto& G : structure_.jacobians) {
    const int rows = structure_.rows[G.rows].count;
    if (G.frame >= 0) std::copy_n(values.begin() + G.values, 6 * rows, values_.begin() + G.values);
    if (G.linear >= 0)
      std::copy_n(values.begin() + G.linear_values, rows * structure_.linears[G.linear].size,
                  values_.begin() + G.linear_values);
  }
  factor_.factorize(values_);
  loaded_ = true;
}

const VectorX& LeastNorm::of(const std::vector<double>& values, ConstVectorRef lambda) {
  if (known_ && asked_ == lambda) return copy_;
  asked_ = copy_ = lambda;
  if (!loaded_) load(values);
  filter(copy_);
  known_ = true;
  return copy_;
}

void LeastNorm::apply(const std::vector<double>& values, VectorRef lambda) {
  load(values);
  filter(lambda);
}

void LeastNorm::filter(VectorRef lambda) {
  constexpr int kFilters = 2, kMaxSteps = 30;
  const int velocities = structure_.velocity_count, rows = static_cast<int>(lambda.size());
  force_.setZero(velocities);
  add_row_forces(structure_, values_, rows, lambda.data(), nullptr, force_.data());
  // 1. Take the part away that makes no force; what is left of it after one pass is round-off over δ.
  for (int k = 0; k < kFilters; ++k) {
    x_.setZero();
    x_.segment(velocities, lambda.size()) = -lambda;
    factor_.solve(x_.data());
    lambda -= kCompliance * x_.segment(velocities, lambda.size());
  }
  // 2. Give back what that took of the force, to round-off.
  double last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kMaxSteps; ++k) {
    x_.setZero();
    auto missing = x_.head(velocities);
    const VectorX opposite = -lambda;
    add_row_forces(structure_, values_, rows, opposite.data(), nullptr, missing.data());
    missing += force_;
    const double size = missing.norm();
    if (!(size < 0.5 * last)) return;
    last = size;
    factor_.solve(x_.data());
    lambda += x_.segment(velocities, lambda.size());
  }
}

void minimize_norm(const Evaluator& evaluator, VectorRef lambda) {
  if (!evaluator.redundant_rows().empty())
    LeastNorm(evaluator.system().blocks()).apply(evaluator.workspace().values, lambda);
}

}  // namespace lithe
