#include "bodies/beam/beam_span.h"

#include <numbers>

#include "bodies/beam/node_mass_internal.h"
#include "bodies/beam/se3_internal.h"
#include "bodies/beam/span_field_internal.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr double kGauss[] = {0.21132486540518711775, 0.78867513459481288225};  // weights ½

/// C = Uᵀ D U, U unit upper triangular; returns Uᵀ D τ U.
Matrix6 damping_of(const BeamSection& section) {
  Matrix6 rest = section.stiffness, U = Matrix6::Identity();
  Vector6 D;
  for (int i = 0; i < 6; ++i) {
    D[i] = rest(i, i);
    for (int j = i + 1; j < 6; ++j) U(i, j) = rest(i, j) / rest(i, i);
    for (int k = i + 1; k < 6; ++k)
      for (int j = i + 1; j < 6; ++j) rest(k, j) -= D[i] * U(i, k) * U(i, j);
  }
  return U.transpose() * D.cwiseProduct(section.damping).asDiagonal() * U;
}

BeamSpan::Vector12 both(const Vector6& A, const Vector6& B) {
  BeamSpan::Vector12 out;
  out << A, B;
  return out;
}

}  // namespace

BeamSpan::BeamSpan(const BeamSection& section, double length, const Vector6& drawn)
    : section_(section), length_(length), drawn_(drawn), damping_(damping_of(section)) {
  const double helix = drawn.head<3>().norm(), turn = drawn.tail<3>().norm();
  if (turn > std::numbers::pi / 2)
    throw SceneError("its ends are drawn " + std::to_string(turn * 180 / std::numbers::pi) + " degrees apart", "",
                     "take more elements: below 90 degrees each, below 20 for results of two digits");
  if (!(std::abs(helix - length) <= 0.05 * length && helix > 0))
    throw SceneError("its length is " + std::to_string(length) + " m and the curve between its ends has " +
                         std::to_string(helix) + " m",
                     "", "give the length along the axis, or take more elements");
  if (drawn[0] < 0.5 * helix)
    throw SceneError("axis 1 of its sections does not point along the beam", "",
                     "turn the axes so that axis 1 runs from the start of the beam to its end");
}

Vector6 BeamSpan::resultants(const Vector6& d, const Vector6& v_A, const Vector6& v_B) const {
  Vector6 sigma = section_.stiffness * strain(d);
  if (section_.damping.isZero(0)) return sigma;
  const se3::Blocks inverse = se3::blocks(se3::right_inverse_at(d), d);
  sigma += damping_ * (inverse * v_B - inverse.turned_back() * v_A) / length_;
  return sigma;
}

BeamSpan::Vector12 BeamSpan::internal_forces(const Vector6& d, const Vector6& sigma) const {
  const auto [F, G] = se3::blocks(se3::right_inverse_at(d), d);
  const Vector3 n = sigma.head<3>(), m = sigma.tail<3>();
  Vector12 out;
  out << -(F * n), -(G * n + F * m), F.transpose() * n, G.transpose() * n + F.transpose() * m;
  return out;
}

BeamSpan::Matrix12 BeamSpan::tangent(const Vector6& d, const Vector6& sigma, double position, double velocity) const {
  const se3::Analytic inverse = se3::right_inverse_at(d);
  const se3::Blocks T = se3::blocks(inverse, d);
  const Matrix6 A = -T.turned_back().matrix(), B = T.matrix();
  Matrix6 C = (position / length_) * section_.stiffness;
  if (velocity != 0) C += (velocity / length_) * damping_;
  const Matrix6 CA = C * A, CB = C * B;
  Matrix12 K;
  K.topLeftCorner<6, 6>().noalias() = A.transpose() * CA;
  K.topRightCorner<6, 6>().noalias() = A.transpose() * CB;
  K.bottomLeftCorner<6, 6>() = K.topRightCorner<6, 6>().transpose();
  K.bottomRightCorner<6, 6>().noalias() = B.transpose() * CB;
  if (position == 0) return K;
  // What the resultants do as the ends move, by [D, E; 0, D] = ∂(T⁻¹ (m, n))/∂d: -[0, D; D, E] at the first end, and at
  // the second [0, n~ + D; n~ + D, m~ + E].
  const Vector3 n = sigma.head<3>(), m = sigma.tail<3>();
  Vector6 exchanged;
  exchanged << m, n;
  const auto [D, E] = se3::rates(inverse, d, exchanged);
  const auto add = [&](int end, const Matrix3& side, const Matrix3& turn) {
    for (int by : {0, 1}) {
      const Matrix6& P = by == 0 ? A : B;
      auto block = K.block<6, 6>(6 * end, 6 * by);
      block.topRightCorner<3, 3>() += position * side * P.bottomRightCorner<3, 3>();
      block.bottomLeftCorner<3, 3>() += position * side * P.topLeftCorner<3, 3>();
      block.bottomRightCorner<3, 3>() +=
          position * (side * P.topRightCorner<3, 3>() + turn * P.bottomRightCorner<3, 3>());
    }
  };
  add(0, -D, -E);
  add(1, skew(n) + D, skew(m) + E);
  return K;
}

BeamSpan::Vector12 BeamSpan::inertia_forces(const Vector6& d, const Vector6& v_A, const Vector6& v_B,
                                            const Vector6& rate_A, const Vector6& rate_B,
                                            const Vector3& gravity_A) const {
  Vector12 out = Vector12::Zero();
  const Vector12 v = both(v_A, v_B), rates = both(rate_A, rate_B);
  for (const double xi : kGauss) {
    const SpanField field(xi, d);
    const auto& N = field.shapes();
    Vector6 rate = N * rates + field.bias(v);
    rate.head<3>() -= field.pose().R.transpose() * gravity_A;
    out.noalias() += N.transpose() * (0.5 * length_ * rigid_piece::inertia_force(section_.mass, N * v, rate));
  }
  return out;
}

BeamSpan::Matrix12 BeamSpan::mass(const Vector6& d) const {
  Matrix12 M = Matrix12::Zero();
  for (const double xi : kGauss) {
    const SpanField field(xi, d);
    const auto& N = field.shapes();
    const SpanField::Matrix6x12 MN = (0.5 * length_) * (section_.mass * N);
    M.noalias() += N.transpose() * MN;
  }
  return M;
}

BeamSpan::Matrix12 BeamSpan::gyroscopic(const Vector6& d, const Vector6& v_A, const Vector6& v_B) const {
  Matrix12 G = Matrix12::Zero();
  if (v_A.isZero(0) && v_B.isZero(0)) return G;
  const Vector12 v = both(v_A, v_B);
  const Matrix6 turn_A = rigid_piece::rate_by_twist(v_A), turn_B = rigid_piece::rate_by_twist(v_B);
  for (const double xi : kGauss) {
    const SpanField field(xi, d);
    const auto& N = field.shapes();
    SpanField::Matrix6x12 rate = field.bias_rates(v);
    rate.leftCols<6>().noalias() += N.leftCols<6>() * turn_A;
    rate.rightCols<6>().noalias() += N.rightCols<6>() * turn_B;
    SpanField::Matrix6x12 force = section_.mass * rate;
    force.noalias() += rigid_piece::momentum_rates(section_.mass, N * v) * N;
    G.noalias() += (0.5 * length_) * (N.transpose() * force);
  }
  return G;
}

double BeamSpan::kinetic_energy(const Vector6& d, const Vector6& v_A, const Vector6& v_B) const {
  double energy = 0;
  for (const double xi : kGauss) {
    const Vector6 V = SpanField(xi, d).shapes() * both(v_A, v_B);
    energy += 0.25 * length_ * V.dot(section_.mass * V);
  }
  return energy;
}

Vector3 BeamSpan::first_moment(const Vector6& d) const {
  Vector3 sum = Vector3::Zero();
  for (const double xi : kGauss) {
    const auto h = se3::exp(xi * d);
    sum += 0.5 * length_ * section_.mass_per_length() * (h.p + h.R * section_.mass_center());
  }
  return sum;
}

}  // namespace lithe
