#include "tests/bodies/bar_model.h"

#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "engine/base/dense_inverse.h"
#include "tests/support/linear_algebra.h"

namespace lithe::test {
namespace {

/// Stiffness of one brick, corner c at offset (c & 1, c >> 1 & 1, c >> 2), its modes 1 - ξ_k² eliminated.
MatrixX brick_stiffness(const Vector3& edge, double young, double poisson) {
  const double lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), shear = young / (2 * (1 + poisson));
  MatrixX K = MatrixX::Zero(33, 33);
  for (int point = 0; point < 8; ++point) {
    Vector3 xi;
    for (int a = 0; a < 3; ++a) xi[a] = ((point >> a & 1) ? 1 : -1) / std::sqrt(3.0);
    Eigen::Matrix<double, 3, 11> slope = Eigen::Matrix<double, 3, 11>::Zero();
    for (int c = 0; c < 8; ++c)
      for (int a = 0; a < 3; ++a) {
        const auto half = [&](int b) { return 0.5 * (1 + ((c >> b & 1) ? 1 : -1) * xi[b]); };
        slope(a, c) = ((c >> a & 1) ? 1 : -1) / edge[a] * half((a + 1) % 3) * half((a + 2) % 3);
      }
    for (int a = 0; a < 3; ++a) slope(a, 8 + a) = -4 * xi[a] / edge[a];
    for (int i = 0; i < 11; ++i)
      for (int j = 0; j < 11; ++j) {
        const Matrix3 outer = slope.col(i) * slope.col(j).transpose();
        K.block<3, 3>(3 * i, 3 * j) +=
            edge.prod() / 8 * (lame * outer + shear * outer.transpose() + shear * outer.trace() * Matrix3::Identity());
      }
  }
  const MatrixX coupling = K.bottomLeftCorner(9, 24);
  return K.topLeftCorner(24, 24) - congruence(coupling, inverse_of(K.bottomRightCorner(9, 9)));
}

}  // namespace

FiniteElementModel bar_model(const Bar& bar) {
  const auto [nx, ny, nz] = bar.bricks;
  const Vector3 edge(bar.size.x() / nx, bar.size.y() / ny, bar.size.z() / nz);
  const auto node_at = [ny, nz](int x, int y, int z) { return (x * (nz + 1) + z) * (ny + 1) + y; };
  FiniteElementModel model;
  model.name = "bar of " + std::to_string(nx * ny * nz) + " bricks";
  const int nodes = (nx + 1) * (ny + 1) * (nz + 1);
  model.node_ids.resize(nodes);
  std::iota(model.node_ids.begin(), model.node_ids.end(), 1);
  model.nodes.resize(3, nodes);
  for (int x = 0; x <= nx; ++x)
    for (int z = 0; z <= nz; ++z)
      for (int y = 0; y <= ny; ++y) {
        const int i = node_at(x, y, z);
        model.nodes.col(i) = Vector3(x, y, z).cwiseProduct(edge) - Vector3(0, bar.size.y() / 2, bar.size.z() / 2);
        if (x == 0) model.node_sets["start"].push_back(i + 1);
        if (x == nx) model.node_sets["end"].push_back(i + 1);
      }
  // Consistent mass: products of the one-dimensional 1/3 and 1/6.
  const auto K = brick_stiffness(edge, bar.young, bar.poisson);
  const double mass = bar.density * edge.prod();
  std::vector<Eigen::Triplet<double>> stiffnesses, masses;
  for (int x = 0; x < nx; ++x)
    for (int y = 0; y < ny; ++y)
      for (int z = 0; z < nz; ++z)
        for (int i = 0; i < 8; ++i)
          for (int j = 0; j < 8; ++j) {
            const int row = 3 * node_at(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2));
            const int column = 3 * node_at(x + (j & 1), y + (j >> 1 & 1), z + (j >> 2));
            double m = mass;
            for (int a = 0; a < 3; ++a) m *= ((i ^ j) >> a & 1) ? 1.0 / 6 : 1.0 / 3;
            for (int a = 0; a < 3; ++a) {
              masses.emplace_back(row + a, column + a, m);
              for (int b = 0; b < 3; ++b) stiffnesses.emplace_back(row + a, column + b, K(3 * i + a, 3 * j + b));
            }
          }
  for (auto [matrix, entries] : {std::pair(&model.stiffness, &stiffnesses), std::pair(&model.mass, &masses)}) {
    matrix->resize(3 * nodes, 3 * nodes);
    matrix->setFromTriplets(entries->begin(), entries->end());
  }
  const SparseMatrix transposed = model.stiffness.transpose();
  model.stiffness = 0.5 * (model.stiffness + transposed);
  return model;
}

std::vector<double> face_weights(const Bar& bar) {
  std::vector<double> weights;
  const auto end = [](int i, int n) { return i == 0 || i == n ? 0.5 : 1.0; };
  for (int z = 0; z <= bar.bricks[2]; ++z)
    for (int y = 0; y <= bar.bricks[1]; ++y) weights.push_back(end(y, bar.bricks[1]) * end(z, bar.bricks[2]));
  return weights;
}

}  // namespace lithe::test
