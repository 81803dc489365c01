#include "bodies/flexible/static_modes.h"

#include <algorithm>
#include <cmath>

namespace lithe {
namespace {

constexpr double kNew = 1e-10;  // of a shape's strain energy

/// Columns to keep of a positive semidefinite matrix with unit diagonal, and the factor of what is kept: G = L Lᵀ.
struct PivotedCholesky {
  std::vector<int> kept;
  MatrixX L;
};

PivotedCholesky pivoted_cholesky(const MatrixX& G, double tolerance) {
  const Eigen::Index n = G.rows();
  PivotedCholesky found;
  MatrixX rows = MatrixX::Zero(n, n);  // L of all columns, in the order of the pivots
  VectorX rest = G.diagonal();
  for (Eigen::Index step = 0; step < n; ++step) {
    Eigen::Index pivot = 0;
    if (!(rest.maxCoeff(&pivot) > tolerance)) break;
    const double root = std::sqrt(rest[pivot]);
    VectorX column = G.col(pivot);
    column -= rows.leftCols(step) * rows.row(pivot).head(step).transpose();
    column /= root;
    for (int earlier : found.kept) column[earlier] = 0;
    rows.col(step) = column;
    rest -= column.cwiseAbs2();
    found.kept.push_back(static_cast<int>(pivot));
    for (int kept : found.kept) rest[kept] = 0;
  }
  const auto count = static_cast<Eigen::Index>(found.kept.size());
  found.L = rows(found.kept, Eigen::seqN(0, count));
  return found;
}

}  // namespace

MatrixX straining(const ElasticProblem& problem, MatrixX X) {
  const SparseMatrix &K = problem.stiffness(), &M = problem.mass();
  const double noise = eigenvalue_noise(K, M);
  std::vector<int> kept;
  for (Eigen::Index k = 0; k < X.cols(); ++k)
    if (X.col(k).dot(K * X.col(k)) > noise * X.col(k).dot(M * X.col(k))) kept.push_back(static_cast<int>(k));
  return static_cast<Eigen::Index>(kept.size()) == X.cols() ? X : MatrixX(X(Eigen::all, kept));
}

MatrixX added_directions(const ElasticProblem& problem, const MatrixX& known, MatrixX X) {
  const SparseMatrix &K = problem.stiffness(), &M = problem.mass();
  const VectorX energy = X.cwiseProduct(K * X).colwise().sum().transpose();
  const double negligible = X.cols() > 0 ? 1e-20 * energy.maxCoeff() : 0;
  for (Eigen::Index k = 0; k < X.cols(); ++k) X.col(k) *= energy[k] > negligible ? 1 / std::sqrt(energy[k]) : 0;
  for (int pass = 0; pass < 2; ++pass) X -= known * (known.transpose() * (M * X));
  const MatrixX gram = X.transpose() * (K * X);
  const PivotedCholesky factor = pivoted_cholesky(0.5 * (gram + gram.transpose()), kNew);
  X = X(Eigen::all, factor.kept).eval();
  factor.L.transpose().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(X);
  X.colwise().normalize();
  orthonormalise(M, X);
  X -= known * (known.transpose() * (M * X));
  orthonormalise(M, X);
  return X;
}

EigenModes joined(const ElasticProblem& problem, const EigenModes& modes, const MatrixX& shapes) {
  const MatrixX all = beside(modes.vectors, added_directions(problem, modes.vectors, shapes));
  if (all.cols() == 0) return modes;  // the frame holds all that the shapes would move
  return ritz_modes(problem.stiffness(), problem.mass(), all);
}

MatrixX krylov_shapes(const ElasticProblem& problem, const MatrixX& loads, int blocks) {
  MatrixX all(loads.rows(), 0), forces = loads;
  for (int block = 0; block < blocks && forces.cols() > 0; ++block) {
    const MatrixX next = added_directions(problem, all, problem.deflections(forces));
    forces = problem.mass() * next;
    all = beside(all, next);
  }
  return all;
}

MatrixX craig_bampton_shapes(const ElasticProblem& problem, int count) {
  return beside(lowest_modes(problem, count).vectors, problem.constraint_modes());
}

}  // namespace lithe
