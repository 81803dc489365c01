#include "bodies/flexible/eigen_modes.h"

#include <Spectra/SymGEigsShiftSolver.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>

#include "bodies/flexible/sparse_cholesky.h"
#include "engine/error.h"

namespace lithe {
namespace {

constexpr double kShift = 1e-10;  // of tr K / tr M: makes a free body's K positive definite, deflation does the rest
constexpr int kDenseBelow = 120;  // degrees of freedom
constexpr double kTolerance = 1e-11;  // of a Ritz pair; one inverse iteration follows

/// What is projected out of the search: D with Dᵀ M D = E, and M D.
struct Deflation {
  MatrixX D, MD;
  /// x ← (E - D Dᵀ M) x
  void clean(Eigen::Ref<MatrixX> x) const {
    if (D.cols() > 0) x -= D * (MD.transpose() * x);
  }
};

/// X ← X L⁻ᵀ with Xᵀ M X = L Lᵀ, twice: M-orthonormal to round-off.
void orthonormalise(const SparseMatrix& M, MatrixX& X) {
  for (int pass = 0; pass < 2 && X.cols() > 0; ++pass) {
    const MatrixX gram = X.transpose() * (M * X);
    const Eigen::LLT<MatrixX> factor(gram);
    X = factor.matrixL().solve(X.transpose()).transpose().eval();
  }
}

Deflation deflate(const SparseMatrix& M, MatrixX X) {
  orthonormalise(M, X);
  Deflation found;
  found.MD = M * X;
  found.D = std::move(X);
  return found;
}

/// Spectra's operator: x → P (K + s M)⁻¹ x, P the projection off D. With B = M it is self-adjoint in the M-product.
class DeflatedInverse {
 public:
  using Scalar = double;
  DeflatedInverse(const SparseCholesky& factor, const Deflation& deflation, Eigen::Index n)
      : factor_(factor), deflation_(deflation), n_(n) {}
  Eigen::Index rows() const { return n_; }
  Eigen::Index cols() const { return n_; }
  void set_shift(const double&) {}  // the factor has it already
  void perform_op(const double* in, double* out) const {
    MatrixX b = Eigen::Map<const VectorX>(in, n_);
    // Pᵀ b keeps the huge 1/s of a free motion out of the solution, P removes what rounding left.
    if (deflation_.D.cols() > 0) b -= deflation_.MD * (deflation_.D.transpose() * b);
    MatrixX x = factor_.solve(b);
    deflation_.clean(x);
    Eigen::Map<VectorX>(out, n_) = x.col(0);
  }

 private:
  const SparseCholesky& factor_;
  const Deflation& deflation_;
  Eigen::Index n_;
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

/// Ritz vectors of the `count` lowest pairs outside the deflated space, as far as they converged.
MatrixX lanczos(const SparseMatrix& M, const SparseCholesky& factor, const Deflation& deflation, double shift,
                int count, double tolerance) {
  DeflatedInverse inverse(factor, deflation, M.rows());
  MassProduct product(M);
  const auto room = static_cast<int>(M.rows() - deflation.D.cols());
  const int subspace = std::min(std::max(2 * count + 1, 20), room);
  Spectra::SymGEigsShiftSolver<DeflatedInverse, MassProduct, Spectra::GEigsMode::ShiftInvert> solver(
      inverse, product, count, subspace, -shift);
  solver.init();
  solver.compute(Spectra::SortRule::LargestMagn, 1000, tolerance);
  return solver.eigenvectors();
}

/// Rayleigh-Ritz in span X: rotates X to the eigenvectors of Xᵀ K X and returns their Rayleigh quotients, ascending.
VectorX rotate_to_ritz_vectors(const SparseMatrix& K, const SparseMatrix& M, MatrixX& X) {
  orthonormalise(M, X);
  const MatrixX projected = X.transpose() * (K * X);
  const Eigen::SelfAdjointEigenSolver<MatrixX> ritz(0.5 * (projected + projected.transpose()));
  X = (X * ritz.eigenvectors()).eval();
  orthonormalise(M, X);
  const MatrixX KX = K * X;
  return X.cwiseProduct(KX).colwise().sum().transpose();
}

MatrixX beside(const MatrixX& left, const MatrixX& right) {
  MatrixX both(left.rows(), left.cols() + right.cols());
  both << left, right;
  return both;
}

MatrixX lanczos_modes(const SparseMatrix& K, const SparseMatrix& M, const Deflation& rigid, int count, double shift,
                      const SparseCholesky& factor, const std::string& where) {
  MatrixX X = lanczos(M, factor, rigid, shift, count, kTolerance);
  if (X.cols() < count)
    throw SceneError("only " + std::to_string(X.cols()) + " of " + std::to_string(count) + " eigenmodes converged.",
                     where, "ask for fewer modes, or look for badly shaped elements and stiffness ratios over 1e10.");
  VectorX eigenvalues = rotate_to_ritz_vectors(K, M, X);

  // A single start vector may see a multiple eigenvalue once only: look in the complement for one that was left behind.
  for (int missed = 0; missed < count; ++missed) {
    const auto room = static_cast<int>(M.rows() - rigid.D.cols() - X.cols());
    if (room < 2) break;
    const Deflation found = deflate(M, beside(rigid.D, X));
    MatrixX next = lanczos(M, factor, found, shift, 1, 1e-6);
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

MatrixX dense_modes(const SparseMatrix& K, const SparseMatrix& M, const Deflation& rigid, int count) {
  if (rigid.D.cols() == 0) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> all{MatrixX(K), MatrixX(M)};
    return all.eigenvectors().leftCols(count);
  }
  // In the complement of the rigid motions: columns Z with Dᵀ M Z = 0, from a full QR of M D.
  const Eigen::HouseholderQR<MatrixX> qr(rigid.MD);
  const MatrixX Q = qr.householderQ();
  const MatrixX Z = Q.rightCols(M.rows() - rigid.D.cols());
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

/// K + shift M, positive definite though K may leave rigid motions free.
SparseMatrix shifted_stiffness(const SparseMatrix& K, const SparseMatrix& M, double& shift) {
  shift = kShift * K.diagonal().sum() / M.diagonal().sum();
  return K + shift * M;
}

void require_positive(const SparseCholesky& factor, const std::string& where) {
  if (factor.positive_definite()) return;
  throw SceneError("the supported stiffness is not positive definite.", where,
                   "hold the body against every rigid motion and check K with require_sound().");
}

}  // namespace

double eigenvalue_noise(const SparseMatrix& K, const SparseMatrix& M) {
  return 1e-12 * K.diagonal().sum() / M.diagonal().sum();
}

EigenModes lowest_modes(const SparseMatrix& K, const SparseMatrix& M, const MatrixX& rigid, int count,
                        const std::string& where, EigenMethod method) {
  const auto n = static_cast<int>(K.rows());
  if (count <= 0) return {VectorX(0), MatrixX(n, 0)};
  const Deflation deflation = deflate(M, rigid);
  const bool most = 3 * count > n;
  if (method == EigenMethod::automatic) method = n <= kDenseBelow || most ? EigenMethod::dense : EigenMethod::lanczos;

  double shift = 0;
  const SparseCholesky factor(shifted_stiffness(K, M, shift));
  require_positive(factor, where);

  MatrixX X = method == EigenMethod::dense ? dense_modes(K, M, deflation, count)
                                           : lanczos_modes(K, M, deflation, count, shift, factor, where);
  // One inverse iteration sharpens the low modes; it is of no use to a whole spectrum.
  if (!most) {
    X = factor.solve(M * X);
    deflation.clean(X);
  }
  EigenModes modes;
  modes.eigenvalues = rotate_to_ritz_vectors(K, M, X);
  deflation.clean(X);
  orthonormalise(M, X);
  fix_signs(X);
  modes.vectors = std::move(X);
  return modes;
}

MatrixX static_deflections(const SparseMatrix& K, const SparseMatrix& M, const MatrixX& rigid, const MatrixX& loads,
                           const std::string& where) {
  double shift = 0;
  const SparseCholesky factor(shifted_stiffness(K, M, shift));
  require_positive(factor, where);
  const Deflation deflation = deflate(M, rigid);
  MatrixX F = loads;
  if (rigid.cols() > 0) F -= deflation.MD * (deflation.D.transpose() * F);

  // K X = F by the shifted factor: each round takes the shift's error, shift/λ, once more off every mode.
  MatrixX X = MatrixX::Zero(F.rows(), F.cols());
  for (int round = 0; round < 4; ++round) {
    MatrixX residual = F - K * X;
    if (rigid.cols() > 0) residual -= deflation.MD * (deflation.D.transpose() * residual);
    X += factor.solve(residual);
    deflation.clean(X);
  }
  return X;
}

EigenModes with_static_modes(const SparseMatrix& K, const SparseMatrix& M, const MatrixX& rigid,
                             const EigenModes& modes, const MatrixX& loads, const std::string& where) {
  MatrixX X = static_deflections(K, M, rigid, loads, where);

  // Unit compliance each, then what the eigenmodes and the other deflections lack: the K-orthonormal rest.
  const VectorX compliance = X.cwiseProduct(loads).colwise().sum().transpose();
  const double negligible = 1e-20 * compliance.maxCoeff();
  for (Eigen::Index k = 0; k < X.cols(); ++k) X.col(k) *= compliance[k] > negligible ? 1 / std::sqrt(compliance[k]) : 0;
  for (int pass = 0; pass < 2; ++pass) X -= modes.vectors * (modes.vectors.transpose() * (M * X));
  const MatrixX gram = X.transpose() * (K * X);
  const Eigen::SelfAdjointEigenSolver<MatrixX> parts(0.5 * (gram + gram.transpose()));
  const auto kept = (parts.eigenvalues().array() > 1e-12).count();
  const VectorX scale = parts.eigenvalues().tail(kept).cwiseSqrt().cwiseInverse();
  X = (X * parts.eigenvectors().rightCols(kept) * scale.asDiagonal()).eval();
  X.colwise().normalize();

  EigenModes both;
  both.vectors = beside(modes.vectors, X);
  both.eigenvalues = rotate_to_ritz_vectors(K, M, both.vectors);
  fix_signs(both.vectors);
  return both;
}

}  // namespace lithe
