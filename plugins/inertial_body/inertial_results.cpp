#include <Eigen/LU>
#include <cmath>

#include "plugins/inertial_body/inertial_body.h"

namespace lithe {
namespace {

Vector6 components(const Matrix3& A) {
  Vector6 six;
  six << A(0, 0), A(1, 1), A(2, 2), A(0, 1), A(1, 2), A(0, 2);
  return six;
}

/// Value at corner a of what the eight Gauss points give: trilinear through them, the corner at √3 of their cube.
Eigen::Matrix<double, 8, 8> extrapolation() {
  constexpr double corners[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                    {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
  Eigen::Matrix<double, 8, 8> N;
  for (int a = 0; a < 8; ++a)
    for (int p = 0; p < 8; ++p) {
      double product = 1.0 / 8;
      for (int i = 0; i < 3; ++i) product *= 1 + std::sqrt(3.0) * corners[a][i] * (p >> i & 1 ? 1 : -1);
      N(p, a) = product;
    }
  return N;
}

}  // namespace

Matrix3X InertialBody::positions(const BodyState& state) const {
  return Eigen::Map<const Matrix3X>(state.q, 3, node_count());
}
Matrix3X InertialBody::velocities(const BodyState& state) const {
  return Eigen::Map<const Matrix3X>(state.v, 3, node_count());
}

InertialBody::StressField InertialBody::stress(const BodyState& state) const {
  const auto& cache = static_cast<const Cache&>(*state.cache);
  const Solid& solid = mesh().material;
  const int points = 8 * bricks_.element_count();
  StressField field{Matrix6X(6, points), Matrix6X(6, points), Matrix6X(6, points)};
  for (int e = 0; e < bricks_.element_count(); ++e)
    for (int p = 0; p < 8; ++p) {
      const Matrix3 F = bricks_.deformation_gradient(e, p, state.q, cache.modes);
      const Matrix3 E = 0.5 * (F.transpose() * F - Matrix3::Identity());
      const Matrix3 S = solid.lambda() * E.trace() * Matrix3::Identity() + 2 * solid.mu() * E;
      field.strain.col(8 * e + p) = components(E);
      field.second_piola_kirchhoff.col(8 * e + p) = components(S);
      field.cauchy.col(8 * e + p) = components(F * S * F.transpose() / F.determinant());
    }
  return field;
}

InertialBody::StressField InertialBody::nodal_stress(const BodyState& state) const {
  const StressField at_points = stress(state);
  const Eigen::Matrix<double, 8, 8> N = extrapolation();
  VectorX meeting = VectorX::Zero(node_count());
  for (const auto& element : mesh().elements)
    for (int i : element) meeting[i] += 1;
  const auto average = [&](const Matrix6X& values) {
    Matrix6X nodal = Matrix6X::Zero(6, node_count());
    for (int e = 0; e < bricks_.element_count(); ++e) {
      const Eigen::Matrix<double, 6, 8> corners = values.middleCols<8>(8 * e) * N;
      for (int a = 0; a < 8; ++a) nodal.col(mesh().elements[e][a]) += corners.col(a);
    }
    return Matrix6X(nodal * meeting.cwiseInverse().asDiagonal());
  };
  return {average(at_points.cauchy), average(at_points.second_piola_kirchhoff), average(at_points.strain)};
}

Vector3 InertialBody::linear_momentum(const BodyState& state) const { return velocities(state) * bricks_.nodal_mass(); }

Vector3 InertialBody::angular_momentum(const BodyState& state) const {
  VectorX momentum = VectorX::Zero(3 * node_count());  // M v
  add_mass_product(1, state.v, momentum.data());
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < node_count(); ++i)
    sum += Eigen::Map<const Vector3>(state.q + 3 * i).cross(Vector3(momentum.segment<3>(3 * i)));
  return sum;
}

}  // namespace lithe
