#include "engine/contact/joint_surfaces.h"

namespace lithe {

JointSurfaces::JointSurfaces(Scene scene, std::vector<Surface> surfaces)
    : scene_(std::move(scene)), surfaces_(std::move(surfaces)) {
  const BlockStructure& blocks = scene_.blocks;
  for (const Surface& surface : surfaces_) {
    directions_ += surface.count;
    std::vector<Entry>& entries = D_.emplace_back();
    for (const auto& G : blocks.jacobians) {
      const auto& rows = blocks.rows[G.rows];
      const int row = scene_.constraint_rows + surface.row - rows.first;
      if (row < 0 || row >= rows.count) continue;
      const auto add = [&](int values, int velocity, int count) {
        for (int k = 0; k < count; ++k)
          entries.push_back({velocity + k, values + row + rows.count * k, Vector3::Zero()});
      };
      if (G.frame >= 0) add(G.values, G.velocity, 6);
      if (G.linear >= 0) add(G.linear_values, blocks.linears[G.linear].v, blocks.linears[G.linear].size);
    }
  }
}

void JointSurfaces::find_directions() {
  for (std::size_t i = 0; i < D_.size(); ++i)
    for (Entry& entry : D_[i])
      for (int k = 0; k < surfaces_[i].count; ++k) entry.by[k] = scene_.values[entry.value + k];
}

void JointSurfaces::speeds(ConstVectorRef v, VectorX& s) const {
  s.setZero(directions_);
  for (std::size_t i = 0; i < D_.size(); ++i)
    for (const Entry& entry : D_[i])
      for (int k = 0; k < surfaces_[i].count; ++k) s[surfaces_[i].first + k] += entry.by[k] * v[entry.velocity];
}

void JointSurfaces::add_direction(int surface, int direction, VectorRef f) const {
  for (const Entry& entry : D_[static_cast<std::size_t>(surface)]) f[entry.velocity] += entry.by[direction];
}

void JointSurfaces::add_impulses(const VectorX& p, VectorRef f) const {
  for (std::size_t i = 0; i < D_.size(); ++i)
    for (const Entry& entry : D_[i])
      for (int k = 0; k < surfaces_[i].count; ++k) f[entry.velocity] += entry.by[k] * p[surfaces_[i].first + k];
}

void JointSurfaces::start() {
  from_.resize(surfaces_.size());
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    from_[i].clear();
    for (const Marker& m : surfaces_[i].markers) from_[i].push_back(scene_.motion_of(m));
  }
}

void JointSurfaces::slid(VectorX& way) {
  way.resize(directions_);
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    const Surface& surface = surfaces_[i];
    from_views_.clear();
    for (const MarkerKinematics& k : from_[i]) from_views_.emplace_back(k, static_cast<int>(from_views_.size()));
    motions_.gather(surface.markers, scene_.motion_of);
    const Vector3 of = surface.friction->slid(from_views_, motions_);
    way.segment(surface.first, surface.count) = of.head(surface.count);
  }
}

void JointSurfaces::find_presses(const Surface& surface, std::vector<Matrix3X>& by_lambda) {
  // 1. The reaction by the joint's own multipliers: R = -Σ W λ.
  joint_motions_.gather(surface.joint_markers, scene_.motion_of);
  ConstraintRows rows(static_cast<int>(joint_motions_.size()));
  rows.want_bias(false);
  rows.recall(surface.joint_turns);
  surface.joint->evaluate(scene_.time, joint_motions_, rows);
  Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxRows> R(6, rows.count());
  for (int j = 0; j < rows.count(); ++j) R.col(j) << -rows.wrench(j, 1).force, -rows.wrench(j, 1).torque;
  // 2. What of it presses.
  FrictionByImpulses::Press P[FrictionByImpulses::kMostPresses];
  motions_.gather(surface.markers, scene_.motion_of);
  const int count = surface.friction->presses(motions_, P);
  by_lambda.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) by_lambda[i].noalias() = P[i] * R;
}

}  // namespace lithe
