#include <algorithm>
#include <cmath>

#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/selected_basis.h"
#include "engine/base/error.h"

namespace lithe {

VectorX FlexibleBody::candidate_stiffness() const {
  return has_candidates() ? VectorX(drawn_.basis->stiffness.diagonal()) : VectorX();
}

VectorX FlexibleBody::candidate_damping() const {
  const VectorX stiffness = candidate_stiffness();
  const FlexibleDamping& d = drawn_.damping;
  VectorX damping = d.mass_proportional * VectorX::Ones(stiffness.size()) + d.stiffness_proportional * stiffness;
  if (has_candidates() && drawn_.basis->damping.size() > 0) damping += drawn_.basis->damping.diagonal();
  for (Eigen::Index k = 0; k < stiffness.size() && !d.modal_ratios.empty(); ++k) {
    const auto given = std::min(static_cast<size_t>(k), d.modal_ratios.size() - 1);
    damping[k] += 2 * d.modal_ratios[given] * std::sqrt(stiffness[k]);
  }
  return damping;
}

VectorX FlexibleBody::candidate_reach() const {
  if (!has_candidates()) return {};
  const ModalBasis& basis = *drawn_.basis;
  VectorX reach(basis.mode_count());
  for (Eigen::Index k = 0; k < reach.size(); ++k)
    reach[k] = Eigen::Map<const Matrix3X>(basis.modes.col(k).data(), 3, basis.nodes.cols()).colwise().norm().maxCoeff();
  return reach;
}

Deflection FlexibleBody::finest_deflection() const {
  const auto& deflection = drawn_.basis->deflection;
  if (!deflection) return Deflection::linear;
  return deflection->quartic.size() > 0 ? Deflection::quadratic : Deflection::stiffened;
}

void FlexibleBody::set_fidelity(Fidelity fidelity) {
  if (!has_candidates())
    throw SceneError("body '" + name() + "' has one model only", where(),
                     "give it a basis of eigenmodes: make_basis() with a mode count");
  const std::vector<int>& modes = fidelity.modes;
  if (!modes.empty() && modes.back() >= modal_columns_)
    throw SceneError("a modal marker on '" + name() + "' has columns of " + std::to_string(modal_columns_) +
                         " modes, and mode " + std::to_string(modes.back()) + " was selected",
                     where(), "draw the body with all modes of its basis, and give the marker a column of each");
  SelectedBasis part = selected(*drawn_.basis, fidelity);
  Parameters chosen = drawn_;
  chosen.basis = std::move(part.basis);
  chosen.mode_count = kAll;
  const auto of_modes = [&](const VectorX& drawn) {  // those drawn may be of the leading modes alone
    VectorX all = VectorX::Zero(drawn_.basis->mode_count());
    all.head(drawn.size()) = drawn;
    return VectorX(all(modes));
  };
  chosen.modal_coordinates = of_modes(drawn_.modal_coordinates);
  chosen.modal_velocities = of_modes(drawn_.modal_velocities);
  auto& ratios = chosen.damping.modal_ratios;
  if (ratios.size() > 1) {
    ratios.clear();
    for (int k : modes)
      ratios.push_back(
          drawn_.damping.modal_ratios[std::min(static_cast<size_t>(k), drawn_.damping.modal_ratios.size() - 1)]);
  }
  parameters_ = std::move(chosen);
  fields_ = std::move(part.fields);
  fidelity_ = std::move(fidelity);
  deflection_.reset();
  build();
  for (size_t i = 0; i < markers_.size(); ++i) markers_[i] = recipes_[i]();
}

}  // namespace lithe
