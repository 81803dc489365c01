#include "bodies/beam/beam_span.h"

#include <numbers>

#include "bodies/beam/node_mass_internal.h"
#include "bodies/beam/se3_internal.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

using Complex = std::complex<double>;
using Vector6c = se3::Vector6Of<Complex>;

constexpr double kGauss[] = {0.21132486540518711775, 0.78867513459481288225};  // weights ½
constexpr double kTiny = 1e-100;                                               // a complex step has no round-off

/// The twist at ξ by those of the ends.
template <class S>
class TwistField {
 public:
  using Vector = se3::Vector6Of<S>;
  TwistField(double xi, const Vector& d)
      : xi_(xi),
        d_(d),
        back_(-d),
        along_(S(xi) * d),
        k_(se3::k_of(se3::square<S>(d))),
        a_(se3::a_of(se3::square<S>(along_))),
        b_(se3::b_of(se3::square<S>(along_))),
        here_(se3::exp<S>(along_)) {}
  Vector operator()(const Vector& v_A, const Vector& v_B) const {
    const Vector d_dot = inverse(d_, v_B) - inverse(back_, v_A);
    return se3::carried<S>(here_, v_A) + xi_ * se3::apply<S>(-a_.value, -a_.rate, b_.value, b_.rate, along_, d_dot);
  }

 private:
  Vector inverse(const Vector& d, const Vector& x) const {
    return se3::apply<S>(S(0.5), S(0), k_.value, k_.rate, d, x);
  }
  const S xi_;
  const Vector d_, back_, along_;
  const se3::Coefficients<S> k_, a_, b_;
  const se3::Pose<S> here_;
};

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

/// T(d)⁻¹ of its blocks.
Matrix6 whole(const Matrix3& F, const Matrix3& G) {
  Matrix6 T;
  T << F, G, Matrix3::Zero(), F;
  return T;
}

}  // namespace

BeamSpan::BeamSpan(const BeamSection& section, double length, const Vector6& drawn)
    : section_(section),
      length_(length),
      drawn_(drawn),
      damping_(damping_of(section)),
      damped_(!section.damping.isZero(0)) {
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

Vector6 BeamSpan::strain_rate(const Vector6& d, const Vector6& v_A, const Vector6& v_B) const {
  const auto [F, G] = se3::inverse_blocks(d);
  Vector6 rate;
  rate << F * v_B.head<3>() + G * v_B.tail<3>() - F.transpose() * v_A.head<3>() - G.transpose() * v_A.tail<3>(),
      F * v_B.tail<3>() - F.transpose() * v_A.tail<3>();
  return rate / length_;
}

Vector6 BeamSpan::resultants(const Vector6& strain, const Vector6& strain_rate) const {
  if (!damped_) return section_.stiffness * strain;
  return section_.stiffness * strain + damping_ * strain_rate;
}

Vector6 BeamSpan::twist(double xi, const Vector6& d, const Vector6& v_A, const Vector6& v_B) const {
  return TwistField<double>(xi, d)(v_A, v_B);
}

BeamSpan::Motion BeamSpan::motion(double xi, const Vector6& d, const Vector6& v_A, const Vector6& v_B,
                                  const Vector6& rate_A, const Vector6& rate_B) const {
  const Vector6 d_dot = length_ * strain_rate(d, v_A, v_B);
  const auto step = [](const Vector6& value, const Vector6& rate) -> Vector6c {
    return value.cast<Complex>() + Complex(0, kTiny) * rate.cast<Complex>();
  };
  const Vector6c V = TwistField<Complex>(xi, step(d, d_dot))(step(v_A, rate_A), step(v_B, rate_B));
  return {V.real(), V.imag() / kTiny};
}

BeamSpan::Vector12 BeamSpan::at_ends(double xi, const Vector6& d, const Vector6& f) const {
  const Vector6 along = xi * d, stretch = xi * se3::right_transposed(along, f);
  Vector12 out;
  out << se3::carried_back(se3::exp<double>(along), f) - se3::right_inverse_transposed(-d, stretch),
      se3::right_inverse_transposed(d, stretch);
  return out;
}

Eigen::Matrix<double, 6, 12> BeamSpan::shapes(double xi, const Vector6& d) const {
  const TwistField<double> field(xi, d);
  Eigen::Matrix<double, 6, 12> N;
  for (int i = 0; i < 6; ++i) {
    N.col(i) = field(Vector6::Unit(i), Vector6::Zero());
    N.col(6 + i) = field(Vector6::Zero(), Vector6::Unit(i));
  }
  return N;
}

BeamSpan::Vector12 BeamSpan::internal_forces(const Vector6& d, const Vector6& sigma) const {
  const auto [F, G] = se3::inverse_blocks(d);
  const Vector3 n = sigma.head<3>(), m = sigma.tail<3>();
  Vector12 out;
  out << -(F * n), -(G * n + F * m), F.transpose() * n, G.transpose() * n + F.transpose() * m;
  return out;
}

BeamSpan::Matrix12 BeamSpan::tangent(const Vector6& d, const Vector6& sigma, double position, double velocity) const {
  const auto [F, G] = se3::inverse_blocks(d);
  const Matrix6 A = -whole(F.transpose(), G.transpose()), B = whole(F, G);
  Matrix6 C = (position / length_) * section_.stiffness;
  if (damped_) C += (velocity / length_) * damping_;
  const Matrix6 CA = C * A, CB = C * B;
  Matrix12 K;
  K.topLeftCorner<6, 6>().noalias() = A.transpose() * CA;
  K.topRightCorner<6, 6>().noalias() = A.transpose() * CB;
  K.bottomLeftCorner<6, 6>() = K.topRightCorner<6, 6>().transpose();
  K.bottomRightCorner<6, 6>().noalias() = B.transpose() * CB;
  if (position == 0) return K;
  // What the resultants do as the ends move: [0, D; D, E] at d, and [0, n~ - D; n~ - D, m~ - E] at -d.
  const auto [D, E] = se3::inverse_rates(d, sigma);
  const Matrix3 n = skew(Vector3(sigma.head<3>())), m = skew(Vector3(sigma.tail<3>()));
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
  add(0, n - D, m - E);
  add(1, D, E);
  return K;
}

BeamSpan::Vector12 BeamSpan::inertia_forces(const Vector6& d, const Vector6& v_A, const Vector6& v_B,
                                            const Vector6& rate_A, const Vector6& rate_B,
                                            const Vector3& gravity_A) const {
  Vector12 out = Vector12::Zero();
  for (const double xi : kGauss) {
    const Motion m = motion(xi, d, v_A, v_B, rate_A, rate_B);
    Vector6 rate = m.rate;
    rate.head<3>() -= se3::exp<double>(Vector6(xi * d)).R.transpose() * gravity_A;
    out += 0.5 * length_ * at_ends(xi, d, rigid_piece::inertia_force(section_.mass, m.twist, rate));
  }
  return out;
}

BeamSpan::Matrix12 BeamSpan::mass(const Vector6& d) const {
  Matrix12 M = Matrix12::Zero();
  for (const double xi : kGauss) {
    const auto N = shapes(xi, d);
    M += 0.5 * length_ * N.transpose() * section_.mass * N;
  }
  return M;
}

BeamSpan::Matrix12 BeamSpan::gyroscopic(const Vector6& d, const Vector6& v_A, const Vector6& v_B) const {
  Matrix12 G = Matrix12::Zero();
  if (v_A.isZero(0) && v_B.isZero(0)) return G;
  const auto rate = rigid_piece::rate_without_acceleration;
  const auto forces = [&](const Vector12& v) {
    const Vector6 a = v.head<6>(), b = v.tail<6>();
    return inertia_forces(d, a, b, rate(a), rate(b), Vector3::Zero());
  };
  Vector12 v;
  v << v_A, v_B;
  for (int i = 0; i < 12; ++i)  // quadratic in the twists: differences have no error but round-off
    G.col(i) = 0.5 * (forces(v + Vector12::Unit(i)) - forces(v - Vector12::Unit(i)));
  return G;
}

double BeamSpan::kinetic_energy(const Vector6& d, const Vector6& v_A, const Vector6& v_B) const {
  double energy = 0;
  for (const double xi : kGauss) {
    const Vector6 V = twist(xi, d, v_A, v_B);
    energy += 0.25 * length_ * V.dot(section_.mass * V);
  }
  return energy;
}

Vector3 BeamSpan::first_moment(const Vector6& d) const {
  Vector3 sum = Vector3::Zero();
  for (const double xi : kGauss) {
    const auto h = se3::exp<double>(Vector6(xi * d));
    sum += 0.5 * length_ * section_.mass_per_length() * (h.p + h.R * section_.mass_center());
  }
  return sum;
}

}  // namespace lithe
