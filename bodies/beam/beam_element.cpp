#include "bodies/beam/beam_element.h"

#include <algorithm>
#include <numbers>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

namespace {

/// dk/dt of chart_coefficient(t).
double chart_coefficient_rate(double t) {
  if (t < 0.5) {  // the series of chart_coefficient(), differentiated
    constexpr double c2 = 1.0 / 720, c3 = 2.0 / 30240, c4 = 3.0 / 1209600, c5 = 4.0 / 47900160,
                     c6 = 5 * 691.0 / 1307674368000, c7 = 6.0 / 74724249600, c8 = 7 * 3617.0 / 10670622842880000;
    return c2 + t * (c3 + t * (c4 + t * (c5 + t * (c6 + t * (c7 + t * c8)))));
  }
  const double half = std::sqrt(t) / 2, sine = std::sin(half), cosine = std::cos(half);
  // k = (1 - x cot x)/t, x = sqrt(t)/2
  return ((half / sine - cosine) / (sine * 8 * half) - chart_coefficient(t)) / t;
}

/// log(H_A⁻¹ H_B) = (u, phi) in SE(3): u = Jl⁻¹(phi) R_Aᵀ d.
Vector6 relative_log(const MarkerView& A, const MarkerView& B) {
  const Vector3 phi = rotation_log(A.R.transpose() * B.R), d = A.R.transpose() * (B.p - A.p);
  const Vector3 turned = phi.cross(d);
  Vector6 xi;
  xi << d - 0.5 * turned + chart_coefficient(phi.squaredNorm()) * phi.cross(turned), phi;
  return xi;
}

}  // namespace

BeamElement::BeamElement(Parameters parameters) : section_(parameters.section), length_(parameters.length) {
  require::not_negative(length_, "length");
  section_.check("the section");
  // C = Uᵀ D U, without square roots
  Matrix6 rest = section_.stiffness;
  rows_.setIdentity();
  for (int i = 0; i < 6; ++i) {
    stiffness_[i] = rest(i, i);
    for (int j = i + 1; j < 6; ++j) rows_(i, j) = rest(i, j) / rest(i, i);
    for (int k = i + 1; k < 6; ++k)
      for (int j = k; j < 6; ++j) rest(k, j) -= stiffness_[i] * rows_(i, k) * rows_(i, j);
  }
}

/// With (u, phi) = log and k = chart_coefficient:
///   log' = Jr⁻¹ (twist of B) - Jl⁻¹ (twist of A), each twist in the axes of its marker,
///   Jr⁻¹ = [M, N; 0, M], Jl⁻¹ = [Mᵀ, Nᵀ; 0, Mᵀ],   M = E + ½ phi~ + k phi~²,
///   N = dM/dphi u = ½ u~ + k (u~ phi~ + phi~ u~) + 2 k' (phi·u) phi~²
void BeamElement::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const auto &A = markers[0], &B = markers[1];
  const Vector6 xi = relative_log(A, B);
  const Vector3 u = xi.head<3>(), phi = xi.tail<3>();
  const double t = phi.squaredNorm(), k = chart_coefficient(t), along = phi.dot(u);
  const double squares = 2 * chart_coefficient_rate(t) * along;
  // phi~² = phi phiᵀ - t E,  u~ phi~ + phi~ u~ = u phiᵀ + phi uᵀ - 2 (phi·u) E
  Matrix3 M = (k * phi) * phi.transpose();
  M.diagonal().array() += 1 - k * t;
  M += skew(0.5 * phi);
  Matrix3 N = (k * u + squares * phi) * phi.transpose() + phi * (k * u).transpose();
  N.diagonal().array() -= 2 * k * along + squares * t;
  N += skew(0.5 * u);
  // R_B Mᵀ = R_A M: the forces on A and B are opposite.
  const Matrix3 forces = A.R * M, moments_A = A.R * N, moments_B = B.R * N.transpose();
  const Vector6 stretch = rows_ * (xi - reference_);
  for (int i = 0; i < 6; ++i) {
    const Vector3 translation = rows_.row(i).head<3>(), rotation = rows_.row(i).tail<3>();
    const Vector3 F = forces * translation, T = forces * rotation;
    const Vector3 T_A = -(moments_A * translation) - T, T_B = moments_B * translation + T;
    const double stiffness = stiffness_[i] / length_, damping = stiffness * section_.damping[i];
    double tension = stiffness * stretch[i];
    if (damping > 0) tension += damping * (F.dot(B.v - A.v) + T_A.dot(A.w) + T_B.dot(B.w));
    rows.add({{-F, T_A}, {F, T_B}}, tension, stiffness, damping, 0.5 * stiffness * stretch[i] * stretch[i]);
  }
}

void BeamElement::initialize(std::span<const MarkerView> m) {
  reference_ = relative_log(m[0], m[1]);
  const double helix = reference_.head<3>().norm(), turn = reference_.tail<3>().norm();
  if (turn > std::numbers::pi / 2)
    throw SceneError("its ends are drawn " + std::to_string(turn * 180 / std::numbers::pi) + " degrees apart", "",
                     "take more elements: below 90 degrees each, below 20 for results of two digits");
  if (length_ == 0) length_ = helix;
  if (!(std::abs(helix - length_) <= 0.05 * length_ && helix > 0))
    throw SceneError("its length is " + std::to_string(length_) + " m and the curve between its markers has " +
                         std::to_string(helix) + " m",
                     "", "give the length along the axis from marker to marker, or take more elements");
  if (reference_[0] < 0.5 * helix)
    throw SceneError("axis 1 of its markers does not point from the first to the second", "",
                     "turn the markers so that axis 1 runs along the beam, or exchange them");
}

Vector6 BeamElement::strain(const MarkerView& A, const MarkerView& B) const {
  return (relative_log(A, B) - reference_) / length_;
}

std::vector<DrawnShape> BeamElement::drawn_shapes(int marker) const {
  const double mass = section_.mass_per_length(), thinnest = 0.01 * length_;
  const Vector3 center = section_.mass_center();
  const Matrix3 inertia = section_.mass.bottomRightCorner<3, 3>() + mass * skew(center) * skew(center);
  // Of a rectangle b2 by b3: b3² / 12 about axis 2, b2² / 12 about axis 3.
  const auto edge = [&](int about) {
    return std::max(thinnest, std::sqrt(12 * std::max(0.0, inertia(about, about)) / mass));
  };
  const double middle = (marker == 0 ? 0.25 : -0.25) * length_;
  return {visual::box({0.5 * length_, edge(2), edge(1)}).at(Vector3(middle, center[1], center[2]))};
}

template std::unique_ptr<ForceBatch> make_force_batch<BeamElement>();

}  // namespace lithe
