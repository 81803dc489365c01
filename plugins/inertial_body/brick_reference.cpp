// What bricks know of their undeformed shape: gradients, mass, places in the sparse blocks.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>

#include "plugins/inertial_body/brick.h"

namespace lithe::brick {
namespace {

using Shape = Eigen::Matrix<double, kNodes, 1>;
using Slopes = Eigen::Matrix<double, kNodes, 3>;

constexpr double kCorners[kNodes][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                        {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};

Vector3 gauss_point(int p) {
  const double g = 1 / std::sqrt(3.0);
  return {p & 1 ? g : -g, p & 2 ? g : -g, p & 4 ? g : -g};
}

/// Trilinear shape functions and their derivatives by ξ, η, ζ.
void trilinear(const Vector3& at, Shape& N, Slopes& dN) {
  for (int a = 0; a < kNodes; ++a) {
    const double *s = kCorners[a], x = 1 + s[0] * at[0], y = 1 + s[1] * at[1], z = 1 + s[2] * at[2];
    N[a] = x * y * z / 8;
    dN.row(a) << s[0] * y * z / 8, s[1] * x * z / 8, s[2] * x * y / 8;
  }
}

/// J(k, i) = ∂X_i/∂ξ_k.
Matrix3 jacobian(const Slopes& dN, const Slopes& X) {
  Matrix3 J = Matrix3::Zero();
  for (int a = 0; a < kNodes; ++a) J += dN.row(a).transpose() * X.row(a);
  return J;
}

}  // namespace

Bricks::Bricks(const BrickMesh& mesh)
    : element_count_(mesh.element_count()),
      has_modes_(mesh.type == BrickType::incompatible_modes),
      lambda_(mesh.material.lambda()),
      mu_(mesh.material.mu()) {
  batches_.resize((element_count_ + kLanes - 1) / kLanes);
  for (int b = 0; b < batch_count(); ++b) {
    Batch& batch = batches_[b];
    batch.count = std::min(kLanes, element_count_ - kLanes * b);
    batch.size = 1e300;
    for (int l = 0; l < kLanes; ++l) set_reference(mesh, std::min(kLanes * b + l, element_count_ - 1), batch, l);
  }
  set_pattern(mesh);
  set_mass(mesh);
}

void Bricks::set_reference(const BrickMesh& mesh, int element, Batch& batch, int lane) {
  Slopes X;
  for (int a = 0; a < kNodes; ++a) {
    batch.node[a][lane] = mesh.elements[element][a];
    X.row(a) = mesh.nodes.col(mesh.elements[element][a]).transpose();
  }
  Shape N;
  Slopes dN;
  trilinear(Vector3::Zero(), N, dN);
  const Matrix3 J0 = jacobian(dN, X);
  const Matrix3 J0_inverse = J0.inverse();
  double volume = 0;
  for (int p = 0; p < kPoints; ++p) {
    const Vector3 at = gauss_point(p);
    trilinear(at, N, dN);
    const Matrix3 J = jacobian(dN, X);
    const double det = J.determinant();
    if (!(det > 0) || !(J0.determinant() > 0))
      throw SceneError("element " + std::to_string(mesh.element_ids[element]) + " is inside out or flat", mesh.name,
                       "number its nodes bottom face first, counter-clockwise seen from the top face");
    const Slopes gradient = dN * J.inverse().transpose();
    for (int a = 0; a < kNodes; ++a)
      for (int i = 0; i < 3; ++i) batch.gradient[p][a][i][lane] = gradient(a, i);
    for (int k = 0; k < kModes; ++k) {
      const Vector3 g = -2 * at[k] * (J0.determinant() / det) * J0_inverse.col(k);
      for (int i = 0; i < 3; ++i) batch.gradient[p][kNodes + k][i][lane] = g[i];
    }
    batch.weight[p][lane] = det;
    volume += det;
  }
  batch.size = std::min(batch.size, std::cbrt(volume));
}

void Bricks::set_pattern(const BrickMesh& mesh) {
  const int n = mesh.node_count();
  std::vector<std::set<int>> below(n);  // neighbours of larger index
  for (const auto& element : mesh.elements)
    for (int i : element)
      for (int j : element)
        if (j > i) below[i].insert(j);
  // Columns of node j: its own lower triangle, then three rows for each larger neighbour.
  std::vector<int> first(3 * n);
  std::vector<std::vector<int>> neighbours(n);
  int size = 0;
  for (int j = 0; j < n; ++j) {
    neighbours[j].assign(below[j].begin(), below[j].end());
    for (int k = 0; k < 3; ++k) {
      first[3 * j + k] = size;
      size += 3 - k + 3 * static_cast<int>(neighbours[j].size());
    }
  }
  pattern_.rows.resize(size), pattern_.columns.resize(size);
  for (int j = 0, at = 0; j < n; ++j)
    for (int k = 0; k < 3; ++k) {
      const auto add = [&](int row) { pattern_.rows[at] = row, pattern_.columns[at++] = 3 * j + k; };
      for (int i = k; i < 3; ++i) add(3 * j + i);
      for (int node : neighbours[j])
        for (int i = 0; i < 3; ++i) add(3 * node + i);
    }
  for (Batch& batch : batches_)
    for (int l = 0; l < kLanes; ++l)
      for (int a = 0, pair = 0; a < kNodes; ++a)
        for (int c = 0; c <= a; ++c, ++pair) {
          const int i = batch.node[a][l], j = batch.node[c][l], column = std::min(i, j), row = std::max(i, j);
          batch.swapped[pair][l] = j > i;
          const auto& list = neighbours[column];
          const int rank = static_cast<int>(std::lower_bound(list.begin(), list.end(), row) - list.begin());
          for (int k = 0; k < 3; ++k)
            batch.place[pair][l][k] = first[3 * column + k] + (row == column ? -k : 3 - k + 3 * rank);
        }
}

void Bricks::set_mass(const BrickMesh& mesh) {
  mass_.setZero(pattern_.rows.size());
  nodal_mass_.setZero(mesh.node_count());
  Shape N;
  Slopes dN;
  for (const Batch& batch : batches_)
    for (int l = 0; l < batch.count; ++l) {
      Eigen::Matrix<double, kNodes, kNodes> m = Eigen::Matrix<double, kNodes, kNodes>::Zero();
      for (int p = 0; p < kPoints; ++p) {
        trilinear(gauss_point(p), N, dN);
        m += mesh.material.density * batch.weight[p][l] * N * N.transpose();
      }
      for (int a = 0, pair = 0; a < kNodes; ++a) {
        nodal_mass_[batch.node[a][l]] += m.row(a).sum();
        for (int c = 0; c <= a; ++c, ++pair)
          for (int k = 0; k < 3; ++k) mass_[batch.place[pair][l][k] + k] += m(a, c);
      }
    }
}

Matrix3 Bricks::deformation_gradient(int element, int point, const double* x, const std::vector<Modes>& modes) const {
  const Batch& batch = batches_[element / kLanes];
  const int l = element % kLanes;
  Matrix3 F = Matrix3::Zero();
  const auto add = [&](const Vector3& value, int shape) {
    const auto& g = batch.gradient[point][shape];
    F += value * Eigen::RowVector3d(g[0][l], g[1][l], g[2][l]);
  };
  const Eigen::Map<const Vector3> origin(x + 3 * batch.node[0][l]);
  for (int a = 0; a < kNodes; ++a) add(Eigen::Map<const Vector3>(x + 3 * batch.node[a][l]) - origin, a);
  if (!has_modes_) return F;
  const auto& alpha = modes[element / kLanes].alpha;
  for (int k = 0; k < kModes; ++k) add({alpha[3 * k][l], alpha[3 * k + 1][l], alpha[3 * k + 2][l]}, kNodes + k);
  return F;
}

}  // namespace lithe::brick
