#include "tools/bench/brick_mesh.h"

#include <Eigen/LU>
#include <numeric>

namespace lithe::bench {
namespace {

/// One brick's matrices; all are alike.
struct Brick {
  Eigen::Matrix<double, 24, 24> stiffness = Eigen::Matrix<double, 24, 24>::Zero();
  Eigen::Matrix<double, 8, 8> mass = Eigen::Matrix<double, 8, 8>::Zero();  // m_ij: the nodal block is m_ij E
};

/// Corner c of a brick lies at offset (c & 1, c >> 1 & 1, c >> 2): N_c = Π ½ (1 ± ξ).
Brick make_brick(const Vector3& edge, const BrickMesh& mesh) {
  const double lame = mesh.young * mesh.poisson / ((1 + mesh.poisson) * (1 - 2 * mesh.poisson));
  const double shear = mesh.young / (2 * (1 + mesh.poisson));
  const double weight = edge.prod() / 8, gauss = 1 / std::sqrt(3.0);
  Brick brick;
  for (int point = 0; point < 8; ++point) {
    Eigen::Matrix<double, 3, 8> slope;  // ∂N/∂x
    Eigen::Matrix<double, 8, 1> N;
    for (int c = 0; c < 8; ++c) {
      double half[3], sign[3];
      for (int a = 0; a < 3; ++a) {
        sign[a] = (c >> a & 1) ? 1 : -1;
        half[a] = 0.5 * (1 + sign[a] * ((point >> a & 1) ? gauss : -gauss));
      }
      N[c] = half[0] * half[1] * half[2];
      for (int a = 0; a < 3; ++a) slope(a, c) = sign[a] / edge[a] * half[(a + 1) % 3] * half[(a + 2) % 3];
    }
    brick.mass += mesh.density * weight * N * N.transpose();
    // Isotropic elasticity: ∫ lame b_i b_jᵀ + shear (b_j b_iᵀ + b_i·b_j E).
    for (int i = 0; i < 8; ++i)
      for (int j = 0; j < 8; ++j) {
        const Matrix3 outer = slope.col(i) * slope.col(j).transpose();
        brick.stiffness.block<3, 3>(3 * i, 3 * j) +=
            weight * (lame * outer + shear * outer.transpose() + shear * outer.trace() * Matrix3::Identity());
      }
  }
  return brick;
}

}  // namespace

FiniteElementModel brick_model(const BrickMesh& mesh) {
  const auto [nx, ny, nz] = mesh.bricks;
  const Vector3 edge(mesh.size.x() / nx, mesh.size.y() / ny, mesh.size.z() / nz);
  const auto node_at = [&, rows = ny + 1, layer = (ny + 1) * (nz + 1)](int x, int y, int z) {
    return x * layer + z * rows + y;
  };

  FiniteElementModel model;
  model.name = std::to_string(nx * ny * nz) + " bricks";
  const int nodes = (nx + 1) * (ny + 1) * (nz + 1);
  model.node_ids.resize(nodes);
  std::iota(model.node_ids.begin(), model.node_ids.end(), 1);
  model.nodes.resize(3, nodes);
  for (int x = 0; x <= nx; ++x)
    for (int y = 0; y <= ny; ++y)
      for (int z = 0; z <= nz; ++z) model.nodes.col(node_at(x, y, z)) = Vector3(x, y, z).cwiseProduct(edge);
  for (int y = 0; y <= ny; ++y) model.node_sets["hinge"].push_back(node_at(0, y, 0) + 1);
  model.node_sets["tip"] = {node_at(nx, ny / 2, 0) + 1};

  const Brick brick = make_brick(edge, mesh);
  std::vector<Eigen::Triplet<double>> stiffness, mass;
  for (int x = 0; x < nx; ++x)
    for (int y = 0; y < ny; ++y)
      for (int z = 0; z < nz; ++z) {
        int corner[8];
        for (int c = 0; c < 8; ++c) corner[c] = node_at(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
        for (int i = 0; i < 24; ++i)
          for (int j = 0; j < 24; ++j) {
            const int row = 3 * corner[i / 3] + i % 3, column = 3 * corner[j / 3] + j % 3;
            stiffness.emplace_back(row, column, brick.stiffness(i, j));
            if (i % 3 == j % 3) mass.emplace_back(row, column, brick.mass(i / 3, j / 3));
          }
      }
  for (auto [matrix, entries] : {std::pair(&model.stiffness, &stiffness), std::pair(&model.mass, &mass)}) {
    matrix->resize(3 * nodes, 3 * nodes);
    matrix->setFromTriplets(entries->begin(), entries->end());
  }
  return model;
}

}  // namespace lithe::bench
