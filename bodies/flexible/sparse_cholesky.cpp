#include "bodies/flexible/sparse_cholesky.h"

#include <Eigen/CholmodSupport>

namespace lithe {
namespace {

/// Eigen hides CHOLMOD's factor; its D is all that Sylvester's law needs.
class SignedFactor : public Eigen::CholmodSimplicialLDLT<SparseMatrix, Eigen::Lower> {
 public:
  explicit SignedFactor(const SparseMatrix& matrix) {
    this->cholmod().print = 0;
    this->compute(matrix);
  }
  int negative_pivots() const {
    const cholmod_factor* L = this->m_cholmodFactor;
    const auto* start = static_cast<const int*>(L->p);
    const auto* x = static_cast<const double*>(L->x);
    // An exactly vanishing pivot stops CHOLMOD at column `minor`; what lies behind it is unknown but not positive.
    int negative = L->minor < L->n ? 1 : 0;
    for (size_t j = 0; j < L->minor; ++j) negative += x[start[j]] < 0;
    return negative;
  }
};

}  // namespace

struct SparseCholesky::Factor {
  Eigen::CholmodSupernodalLLT<SparseMatrix, Eigen::Lower> cholmod;
};

SparseCholesky::SparseCholesky(const SparseMatrix& matrix) : factor_(std::make_unique<Factor>()) {
  factor_->cholmod.cholmod().print = 0;  // an indefinite matrix is our caller's news, not standard output's
  factor_->cholmod.compute(matrix);
  positive_definite_ = factor_->cholmod.info() == Eigen::Success;
}

SparseCholesky::~SparseCholesky() = default;

MatrixX SparseCholesky::solve(const MatrixX& b) const { return factor_->cholmod.solve(b); }

int count_negative_eigenvalues(const SparseMatrix& matrix) { return SignedFactor(matrix).negative_pivots(); }

}  // namespace lithe
