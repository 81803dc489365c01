#include "engine/assembly/held_blocks.h"

#include <algorithm>

#include "engine/contact/contact_forces.h"

namespace lithe {

bool HeldBlocks::hold(const std::vector<int>& velocities) {
  const auto find_linear = [&](int velocity) {
    return std::find_if(blocks_.linears.begin(), blocks_.linears.end(),
                        [&](const auto& L) { return velocity >= L.v && velocity < L.v + L.size; });
  };
  for (int velocity : velocities)
    if (find_linear(velocity) == blocks_.linears.end()) return false;
  velocities_ = velocities;
  jacobian_.clear(), couplings_.clear(), diagonals_.clear();
  for (int velocity : velocities) {
    const auto L = find_linear(velocity);
    const int k = velocity - L->v, linear = static_cast<int>(L - blocks_.linears.begin());
    for (int f = 0, at = 0; f < L->frames; ++f, at += 6 * L->size)
      for (int i = 0; i < 6; ++i) {
        couplings_.push_back(L->frame_linear + at + 6 * k + i);
        couplings_.push_back(L->linear_frame + at + k + L->size * i);
      }
    if (!L->pattern) diagonals_.push_back(L->values + k);
    for (int entry = 0; L->pattern && entry < L->pattern->rows.size(); ++entry) {
      const int row = L->pattern->rows[entry], column = L->pattern->columns[entry];
      if (row != k && column != k) continue;
      (row == column ? diagonals_ : couplings_).push_back(L->values + entry);
    }
    for (const auto& G : blocks_.jacobians) {
      if (G.linear != linear) continue;
      const int rows = blocks_.rows[G.rows].count;
      jacobian_.emplace_back(G.linear_values + rows * k, rows);
    }
  }
  release_from_joints();
  return true;
}

void HeldBlocks::release_from_joints() {
  for (const auto& [first, count] : jacobian_) std::fill_n(work_.values.data() + first, count, 0.0);
  if (contacts_) contacts_->release(velocities_);
}

void HeldBlocks::write_residual(ConstVectorRef v_dot, VectorRef r) const {
  for (int velocity : velocities_) r[velocity] = v_dot[velocity];
}

void HeldBlocks::write_tangent(double acceleration) const {
  for (int entry : couplings_) work_.values[entry] = 0;
  for (int entry : diagonals_) work_.values[entry] = acceleration;
}

}  // namespace lithe
