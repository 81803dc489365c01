#include "engine/static_equations.h"

#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <algorithm>
#include <limits>

#include "engine/error.h"

namespace lithe {
namespace {

constexpr double kRoundings = 4;  // of each term of a force, in units of its last bit

}  // namespace

/// KLU, as SUNDIALS wraps it.
class StaticEquations::Factor {
 public:
  explicit Factor(int size) {
    SUNContext_Create(nullptr, &context_);
    x_ = N_VNew_Serial(size, context_);
    b_ = N_VNew_Serial(size, context_);
    matrix_ = SUNSparseMatrix(size, size, 10 * size + 1, CSC_MAT, context_);
    if (x_ && matrix_) solver_ = SUNLinSol_KLU(x_, matrix_, context_);
    if (!b_ || !solver_) throw SimulationError("SUNDIALS cannot be set up", "find_equilibrium", "is the memory enough?");
  }
  Factor(const Factor&) = delete;
  ~Factor() {
    if (solver_) SUNLinSolFree(solver_);
    if (matrix_) SUNMatDestroy(matrix_);
    for (N_Vector x : {x_, b_})
      if (x) N_VDestroy(x);
    if (context_) SUNContext_Free(&context_);
  }

  bool factorize(const Eigen::SparseMatrix<double>& A) {
    const auto entries = A.nonZeros();
    if (SUNSparseMatrix_NNZ(matrix_) < entries) SUNSparseMatrix_Reallocate(matrix_, entries);
    std::copy_n(A.outerIndexPtr(), A.cols() + 1, SUNSparseMatrix_IndexPointers(matrix_));
    std::copy_n(A.innerIndexPtr(), entries, SUNSparseMatrix_IndexValues(matrix_));
    std::copy_n(A.valuePtr(), entries, SUNSparseMatrix_Data(matrix_));
    SUNLinSol_KLUReInit(solver_, matrix_, entries, SUNKLU_REINIT_PARTIAL);  // the pattern may have changed
    return SUNLinSolSetup(solver_, matrix_) == 0;
  }
  bool solve(VectorX& d, VectorX& l) {
    map(b_) << d, l;
    if (SUNLinSolSolve(solver_, matrix_, x_, b_, 0) != 0 || !map(x_).allFinite()) return false;
    d = map(x_).head(d.size());
    l = map(x_).tail(l.size());
    return true;
  }

 private:
  static Eigen::Map<VectorX> map(N_Vector x) { return {N_VGetArrayPointer(x), N_VGetLength(x)}; }
  SUNContext context_ = nullptr;
  N_Vector x_ = nullptr, b_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver solver_ = nullptr;
};

StaticEquations::StaticEquations(Assembler& equations)
    : equations_(equations),
      velocities_(equations.layout().v_count()),
      rows_(equations.layout().row_count()),
      redundant_(rows_, 0),
      factor_(std::make_unique<Factor>(velocities_ + rows_)) {
  for (int row : equations.redundant_rows()) redundant_[row] = 1;
  for (VectorX* x : {&force, &still_, &round_off_, &magnitudes_}) x->setZero(velocities_);
  gap.setZero(rows_);
}
StaticEquations::~StaticEquations() = default;

void StaticEquations::leave_out_redundant(VectorX& x) const {
  for (int i = 0; i < rows_; ++i)
    if (redundant_[i]) x[i] = 0;
}

void StaticEquations::evaluate(double time, ConstVectorRef q, ConstVectorRef lambda) {
  q_ = q;
  equations_.evaluate(time, q, still_, Level::velocity);
  equations_.residual(still_, lambda, force);
  equations_.constraint(Level::position, gap);
  leave_out_redundant(gap);
}

VectorX StaticEquations::mass_times(ConstVectorRef d, ConstVectorRef lambda) const {
  VectorX product(velocities_);
  equations_.residual(d, lambda, product);
  return product - force;
}

bool StaticEquations::factorize(double shift, ConstVectorRef lambda) {
  equations_.factorize({1, 0, shift}, still_, lambda, nullptr);
  collect();
  const int size = velocities_ + rows_;
  sparse_.resize(size, size);
  sparse_.setFromTriplets(entries_.begin(), entries_.end());
  sparse_.makeCompressed();
  if (!Eigen::Map<const VectorX>(sparse_.valuePtr(), sparse_.nonZeros()).allFinite()) return false;
  find_round_off(q_, lambda);
  return factor_->factorize(sparse_);
}

bool StaticEquations::solve(VectorX& d, VectorX& l) const { return factor_->solve(d, l); }

/// |K| |q| + |Gᵀ| |λ| in units of the last bit: a stiff row is a small difference of large forces, and no search makes
/// it smaller than that.
void StaticEquations::find_round_off(ConstVectorRef q, ConstVectorRef lambda) {
  equations_.layout().magnitudes(q, magnitudes_);
  round_off_.setZero();
  for (int column = 0; column < sparse_.outerSize(); ++column) {
    const double size = column < velocities_ ? magnitudes_[column] : std::abs(lambda[column - velocities_]);
    for (Eigen::SparseMatrix<double>::InnerIterator entry(sparse_, column); entry; ++entry)
      if (entry.row() < velocities_) round_off_[entry.row()] += std::abs(entry.value()) * size;
  }
  round_off_ *= kRoundings * std::numeric_limits<double>::epsilon();
}

/// Compliant rows, which have no unknown here, are eliminated: Gᵀ κ G.
void StaticEquations::collect() {
  const int constraints_end = velocities_ + rows_;
  struct CompliantRow {
    double compliance = 0;
    std::vector<std::pair<int, double>> across, down;  // columns of G, rows of Gᵀ
  };
  std::vector<CompliantRow> compliant;
  entries_.clear();
  const auto is_left_out = [&](int i) { return i >= velocities_ && redundant_[i - velocities_]; };

  equations_.visit_blocks([&](int row, int column, ConstMatrixRef values) {
    for (int k = 0; k < values.cols(); ++k)
      for (int i = 0; i < values.rows(); ++i) {
        const int r = row + i, c = column + k;
        if (r >= constraints_end || c >= constraints_end) {
          const auto place = static_cast<std::size_t>(std::max(r, c) - constraints_end);
          if (place >= compliant.size()) compliant.resize(place + 1);
          if (r >= constraints_end && c >= constraints_end) {
            compliant[place].compliance = -values(i, k);
          } else if (values(i, k) != 0 && !is_left_out(std::min(r, c))) {
            (r >= constraints_end ? compliant[place].across : compliant[place].down)
                .emplace_back(std::min(r, c), values(i, k));
          }
        } else if (!is_left_out(r) && !is_left_out(c) && (values(i, k) != 0 || r == c)) {
          entries_.emplace_back(r, c, values(i, k));
        }
      }
  });
  for (const CompliantRow& row : compliant)
    for (const auto& [r, down] : row.down)
      for (const auto& [c, across] : row.across) entries_.emplace_back(r, c, down * across / row.compliance);
  for (int i = 0; i < rows_; ++i)
    if (redundant_[i]) entries_.emplace_back(velocities_ + i, velocities_ + i, 1.0);
}

}  // namespace lithe
