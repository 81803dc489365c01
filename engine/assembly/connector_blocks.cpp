#include "engine/assembly/connector_blocks.h"

#include <algorithm>

#include "engine/assembly/batch_of.h"
#include "engine/assembly/connector_outer.h"

namespace lithe::connector {
namespace {

using Frame = Eigen::Map<Matrix6>;

/// rows: 3, of a 6 x n elastic Jacobian (0: translation, 3: rotation).
auto elastic(const MarkerKinematics& k, const MarkerSlot& slot, int rows) {
  return Eigen::Map<const Matrix6X>(k.elastic, 6, slot.size).middleRows<3>(rows);
}

/// Couplings are sorted by (a, b), a < b.
const BlockStructure::Coupling* find_coupling(const BlockStructure& blocks, int a, int b) {
  const std::pair<int, int> key(std::min(a, b), std::max(a, b));
  const auto at = std::lower_bound(blocks.couplings.begin(), blocks.couplings.end(), key,
                                   [](const auto& c, const auto& k) { return std::pair<int, int>(c.a, c.b) < k; });
  return at != blocks.couplings.end() && std::pair<int, int>(at->a, at->b) == key ? &*at : nullptr;
}

/// The block of S at two frames; null: they have none.
double* find_block(Workspace& work, const BlockStructure& blocks, int row, int column) {
  if (row == column) return work.values.data() + blocks.frames[row].values;
  const auto* c = find_coupling(blocks, row, column);
  return c ? work.values.data() + (c->a == row ? c->ab : c->ba) : nullptr;
}

void add_load_stiffness_between(Workspace& work, const BlockStructure& blocks, const MarkerSlot& slot,
                                const MarkerBetween& between, const Vector3& force, const Vector3& torque) {
  Eigen::Matrix<double, 12, 12> K = Eigen::Matrix<double, 12, 12>::Zero();
  between.add_load_stiffness(force, torque, K);
  const int first = slot.frame - between.shares[slot.share].frame;  // the body's
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      if (double* to = find_block(work, blocks, first + between.shares[i].frame, first + between.shares[j].frame))
        Frame{to} += K.block<6, 6>(6 * i, 6 * j);
}

/// J of one slot, 6 x 6: (v, w) of its marker by the velocities of its frame.
Matrix6 jacobian(const MarkerKinematics& k, const MarkerSlot& slot) {
  if (slot.share >= 0) return k.between->shares[slot.share].J;
  Matrix6 J = Matrix6::Identity();
  J.topRightCorner<3, 3>() = -*k.A * skew(k.r);
  J.bottomRightCorner<3, 3>() = *k.A;
  return J;
}

/// Jᵀ w of it.
Vector6 on_frame(const MarkerKinematics& k, const MarkerSlot& slot, const Wrench& w) {
  Vector6 load;
  if (slot.share >= 0) {
    const Matrix6& J = k.between->shares[slot.share].J;
    load = J.topRows<3>().transpose() * w.force + J.bottomRows<3>().transpose() * w.torque;
  } else {
    load << w.force, k.r.cross(k.A->transpose() * w.force) + k.A->transpose() * w.torque;
  }
  return load;
}

}  // namespace

bool couples(const Constraint& constraint, const std::vector<MarkerKinematics>& markers) {
  const int n = static_cast<int>(markers.size());
  if (n > kMaxMarkers) return false;  // its stiffness under load is left out
  ConstraintRows rows(n);
  ConstraintRows::Stiffness K = ConstraintRows::Stiffness::Zero(6 * n, 6 * n);
  double multipliers[kMaxRows];
  for (int r = 0; r < kMaxRows; ++r) multipliers[r] = 1 + 0.37 * r;  // no accidental cancellation
  rows.collect_stiffness(multipliers, &K);
  constraint.evaluate(0, Views(markers.data(), n), rows);
  if (rows.written()) return true;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      if (i != j && !K.block<6, 6>(6 * i, 6 * j).isZero(0)) return true;
  return false;
}

void add_wrench(const Workspace& work, const MarkerSlot& slot, const Wrench& w, double* r) {
  if (slot.velocity < 0) return;
  const MarkerKinematics& k = work.markers[slot.marker];
  double* to = r + slot.velocity;
  if (slot.share >= 0) {
    const Matrix6& J = k.between->shares[slot.share].J;
    Eigen::Map<Vector6>(to) += J.topRows<3>().transpose() * w.force + J.bottomRows<3>().transpose() * w.torque;
    return;
  }
  const Vector3 f = k.A->transpose() * w.force, t = k.A->transpose() * w.torque;
  if (slot.frame >= 0) {
    Eigen::Map<Vector3>(to) += w.force;
    Eigen::Map<Vector3>(to + 3) += k.r.cross(f) + t;
  }
  if (slot.linear >= 0)
    Eigen::Map<VectorX>(r + slot.eta, slot.size) +=
        elastic(k, slot, 0).transpose().lazyProduct(f) + elastic(k, slot, 3).transpose().lazyProduct(t);
}

void add_load_stiffness(Workspace& work, const BlockStructure& blocks, const MarkerSlot& slot, const Wrench& w,
                        double weight) {
  const MarkerKinematics& k = work.markers[slot.marker];
  if (slot.share >= 0) {
    add_load_stiffness_between(work, blocks, slot, *k.between, weight * w.force, weight * w.torque);
    return;
  }
  if (slot.frame < 0) {
    if (slot.linear >= 0 && k.deflected)
      k.deflected->add_load_stiffness(weight * w.force, weight * w.torque,
                                      work.values.data() + blocks.linears[slot.linear].values);
    return;
  }
  const Vector3 force = weight * (k.A->transpose() * w.force), torque = weight * (k.A->transpose() * w.torque);
  // r~ f~ = f rᵀ - (r·f) E
  Matrix3 turning = force * k.r.transpose();
  turning.diagonal().array() -= k.r.dot(force);
  const Matrix3 t = skew(torque);
  if (!is_zero(torque)) turning += t;
  Frame(work.values.data() + blocks.frames[slot.frame].values).bottomRightCorner<3, 3>() += turning;
  if (slot.linear < 0) return;
  const Matrix3 f = skew(force);
  const auto& L = blocks.linears[slot.linear];
  const int at = 6 * L.size * (slot.frame - L.frame);
  Eigen::Map<Matrix6X>(work.values.data() + L.frame_linear + at, 6, L.size).bottomRows<3>() -=
      f.lazyProduct(elastic(k, slot, 0));
  auto lf = Eigen::Map<MatrixX>(work.values.data() + L.linear_frame + at, L.size, 6).rightCols<3>();
  lf += elastic(k, slot, 0).transpose().lazyProduct(f);
  lf += elastic(k, slot, 3).transpose().lazyProduct(t);
  if (k.deflected) k.deflected->add_load_stiffness(force, torque, work.values.data() + L.values);
}

void add_marker_stiffness(Workspace& work, const BlockStructure& blocks, const ConnectorRecord& record,
                          const ConstraintRows::Stiffness& K, double weight) {
  for (int i = 0; i < record.slot_count; ++i) {
    const MarkerSlot& si = record.slots[i];
    if (si.frame < 0) continue;
    const MarkerKinematics& ki = work.markers[si.marker];
    for (int j = 0; j < record.slot_count; ++j) {
      const MarkerSlot& sj = record.slots[j];
      if (sj.frame < 0) continue;
      const auto Kij = K.block<6, 6>(6 * si.place, 6 * sj.place);
      const bool turns_only = Kij.leftCols<3>().isZero(0) && Kij.topRows<3>().isZero(0);
      if (turns_only && Kij.bottomRightCorner<3, 3>().isZero(0)) continue;
      const MarkerKinematics& kj = work.markers[sj.marker];
      double* to = find_block(work, blocks, si.frame, sj.frame);
      if (!to) continue;
      if (si.share >= 0 || sj.share >= 0) {
        Frame(to) += weight * jacobian(ki, si).transpose() * Kij * jacobian(kj, sj);
        continue;
      }
      if (turns_only) {  // directions alone, as of hinges
        const Matrix3 turned = weight * Kij.bottomRightCorner<3, 3>() * *kj.A;
        Frame(to).bottomRightCorner<3, 3>() += ki.A->transpose() * turned;
        continue;
      }
      // K J_j, then J_iᵀ of it
      Matrix6 KJ;
      KJ.leftCols<3>() = Kij.leftCols<3>();
      KJ.rightCols<3>() = Kij.rightCols<3>() * *kj.A - Kij.leftCols<3>() * (*kj.A * skew(kj.r));
      Frame S(to);
      const Eigen::Matrix<double, 3, 6> body_force = ki.A->transpose() * KJ.topRows<3>();
      S.topRows<3>() += weight * KJ.topRows<3>();
      S.bottomRows<3>() += weight * (skew(ki.r) * body_force + ki.A->transpose() * KJ.bottomRows<3>());
    }
  }
}

void add_outer(Workspace& work, const BlockStructure& blocks, std::span<const MarkerSlot> on, const Wrench& w,
               std::span<const MarkerSlot> from, const Wrench& by) {
  for (const MarkerSlot& si : on) {
    if (si.frame < 0) continue;
    const Vector6 load = on_frame(work.markers[si.marker], si, w);
    for (const MarkerSlot& sj : from) {
      if (sj.frame < 0) continue;
      if (double* to = find_block(work, blocks, si.frame, sj.frame))
        Frame(to) += load * on_frame(work.markers[sj.marker], sj, by).transpose();
    }
  }
}

}  // namespace lithe::connector
