#include <algorithm>
#include <cmath>

#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/inertia_integrals.h"
#include "bodies/flexible/node_sets.h"
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

VectorX FlexibleBody::candidate_forces(const BodyState& state, const double* v_dot, std::span<const MarkerLoad> loads,
                                       const Vector3& gravity) const {
  if (!has_candidates()) return {};
  const ModalBasis& whole = *drawn_.basis;
  const bool second_order = fidelity_.deflection != Deflection::linear && !fidelity_.modes.empty() && whole.deflection;
  // 1. On the displacement fields: the candidates', and those of the second order.
  const InertiaIntegrals inertia = second_order               ? whole.deflection->integrals
                                   : whole.integrals.mass > 0 ? whole.integrals
                                                              : inertia_integrals(whole);
  const Matrix3& A = state.cache->A;
  const Vector3 omega(state.v[3], state.v[4], state.v[5]), turning(v_dot[3], v_dot[4], v_dot[5]);
  const Vector3 falling = A.transpose() * (gravity - Vector3(v_dot[0], v_dot[1], v_dot[2]));
  VectorX forces = inertia.Ct.transpose() * falling - inertia.C0.transpose() * turning;
  Vector6 squares;  // of ω, as the inertias are packed: ½ ωᵀ ∂J/∂η ω
  squares << 0.5 * omega.cwiseAbs2(), omega.x() * omega.y(), omega.x() * omega.z(), omega.y() * omega.z();
  forces += inertia.J1.transpose() * squares;
  for (const MarkerLoad& load : loads) {
    const auto& [nodes, weights] = markers_[static_cast<size_t>(load.marker)].nodes;
    if (nodes.empty()) continue;  // on the frame, or modal
    const Vector3 force = A.transpose() * load.force, torque = A.transpose() * load.torque;
    if (nodes.size() == 1) {
      forces += whole.node_modes(nodes[0], second_order).transpose() * force;
      if (const Matrix3X turns = whole.node_rotation_modes(nodes[0], second_order); turns.cols() > 0)
        forces += turns.transpose() * torque;
      continue;
    }
    const NodeAverage mean(whole.nodes, nodes, weights, name());
    const Vector3 spread = mean.spread_inverse * torque;
    for (size_t i = 0; i < nodes.size(); ++i) {
      const auto column = static_cast<Eigen::Index>(i);
      forces += whole.node_modes(nodes[i], second_order).transpose() *
                (mean.weights[column] * (force + spread.cross(mean.arms.col(column))));
    }
  }
  if (!second_order) return forces;
  // 2. On the modes: a mode moves the fields by ∂ξ/∂η_j = e_j + Σ_k η_k C_jk.
  const int candidates = whole.mode_count();
  const VectorX pairs = whole.deflection->curvature.transpose() * forces;
  VectorX out = forces.head(candidates);
  for (int j = 0; j < candidates; ++j)
    for (size_t i = 0; i < fidelity_.modes.size(); ++i) {
      const int low = std::min(j, fidelity_.modes[i]), high = std::max(j, fidelity_.modes[i]);
      out[j] += state.q[7 + i] * pairs[high * (high + 1) / 2 + low];
    }
  return out;
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
