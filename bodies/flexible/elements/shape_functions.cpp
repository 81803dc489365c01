#include "bodies/flexible/elements/shape_functions.h"

#include <array>
#include <cmath>

namespace lithe {
namespace {

// Corners of a brick, then the middles of its bottom, top and vertical edges.
constexpr int kBrick[20][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1},  {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1},
                               {-1, 1, 1},   {0, -1, -1}, {1, 0, -1},  {0, 1, -1},  {-1, 0, -1}, {0, -1, 1}, {1, 0, 1},
                               {0, 1, 1},    {-1, 0, 1},  {-1, -1, 0}, {1, -1, 0},  {1, 1, 0},   {-1, 1, 0}};
constexpr int kTetrahedronEdges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

/// N = ⅛ Π (1 + s_k ξ_k)
ShapeValues brick8(const Vector3& xi) {
  ShapeValues shape{VectorX(8), MatrixX(8, 3)};
  for (int a = 0; a < 8; ++a) {
    Vector3 f;
    for (int k = 0; k < 3; ++k) f[k] = 1 + kBrick[a][k] * xi[k];
    shape.values[a] = f.prod() / 8;
    for (int k = 0; k < 3; ++k) shape.gradients(a, k) = kBrick[a][k] * f[(k + 1) % 3] * f[(k + 2) % 3] / 8;
  }
  return shape;
}

/// Corners ⅛ Π (1 + s_k ξ_k) (Σ s_k ξ_k - 2), middles ¼ (1 - ξ_m²) (1 + s_k ξ_k)(1 + s_l ξ_l).
ShapeValues brick20(const Vector3& xi) {
  ShapeValues shape{VectorX(20), MatrixX(20, 3)};
  for (int a = 0; a < 20; ++a) {
    Vector3 f, df;  // factors and their derivatives
    for (int k = 0; k < 3; ++k) {
      const int s = kBrick[a][k];
      f[k] = s == 0 ? 1 - xi[k] * xi[k] : 1 + s * xi[k];
      df[k] = s == 0 ? -2 * xi[k] : s;
    }
    double sum = -2;
    for (int k = 0; k < 3; ++k) sum += kBrick[a][k] * xi[k];
    shape.values[a] = a < 8 ? f.prod() * sum / 8 : f.prod() / 4;
    for (int k = 0; k < 3; ++k) {
      const double others = f[(k + 1) % 3] * f[(k + 2) % 3];
      shape.gradients(a, k) = a < 8 ? others * (df[k] * sum + f[k] * kBrick[a][k]) / 8 : others * df[k] / 4;
    }
  }
  return shape;
}

/// Barycentric L: corners L or L (2 L - 1), middles 4 L_a L_b.
ShapeValues tetrahedron(int node_count, const Vector3& xi) {
  const Vector4 L(1 - xi.sum(), xi[0], xi[1], xi[2]);
  Eigen::Matrix<double, 4, 3> dL;
  dL << -1, -1, -1, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  if (node_count == 4) return {L, dL};
  ShapeValues shape{VectorX(10), MatrixX(10, 3)};
  for (int a = 0; a < 4; ++a) {
    shape.values[a] = L[a] * (2 * L[a] - 1);
    shape.gradients.row(a) = (4 * L[a] - 1) * dL.row(a);
  }
  for (int e = 0; e < 6; ++e) {
    const int a = kTetrahedronEdges[e][0], b = kTetrahedronEdges[e][1];
    shape.values[4 + e] = 4 * L[a] * L[b];
    shape.gradients.row(4 + e) = 4 * (L[a] * dL.row(b) + L[b] * dL.row(a));
  }
  return shape;
}

}  // namespace

ShapeValues shape_functions(int node_count, const Vector3& xi) {
  if (node_count == 8) return brick8(xi);
  if (node_count == 20) return brick20(xi);
  return tetrahedron(node_count, xi);
}

Matrix3X natural_nodes(int node_count) {
  Matrix3X xi = Matrix3X::Zero(3, node_count);
  if (node_count == 8 || node_count == 20) {
    for (int a = 0; a < node_count; ++a) xi.col(a) << kBrick[a][0], kBrick[a][1], kBrick[a][2];
    return xi;
  }
  for (int a = 1; a < 4; ++a) xi(a - 1, a) = 1;
  for (int e = 4; e < node_count; ++e)
    xi.col(e) = 0.5 * (xi.col(kTetrahedronEdges[e - 4][0]) + xi.col(kTetrahedronEdges[e - 4][1]));
  return xi;
}

std::vector<IntegrationPoint> brick_rule(int points_per_direction) {
  std::vector<std::array<double, 2>> line;  // position, weight
  if (points_per_direction == 2)
    line = {{-std::sqrt(1.0 / 3), 1.0}, {std::sqrt(1.0 / 3), 1.0}};
  else
    line = {{-std::sqrt(0.6), 5.0 / 9}, {0.0, 8.0 / 9}, {std::sqrt(0.6), 5.0 / 9}};
  std::vector<IntegrationPoint> rule;
  for (const auto& z : line)
    for (const auto& y : line)
      for (const auto& x : line) rule.push_back({{x[0], y[0], z[0]}, x[1] * y[1] * z[1]});
  return rule;
}

std::vector<IntegrationPoint> tetrahedron_rule(int points) {
  constexpr double volume = 1.0 / 6;
  std::vector<IntegrationPoint> rule;
  // One point near each corner: barycentric 1 - 3 a there, a at the others; the corner at ξ = 0 comes first.
  const auto add_corners = [&](double a, double weight) {
    rule.push_back({Vector3::Constant(a), weight * volume});
    for (int k = 0; k < 3; ++k)
      rule.push_back({Vector3::Constant(a) + (1 - 4 * a) * Vector3::Unit(k), weight * volume});
  };
  if (points == 4) {
    add_corners((5 - std::sqrt(5.0)) / 20, 0.25);
    return rule;
  }
  rule.push_back({Vector3::Constant(0.25), (points == 1 ? 1.0 : 16.0 / 135) * volume});
  if (points == 1) return rule;
  const double root = std::sqrt(15.0);
  add_corners((7 - root) / 34, (2665 + 14 * root) / 37800);
  add_corners((7 + root) / 34, (2665 - 14 * root) / 37800);
  const double a = (5 - root) / 20, b = (5 + root) / 20;  // two barycentric coordinates are a, two are b
  for (const Vector3& xi :
       {Vector3(a, b, b), Vector3(b, a, b), Vector3(b, b, a), Vector3(b, a, a), Vector3(a, b, a), Vector3(a, a, b)})
    rule.push_back({xi, 10.0 / 189 * volume});
  return rule;
}

MatrixX strain_matrix(const MatrixX& gradients) {
  MatrixX B = MatrixX::Zero(6, 3 * gradients.rows());
  for (Eigen::Index a = 0; a < gradients.rows(); ++a) {
    const double x = gradients(a, 0), y = gradients(a, 1), z = gradients(a, 2);
    B.block<6, 3>(0, 3 * a) << x, 0, 0, 0, y, 0, 0, 0, z, y, x, 0, z, 0, x, 0, z, y;
  }
  return B;
}

}  // namespace lithe
