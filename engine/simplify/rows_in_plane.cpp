#include "engine/simplify/rows_in_plane.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "engine/assembly/batch_of.h"

namespace lithe {
namespace {

/// A constraint's rows in one pose: what they do to the planar motions, each scaled by the root of its inertia, and the
/// compliance g M⁻¹ gᵀ of the same rows on free bodies, on which that is judged.
struct Look {
  MatrixX rows;  // three columns a body
  VectorX compliance;
};

Look look(const Constraint& constraint, const std::vector<MarkerInPlane>& markers, int pose) {
  const int n = static_cast<int>(markers.size());
  std::map<int, int> column;
  for (const auto& m : markers)
    if (m.body >= 0) column.try_emplace(m.body, 3 * static_cast<int>(column.size()));
  double reach = 0;
  for (const auto& m : markers) reach = std::max(reach, (m.pose.position - markers[0].pose.position).norm());
  if (reach == 0) reach = 1;

  // 1. Bodies move anyhow, within their planes: the joint need not be closed.
  std::vector<MarkerKinematics> moved(n);
  std::vector<Vector3> center(n);
  for (int i = 0; i < n; ++i) {
    const MarkerInPlane& m = markers[i];
    Matrix3 turn = Matrix3::Identity();
    Vector3 shift = Vector3::Zero();
    if (m.body >= 0 && pose > 0) {
      const double seed = 1 + 2.4 * (m.body + 17 * pose);
      turn = rotation_about(m.plane.col(2), 0.4 * std::sin(seed));
      shift = 0.2 * reach * (std::sin(2 * seed) * m.plane.col(0) + std::cos(3 * seed) * m.plane.col(1));
    }
    center[i] = m.center + shift;
    moved[i].p = center[i] + turn * (m.pose.position - m.center);
    if (m.body < 0) moved[i].p = m.pose.position;
    moved[i].R = turn * m.pose.axes;
    moved[i].v = moved[i].w = moved[i].bias_v = moved[i].bias_w = Vector3::Zero();
  }
  ConstraintRows rows(n);
  constraint.evaluate(0, connector::Views(moved.data(), n), rows);

  // 2. Force and moment of each row on each body.
  Look seen{MatrixX::Zero(rows.count(), 3 * static_cast<int>(column.size())), VectorX::Zero(rows.count())};
  for (int r = 0; r < rows.count(); ++r) {
    std::map<int, Wrench> on;
    for (int i = 0; i < n; ++i) {
      if (markers[i].body < 0) continue;
      const Wrench& w = rows.wrench(r, i);
      const Wrench about{w.force, w.torque + (moved[i].p - center[i]).cross(w.force)};
      const auto [at, fresh] = on.try_emplace(markers[i].body, about);
      if (!fresh) at->second = at->second + about;
    }
    for (int i = 0; i < n; ++i) {
      const MarkerInPlane& m = markers[i];
      if (m.body < 0 || !on.contains(m.body)) continue;
      const auto [force, torque] = on.at(m.body);
      on.erase(m.body);
      const Vector3 normal = m.plane.col(2);
      const double root_mass = std::sqrt(m.inertia.mass);
      // Inertia as it was: a scale.
      seen.rows.block<1, 3>(r, column[m.body]) << m.plane.col(0).dot(force) / root_mass,
          m.plane.col(1).dot(force) / root_mass, normal.dot(torque) / std::sqrt(normal.dot(m.inertia.inertia * normal));
      seen.compliance[r] += force.squaredNorm() / m.inertia.mass + torque.dot(m.inertia.inertia.inverse() * torque);
    }
  }
  return seen;
}

/// Takes what the kept rows span out of all rows; returns what is left of each, over its compliance.
VectorX remainder(Look& seen, int kept) {
  const Eigen::RowVectorXd unit = seen.rows.row(kept).normalized();
  seen.rows -= (seen.rows * unit.transpose()).eval() * unit;
  return seen.rows.rowwise().squaredNorm();
}

}  // namespace

std::vector<int> rows_in_plane(const Constraint& constraint, const std::vector<MarkerInPlane>& markers) {
  constexpr double kDependent = 1e-14;  // squared sine of the angle to the other rows
  constexpr int kPoses = 4;
  std::vector<int> kept;
  for (int pose = 0; pose < kPoses; ++pose) {
    Look seen = look(constraint, markers, pose);
    if (!seen.compliance.allFinite()) {  // a joint of a plug-in that wants another pose: no row is known to be idle
      kept.resize(seen.compliance.size());
      std::iota(kept.begin(), kept.end(), 0);
      return kept;
    }
    VectorX left = seen.rows.rowwise().squaredNorm();
    for (int r : kept) left = remainder(seen, r);
    while (true) {
      int best = 0;
      double largest = 0;
      for (int r = 0; r < left.size(); ++r) {
        const double ratio = seen.compliance[r] > 0 ? left[r] / seen.compliance[r] : 0;
        if (ratio > largest * (1 + 1e-6)) best = r, largest = ratio;
      }
      if (!(largest > kDependent)) break;
      kept.push_back(best);
      left = remainder(seen, best);
    }
  }
  std::sort(kept.begin(), kept.end());
  return kept;
}

}  // namespace lithe
