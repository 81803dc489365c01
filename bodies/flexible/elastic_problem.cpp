#include "bodies/flexible/elastic_problem.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <limits>

#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr double kShift = 1e-10;  // of tr K / tr M: makes a free body's K positive definite, deflation does the rest

}  // namespace

void orthonormalise(const SparseMatrix& M, MatrixX& X) {
  for (int pass = 0; pass < 2 && X.cols() > 0; ++pass) {
    const MatrixX gram = X.transpose() * (M * X);
    const Eigen::LLT<MatrixX> factor(gram);
    factor.matrixU().solveInPlace<Eigen::OnTheRight>(X);
  }
}

Deflation deflate(const SparseMatrix& M, MatrixX X) {
  orthonormalise(M, X);
  Deflation found;
  found.L = M * X;
  found.D = std::move(X);
  return found;
}

SparseMatrix diagonal_matrix(const VectorX& diagonal) {
  // No reserve(): of no columns it would leave the compressed form, and makeCompressed() would write behind its end.
  SparseMatrix D(diagonal.size(), diagonal.size());
  for (Eigen::Index k = 0; k < diagonal.size(); ++k) D.insert(k, k) = diagonal[k];
  D.makeCompressed();
  return D;
}

MatrixX beside(const MatrixX& left, const MatrixX& right) {
  MatrixX both(left.rows(), left.cols() + right.cols());
  both << left, right;
  return both;
}

ElasticProblem::ElasticProblem(const SparseMatrix& K, const SparseMatrix& M, const MatrixX& rigid, std::string where)
    : K_(K),
      M_(M),
      where_(std::move(where)),
      rigid_(deflate(M, rigid)),
      shift_(kShift * K.diagonal().sum() / M.diagonal().sum()),
      factor_(K + shift_ * M) {
  if (factor_.positive_definite()) return;
  throw SceneError("the supported stiffness is not positive definite.", where_,
                   "hold the body against every rigid motion and check K with require_sound().");
}

MatrixX ElasticProblem::solve(MatrixX b) const {
  const MatrixX pull = held_.cols() > 0 ? MatrixX(small_ * (columns_.transpose() * b)) : MatrixX();
  rigid_.relieve(b);
  MatrixX x = factor_.solve(b);
  rigid_.clean(x);
  if (held_.cols() == 0) return x;
  x -= columns_ * pull;
  clean(x);
  return x;
}

void ElasticProblem::clean(Eigen::Ref<MatrixX> x) const {
  if (held_.cols() == 0)
    rigid_.clean(x);
  else
    x -= constraint_modes_ * (held_.transpose() * x);
}

void ElasticProblem::hold(MatrixX F) {
  // x = G (b - F λ) + D c with Fᵀ x = 0, where G is the inverse off the rigid motions D and shift c = Dᵀ (b - F λ):
  //   [Fᵀ G F, Fᵀ D; Dᵀ F, -shift E] (λ, -c) = (Fᵀ G b, Dᵀ b)
  held_.resize(0, 0);
  MatrixX Y0 = static_deflections(F), Y = solve(F);
  // Loads of unit compliance, D of order one: what is singular then is so for a reason.
  const VectorX compliance = F.cwiseProduct(Y0).colwise().sum().transpose();
  const VectorX scale = compliance.cwiseMax(1e-20 * compliance.maxCoeff()).cwiseSqrt().cwiseInverse();
  for (MatrixX* columns : {&F, &Y0, &Y}) *columns *= scale.asDiagonal();
  const Eigen::Index count = F.cols(), rigid = rigid_.D.cols();
  const MatrixX FtD = F.transpose() * rigid_.D;
  const double unit = rigid > 0 ? 1 / FtD.cwiseAbs().maxCoeff() : 1;
  const auto system = [&](const MatrixX& deflections, double shift) {
    MatrixX S(count + rigid, count + rigid);
    S << F.transpose() * deflections, unit * FtD, unit * FtD.transpose(),
        -shift * unit * unit * MatrixX::Identity(rigid, rigid);
    return S;
  };
  Eigen::FullPivLU<MatrixX> at_rest(system(Y0, 0));
  at_rest.setThreshold(1e-12);
  if (!at_rest.isInvertible())
    throw SceneError("the fixed interfaces leave the body free to move, or two of them hold the same.", where_,
                     "name interfaces that share no nodes, and one more or one with nodes off the line.");
  constraint_modes_ = beside(Y0, unit * rigid_.D) * at_rest.inverse().leftCols(count);
  columns_ = beside(Y, unit * rigid_.D);
  small_ = system(Y, shift_).inverse();
  held_ = std::move(F);
}

MatrixX ElasticProblem::static_deflections(const MatrixX& loads) const {
  constexpr int kRounds = 60;
  MatrixX F = loads;
  rigid_.relieve(F);
  // Each round takes the shift's error, shift / (λ + shift), once more off every mode; at round-off the corrections
  // stop shrinking. Their size is their strain energy, dᵀ K d ≈ dᵀ (residual).
  MatrixX X = MatrixX::Zero(F.rows(), F.cols());
  double last = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kRounds; ++round) {
    MatrixX residual = F;
    if (round > 0) residual -= K_ * X;
    rigid_.relieve(residual);
    MatrixX step = factor_.solve(residual);
    rigid_.clean(step);
    const VectorX work = F.cwiseProduct(X + step).colwise().sum().transpose().cwiseAbs();
    const VectorX change = residual.cwiseProduct(step).colwise().sum().transpose().cwiseAbs();
    const double size = (change.array() / work.array().max(1e-20 * work.maxCoeff()).max(1e-300)).maxCoeff();
    if (!(size < 0.9 * last)) break;
    X += step;
    if (round > 0 && size * size < 1e-32 * last) break;  // the next correction is below round-off
    last = size;
  }
  return X;
}

/// Psi holds all rigid motions, and Fᵀ Psi = E: the load with its reactions is f - F Psiᵀ f.
MatrixX ElasticProblem::deflections(const MatrixX& loads) const {
  if (held_.cols() == 0) return static_deflections(loads);
  MatrixX X = static_deflections(loads - held_ * (constraint_modes_.transpose() * loads));
  clean(X);
  return X;
}

}  // namespace lithe
