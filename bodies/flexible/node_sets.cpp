#include "bodies/flexible/node_sets.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr double kDependent = 1e-9;  // of the largest singular value

/// Orthonormal columns that span the rigid motions of these nodes: six, five for nodes on a line, three for one node.
MatrixX rigid_space(const Matrix3X& nodes, const std::vector<RotationalDof>& rotations = {}) {
  const MatrixX R = rigid_motions_left(nodes, rotations, {});
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
      throw SceneError("an average has a weight that is negative or not finite, or none that is positive.", where,
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

MatrixX NodeAverage::unit_loads(int dof_count) const {
  MatrixX F = MatrixX::Zero(dof_count, 6);
  for (size_t k = 0; k < nodes.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    F.block<3, 3>(3 * nodes[k], 0) += weights[column] * Matrix3::Identity();
    F.block<3, 3>(3 * nodes[k], 3) -= weights[column] * skew(arms.col(column)) * spread_inverse;
  }
  return F;
}

FreeMotions free_motions(const FramePlacement& placed, const std::vector<RotationalDof>& rotations,
                         const std::vector<std::vector<int>>& rigid_sets) {
  const auto n = static_cast<int>(placed.nodes.cols()), dofs = 3 * n + static_cast<int>(rotations.size());
  enum : char { kFree, kFixed, kTied };
  std::vector<char> kind(static_cast<size_t>(dofs), kFree);
  for (int dof : placed.fixed_dofs) kind[static_cast<size_t>(dof)] = kFixed;

  // Of each set its degrees of freedom, and the motions of these that the frame allows.
  std::vector<std::vector<int>> set_dofs(rigid_sets.size());
  std::vector<MatrixX> motions;
  std::vector<int> place_in_set(static_cast<size_t>(n));
  for (size_t s = 0; s < rigid_sets.size(); ++s) {
    const auto& set = rigid_sets[s];
    Matrix3X nodes(3, static_cast<Eigen::Index>(set.size()));
    std::fill(place_in_set.begin(), place_in_set.end(), -1);
    for (size_t k = 0; k < set.size(); ++k) {
      nodes.col(static_cast<Eigen::Index>(k)) = placed.nodes.col(set[k]);
      place_in_set[static_cast<size_t>(set[k])] = static_cast<int>(k);
      for (int axis = 0; axis < 3; ++axis) set_dofs[s].push_back(3 * set[k] + axis);
    }
    std::vector<RotationalDof> turns;
    for (size_t k = 0; k < rotations.size(); ++k)
      if (const int place = place_in_set[static_cast<size_t>(rotations[k].node)]; place >= 0) {
        turns.push_back({place, rotations[k].axis});
        set_dofs[s].push_back(3 * n + static_cast<int>(k));
      }
    std::vector<int> held;
    for (size_t row = 0; row < set_dofs[s].size(); ++row)
      if (kind[static_cast<size_t>(set_dofs[s][row])] == kFixed) held.push_back(static_cast<int>(row));
    motions.push_back(vanishing(rigid_space(nodes, turns), held));
  }
  for (size_t s = 0; s < rigid_sets.size(); ++s)
    for (int dof : set_dofs[s]) {
      if (kind[static_cast<size_t>(dof)] == kTied)
        throw SceneError("node index " + std::to_string(dof / 3) + " lies in two rigid sets, or twice in one.",
                         placed.where, "name it once; sets that share nodes are one rigid set.");
      kind[static_cast<size_t>(dof)] = kTied;
    }

  FreeMotions found;
  std::vector<Eigen::Triplet<double>> entries;
  for (int dof = 0; dof < dofs; ++dof)
    if (kind[static_cast<size_t>(dof)] == kFree) entries.emplace_back(dof, found.loose++, 1.0);
  int column = found.loose;
  for (size_t s = 0; s < rigid_sets.size(); ++s)
    for (Eigen::Index k = 0; k < motions[s].cols(); ++k, ++column)
      for (size_t row = 0; row < set_dofs[s].size(); ++row)
        if (const double value = motions[s](static_cast<Eigen::Index>(row), k); value != 0)
          entries.emplace_back(set_dofs[s][row], column, value);
  found.T.resize(dofs, column);
  found.T.setFromTriplets(entries.begin(), entries.end());
  return found;
}

VectorX deformation(const Matrix3X& nodes, const MatrixX& displacements) {
  const MatrixX Q = rigid_space(nodes);
  const MatrixX rest = displacements - Q * (Q.transpose() * displacements);
  return rest.cwiseAbs().colwise().maxCoeff().transpose();
}

}  // namespace lithe
