#include "bodies/beam/beam_element.h"

#include <algorithm>
#include <numbers>

#include "bodies/beam/se3_internal.h"
#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

namespace {

Vector6 relative_log(const MarkerView& A, const MarkerView& B) { return se3::log_between(A.p, A.R, B.p, B.R); }

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

/// log' = T⁻¹ (twist of B) - T(-log)⁻¹ (twist of A), each twist in the axes of its marker, T⁻¹ = [M, N; 0, M].
void BeamElement::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const auto &A = markers[0], &B = markers[1];
  const Vector6 xi = relative_log(A, B);
  const auto [M, N] = se3::blocks(se3::right_inverse_at(xi), xi);
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
  const auto [edge_2, edge_3] = section_.edges(0.01 * length_);
  const Vector3 center = section_.mass_center();
  const double middle = (marker == 0 ? 0.25 : -0.25) * length_;
  return {visual::box({0.5 * length_, edge_2, edge_3}).at(Vector3(middle, center[1], center[2]))};
}

template std::unique_ptr<ForceBatch> make_force_batch<BeamElement>();

}  // namespace lithe
