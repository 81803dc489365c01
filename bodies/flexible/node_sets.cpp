#include "bodies/flexible/node_sets.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "engine/error.h"

namespace lithe {
namespace {

constexpr double kDependent = 1e-9;  // of the largest singular value

/// Orthonormal columns that span the rigid motions of these nodes: six, five for nodes on a line, three for one node.
MatrixX rigid_space(const Matrix3X& nodes) {
  const MatrixX R = rigid_motions_left(nodes, {});
  const Eigen::JacobiSVD<MatrixX> svd(R, Eigen::ComputeThinU);
  int rank = 0;
  while (rank < svd.singularValues().size() && svd.singularValues()[rank] > kDependent * svd.singularValues()[0])
    ++rank;
  return svd.matrixU().leftCols(rank);
}

/// The columns' combinations that vanish in the given rows, again orthonormal.
MatrixX vanishing(const MatrixX& columns, const std::vector<int>& rows) {
  if (rows.empty()) return columns;
  MatrixX held(static_cast<Eigen::Index>(rows.size()), columns.cols());
  for (size_t k = 0; k < rows.size(); ++k) held.row(static_cast<Eigen::Index>(k)) = columns.row(rows[k]);
  const Eigen::JacobiSVD<MatrixX> svd(held, Eigen::ComputeFullV);
  int rank = 0;
  // The columns have unit length: what the rows see of them is small or of order one over the root of the set's size.
  while (rank < svd.singularValues().size() && svd.singularValues()[rank] > 1e-7 * svd.singularValues()[0]) ++rank;
  MatrixX left = columns * svd.matrixV().rightCols(columns.cols() - rank);
  for (int row : rows) left.row(row).setZero();
  return left;
}

}  // namespace

NodeAverage::NodeAverage(const Matrix3X& positions, std::vector<int> indices, const std::vector<double>& given,
                         const std::string& where)
    : nodes(std::move(indices)) {
  if (nodes.empty()) throw SceneError("an average has no nodes.", where, "name at least one node.");
  const auto count = static_cast<Eigen::Index>(nodes.size());
  weights = VectorX::Ones(count);
  if (!given.empty()) {
    if (given.size() != nodes.size())
      throw SceneError(
          "an average of " + std::to_string(count) + " nodes has " + std::to_string(given.size()) + " weights.", where,
          "give a weight a node, or none.");
    weights = Eigen::Map<const VectorX>(given.data(), count);
    if (!(weights.minCoeff() >= 0) || !(weights.sum() > 0) || !weights.allFinite())
      throw SceneError("an average has a weight that is negative or no number, or none that is positive.", where,
                       "give weights like the areas that the nodes stand for; only their ratios count.");
  }
  weights /= weights.sum();
  arms.resize(3, count);
  for (Eigen::Index k = 0; k < count; ++k) center += weights[k] * positions.col(nodes[static_cast<size_t>(k)]);
  Matrix3 D = Matrix3::Zero();
  for (Eigen::Index k = 0; k < count; ++k) {
    const Vector3 arm = positions.col(nodes[static_cast<size_t>(k)]) - center;
    arms.col(k) = arm;
    D += weights[k] * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(D);
  on_a_line = !(eigen.eigenvalues()[0] > kDependent * eigen.eigenvalues()[2]);
  for (int a = 0; a < 3; ++a)
    if (eigen.eigenvalues()[a] > kDependent * eigen.eigenvalues()[2])
      spread_inverse += eigen.eigenvectors().col(a) * eigen.eigenvectors().col(a).transpose() / eigen.eigenvalues()[a];
}

MatrixX NodeAverage::unit_loads(int node_count) const {
  MatrixX F = MatrixX::Zero(3 * node_count, 6);
  for (size_t k = 0; k < nodes.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    F.block<3, 3>(3 * nodes[k], 0) += weights[column] * Matrix3::Identity();
    F.block<3, 3>(3 * nodes[k], 3) -= weights[column] * skew(arms.col(column)) * spread_inverse;
  }
  return F;
}

SparseMatrix free_motions(const FramePlacement& placed, const std::vector<std::vector<int>>& rigid_sets) {
  const auto n = static_cast<int>(placed.nodes.cols());
  enum : char { kFree, kFixed, kTied };
  std::vector<char> kind(static_cast<size_t>(3 * n), kFree);
  for (int dof : placed.fixed_dofs) kind[static_cast<size_t>(dof)] = kFixed;

  std::vector<Eigen::Triplet<double>> entries;
  std::vector<MatrixX> motions;
  for (const auto& set : rigid_sets) {
    Matrix3X nodes(3, static_cast<Eigen::Index>(set.size()));
    std::vector<int> held;
    for (size_t k = 0; k < set.size(); ++k) {
      nodes.col(static_cast<Eigen::Index>(k)) = placed.nodes.col(set[k]);
      for (int axis = 0; axis < 3; ++axis)
        if (kind[static_cast<size_t>(3 * set[k] + axis)] == kFixed) held.push_back(3 * static_cast<int>(k) + axis);
    }
    motions.push_back(vanishing(rigid_space(nodes), held));
  }
  for (const auto& set : rigid_sets)
    for (int node : set) {
      if (kind[static_cast<size_t>(3 * node)] == kTied)
        throw SceneError("node index " + std::to_string(node) + " lies in two rigid sets, or twice in one.",
                         placed.where, "name it once; sets that share nodes are one rigid set.");
      for (int axis = 0; axis < 3; ++axis) kind[static_cast<size_t>(3 * node + axis)] = kTied;
    }

  int column = 0;
  for (int dof = 0; dof < 3 * n; ++dof)
    if (kind[static_cast<size_t>(dof)] == kFree) entries.emplace_back(dof, column++, 1.0);
  for (size_t s = 0; s < rigid_sets.size(); ++s)
    for (Eigen::Index k = 0; k < motions[s].cols(); ++k, ++column)
      for (size_t i = 0; i < rigid_sets[s].size(); ++i)
        for (int axis = 0; axis < 3; ++axis)
          if (const double value = motions[s](3 * static_cast<Eigen::Index>(i) + axis, k); value != 0)
            entries.emplace_back(3 * rigid_sets[s][i] + axis, column, value);
  SparseMatrix T(3 * n, column);
  T.setFromTriplets(entries.begin(), entries.end());
  return T;
}

VectorX deformation(const Matrix3X& nodes, const MatrixX& displacements) {
  const MatrixX Q = rigid_space(nodes);
  const MatrixX rest = displacements - Q * (Q.transpose() * displacements);
  return rest.cwiseAbs().colwise().maxCoeff().transpose();
}

}  // namespace lithe
