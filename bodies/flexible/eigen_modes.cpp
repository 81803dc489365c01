#include "bodies/flexible/eigen_modes.h"

#include <Spectra/SymGEigsShiftSolver.h>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "bodies/flexible/elastic_problem.h"
#include "engine/base/dense_inverse.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr int kDenseBelow = 120;      // degrees of freedom
constexpr double kTolerance = 1e-10;  // of a Ritz pair; one inverse iteration follows

/// Spectra's operator: x → κ P (K + s M)⁻¹ Pᵀ x, P the projection off the rigid motions and what was found before. With
/// B = M it is self-adjoint in the M-product. κ = tr K / tr M makes it a number of order one and more: Spectra takes an
/// eigenvalue below 4e-11 (without κ: 26 kHz) for converged too early.
class DeflatedInverse {
 public:
  using Scalar = double;
  DeflatedInverse(const ElasticProblem& problem, const Deflation& found)
      : problem_(problem),
        found_(found),
        scale_(problem.stiffness().diagonal().sum() / problem.mass().diagonal().sum()) {}
  Eigen::Index rows() const { return problem_.mass().rows(); }
  Eigen::Index cols() const { return rows(); }
  void set_shift(const double&) {}  // the factor has it already
  void perform_op(const double* in, double* out) const {
    MatrixX b = Eigen::Map<const VectorX>(in, rows());
    // Pᵀ b keeps the huge 1/s of a free motion out of the solution, P removes what rounding left.
    found_.relieve(b);
    MatrixX x = problem_.solve(b);
    found_.clean(x);
    Eigen::Map<VectorX>(out, rows()) = scale_ * x.col(0);
  }

 private:
  const ElasticProblem& problem_;
  const Deflation& found_;
  double scale_;
};

class MassProduct {
 public:
  using Scalar = double;
  explicit MassProduct(const SparseMatrix& M) : M_(M) {}
  Eigen::Index rows() const { return M_.rows(); }
  Eigen::Index cols() const { return M_.cols(); }
  void perform_op(const double* in, double* out) const {
    Eigen::Map<VectorX>(out, M_.rows()) = M_ * Eigen::Map<const VectorX>(in, M_.cols());
  }

 private:
  const SparseMatrix& M_;
};

/// Ritz vectors of the `count` lowest pairs outside what was `found`, as far as they converged.
MatrixX lanczos(const ElasticProblem& problem, const Deflation& found, int count, double tolerance) {
  DeflatedInverse inverse(problem, found);
  MassProduct product(problem.mass());
  const int room = problem.elastic_count() - static_cast<int>(found.D.cols());
  const int subspace = std::min(std::max(2 * count + 1, 20), room);
  Spectra::SymGEigsShiftSolver<DeflatedInverse, MassProduct, Spectra::GEigsMode::ShiftInvert> solver(
      inverse, product, count, subspace, -problem.shift());
  solver.init();
  solver.compute(Spectra::SortRule::LargestMagn, 1000, tolerance);
  return solver.eigenvectors();
}

/// Rayleigh-Ritz in span X: rotates X to the eigenvectors of Xᵀ K X and returns their Rayleigh quotients, ascending.
VectorX rotate_to_ritz_vectors(const SparseMatrix& K, const SparseMatrix& M, MatrixX& X) {
  orthonormalise(M, X);
  const MatrixX projected = X.transpose() * (K * X);
  const Eigen::SelfAdjointEigenSolver<MatrixX> ritz(MatrixX(0.5 * (projected + projected.transpose())));
  X = (X * ritz.eigenvectors()).eval();
  orthonormalise(M, X);
  const MatrixX KX = K * X;
  return X.cwiseProduct(KX).colwise().sum().transpose();
}

MatrixX lanczos_modes(const ElasticProblem& problem, int count) {
  const SparseMatrix &K = problem.stiffness(), &M = problem.mass();
  MatrixX X = lanczos(problem, {}, count, kTolerance);
  if (X.cols() < count)
    throw SceneError("only " + std::to_string(X.cols()) + " of " + std::to_string(count) + " eigenmodes converged.",
                     problem.where(),
                     "ask for fewer modes, or look for badly shaped elements and stiffness ratios over 1e10.");
  VectorX eigenvalues = rotate_to_ritz_vectors(K, M, X);

  // A single start vector may see a multiple eigenvalue once only: look in the complement for one that was left behind.
  for (int missed = 0; missed < count; ++missed) {
    if (problem.elastic_count() - X.cols() < 2) break;
    MatrixX next = lanczos(problem, deflate(M, X), 1, 1e-6);
    if (next.cols() == 0) break;
    const double lambda = rotate_to_ritz_vectors(K, M, next)[0];
    if (lambda >= eigenvalues[count - 1] * (1 - 1e-6)) break;
    X = beside(X, next);
    eigenvalues = rotate_to_ritz_vectors(K, M, X);
    X = X.leftCols(count).eval();
    eigenvalues = eigenvalues.head(count).eval();
  }
  return X;
}

MatrixX dense_modes(const ElasticProblem& problem, int count) {
  const SparseMatrix &K = problem.stiffness(), &M = problem.mass();
  const MatrixX held = problem.conditions();
  if (held.cols() == 0) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> all{MatrixX(K), MatrixX(M)};
    return all.eigenvectors().leftCols(count);
  }
  // In the complement: columns Z that meet the conditions, from a full QR of these.
  const Eigen::HouseholderQR<MatrixX> qr(held);
  const MatrixX Q = written_out(qr.householderQ());
  const MatrixX Z = Q.rightCols(M.rows() - held.cols());
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> all{MatrixX(Z.transpose() * (K * Z)),
                                                              MatrixX(Z.transpose() * (M * Z))};
  return Z * all.eigenvectors().leftCols(count);
}

/// Largest component positive; among equals (a symmetric body's mode) the first one decides.
void fix_signs(MatrixX& X) {
  for (Eigen::Index k = 0; k < X.cols(); ++k) {
    const double bound = (1 - 1e-6) * X.col(k).cwiseAbs().maxCoeff();
    Eigen::Index i = 0;
    while (std::abs(X(i, k)) < bound) ++i;
    if (X(i, k) < 0) X.col(k) = -X.col(k);
  }
}

}  // namespace

double eigenvalue_noise(const SparseMatrix& K, const SparseMatrix& M) {
  return 1e-12 * K.diagonal().sum() / M.diagonal().sum();
}

EigenModes ritz_modes(const SparseMatrix& K, const SparseMatrix& M, MatrixX X) {
  EigenModes modes;
  modes.eigenvalues = rotate_to_ritz_vectors(K, M, X);
  fix_signs(X);
  modes.vectors = std::move(X);
  return modes;
}

EigenModes lowest_modes(const ElasticProblem& problem, int count, EigenMethod method) {
  const SparseMatrix &K = problem.stiffness(), &M = problem.mass();
  const auto n = static_cast<int>(K.rows());
  if (count <= 0) return {VectorX(0), MatrixX(n, 0)};
  const bool most = 3 * count > n;
  if (method == EigenMethod::automatic) method = n <= kDenseBelow || most ? EigenMethod::dense : EigenMethod::lanczos;

  MatrixX X = method == EigenMethod::dense ? dense_modes(problem, count) : lanczos_modes(problem, count);
  // One inverse iteration sharpens the low modes; it is of no use to a whole spectrum.
  if (!most) X = problem.solve(M * X);
  EigenModes modes;
  modes.eigenvalues = rotate_to_ritz_vectors(K, M, X);
  problem.clean(X);
  orthonormalise(M, X);
  fix_signs(X);
  modes.vectors = std::move(X);
  return modes;
}

EigenModes lowest_modes(const SparseMatrix& K, const SparseMatrix& M, const MatrixX& rigid, int count,
                        const std::string& where, EigenMethod method) {
  return lowest_modes(ElasticProblem(K, M, rigid, where), count, method);
}

}  // namespace lithe
