#include "engine/contact/joint_surfaces.h"

#include "engine/factor/block_products.h"
#include "engine/model/marker_motions.h"

namespace lithe {

JointSurfaces::JointSurfaces(Scene scene, std::vector<Surface> surfaces)
    : scene_(std::move(scene)), surfaces_(std::move(surfaces)) {
  for (const Surface& surface : surfaces_) directions_ += surface.count;
  unit_.setZero(scene_.compliant_rows);
}

void JointSurfaces::find_directions(MatrixX& D) {
  D.setZero(scene_.blocks.velocity_count, directions_);
  for (const Surface& surface : surfaces_)
    for (int k = 0; k < surface.count; ++k) {
      unit_[surface.row + k] = 1;
      add_row_forces(scene_.blocks, scene_.values, scene_.constraint_rows, nullptr, unit_.data(),
                     D.col(surface.first + k).data());
      unit_[surface.row + k] = 0;
    }
}

void JointSurfaces::start() {
  from_.resize(surfaces_.size());
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    from_[i].clear();
    for (const Marker& m : surfaces_[i].markers) from_[i].push_back(scene_.motion_of(m));
  }
}

void JointSurfaces::slid(VectorX& way) const {
  way.resize(directions_);
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    const Surface& surface = surfaces_[i];
    std::vector<MarkerView> from;
    for (const MarkerKinematics& k : from_[i]) from.emplace_back(k, static_cast<int>(from.size()));
    const Vector3 of = surface.friction->slid(from, MarkerMotions(surface.markers, scene_.motion_of));
    way.segment(surface.first, surface.count) = of.head(surface.count);
  }
}

void JointSurfaces::find_presses(const Surface& surface, std::vector<MatrixX>& by_lambda) const {
  // 1. The reaction by the joint's own multipliers: R = -Σ W λ.
  const MarkerMotions joint(surface.joint_markers, scene_.motion_of);
  ConstraintRows rows(static_cast<int>(joint.size()));
  rows.want_bias(false);
  rows.recall(surface.joint_turns);
  surface.joint->evaluate(scene_.time, joint, rows);
  Eigen::Matrix<double, 6, Eigen::Dynamic> R(6, rows.count());
  for (int j = 0; j < rows.count(); ++j) R.col(j) << -rows.wrench(j, 1).force, -rows.wrench(j, 1).torque;
  // 2. What of it presses.
  SetValuedFriction::Press P[SetValuedFriction::kMostPresses];
  const int count = surface.friction->presses(MarkerMotions(surface.markers, scene_.motion_of), P);
  by_lambda.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) by_lambda[i] = P[i] * R;
}

}  // namespace lithe
