#pragma once

#include "engine/assembly/batch.h"

/// From wrenches at markers to the blocks of G and S: the one place where J of a marker is written out.
namespace lithe::connector {

inline bool is_zero(const Vector3& a) { return a[0] == 0 && a[1] == 0 && a[2] == 0; }

/// The same of a marker between two frames, for one of them.
template <class WrenchOf>
inline void write_share(double* to, const Matrix6& J, int rows, bool first, WrenchOf&& wrench) {
  for (int row = 0; row < rows; ++row) {
    const Wrench& w = wrench(row);
    for (int i = 0; i < 6; ++i) {
      const double value = w.force.dot(J.col(i).head<3>()) + w.torque.dot(J.col(i).tail<3>());
      if (first)
        to[row + rows * i] = value;
      else
        to[row + rows * i] += value;
    }
  }
}

/// to = value, or to += value.
template <bool First>
inline void put(double& to, double value) {
  to = First ? value : to + value;
}

/// Rows 0 to 2 of `rows` of a marker in one frame, where they hold a point: unit forces of this sign. `along`: those
/// forces in body axes, a column each.
template <bool First>
inline void write_point_frame(double* frame, int rows, double sign, const Vector3& r, const Matrix3& along) {
  for (int row = 0; row < 3; ++row) {
    const Vector3 turn = r.cross(along.col(row));
    for (int i = 0; i < 3; ++i) {
      put<First>(frame[row + rows * i], i == row ? sign : 0);
      put<First>(frame[row + rows * (3 + i)], turn[i]);
    }
  }
}
template <bool First>
inline void write_point_linear(double* linear, int rows, int size, const double* E, const Matrix3& along) {
  for (int i = 0; i < size; ++i, E += 6)
    for (int row = 0; row < 3; ++row)
      put<First>(linear[row + rows * i], E[0] * along(0, row) + E[1] * along(1, row) + E[2] * along(2, row));
}
inline void write_point_jacobian(Workspace& work, const BlockStructure& blocks, const MarkerSlot& slot, int rows,
                                 double sign) {
  if (slot.jacobian < 0) return;
  const MarkerKinematics& k = work.markers[slot.marker];
  const auto& G = blocks.jacobians[slot.jacobian];
  double *frame = work.values.data() + G.values, *linear = work.values.data() + G.linear_values;
  const Matrix3 along = sign * k.A->transpose();
  if (G.frame >= 0)
    slot.first_frame ? write_point_frame<true>(frame, rows, sign, k.r, along)
                     : write_point_frame<false>(frame, rows, sign, k.r, along);
  if (slot.linear >= 0)
    slot.first_linear ? write_point_linear<true>(linear, rows, slot.size, k.elastic, along)
                      : write_point_linear<false>(linear, rows, slot.size, k.elastic, along);
}

/// Writes or adds W_m J_m of one marker: rows x 6 of the frame and rows x n of the linear coordinates. Those before
/// `first` are written already.
template <int Rows, class WrenchOf>
inline void write_jacobian(Workspace& work, const BlockStructure& blocks, const MarkerSlot& slot, int first,
                           int row_count, WrenchOf&& wrench) {
  if (slot.jacobian < 0) return;
  const int R = Rows > 0 ? Rows : row_count;
  const MarkerKinematics& k = work.markers[slot.marker];
  const auto& G = blocks.jacobians[slot.jacobian];
  if (slot.share >= 0) [[unlikely]] {
    write_share(work.values.data() + G.values, k.between->shares[slot.share].J, R, slot.first_frame, wrench);
    return;
  }
  const Matrix3& A = *k.A;
  double* frame = G.frame >= 0 ? work.values.data() + G.values : nullptr;
  double* linear = slot.linear >= 0 ? work.values.data() + G.linear_values : nullptr;
  for (int row = first; row < R; ++row) {
    const Wrench& w = wrench(row);
    const bool pulls = !is_zero(w.force), twists = !is_zero(w.torque);  // a row is seldom both
    if (!pulls && !twists && !slot.first_frame && !slot.first_linear) continue;
    Vector3 f = Vector3::Zero(), t = Vector3::Zero(), turn = Vector3::Zero();
    if (pulls) f.noalias() = A.transpose() * w.force, turn = k.r.cross(f);
    if (twists) t.noalias() = A.transpose() * w.torque, turn += t;
    if (frame) {
      if (slot.first_frame)
        for (int i = 0; i < 3; ++i) frame[row + R * i] = w.force[i], frame[row + R * (3 + i)] = turn[i];
      else
        for (int i = 0; i < 3; ++i) frame[row + R * i] += w.force[i], frame[row + R * (3 + i)] += turn[i];
    }
    if (linear) {
      const double* E = k.elastic;
      for (int i = 0; i < slot.size; ++i, E += 6) {
        const double value = E[0] * f[0] + E[1] * f[1] + E[2] * f[2] + E[3] * t[0] + E[4] * t[1] + E[5] * t[2];
        if (slot.first_linear)
          linear[row + R * i] = value;
        else
          linear[row + R * i] += value;
      }
    }
  }
}

/// Whether the load of a joint on one body depends on where the other is.
bool couples(const Constraint& constraint, const std::vector<MarkerKinematics>& markers);
/// r += Jᵀ w of one marker.
void add_wrench(const Workspace& work, const MarkerSlot& slot, const Wrench& w, double* r);
/// Adds weight · ∂(Jᵀ w)/∂q, w fixed in world axes, to the body's own blocks.
void add_load_stiffness(Workspace& work, const BlockStructure& blocks, const MarkerSlot& slot, const Wrench& w,
                        double weight);
/// Adds weight · Jᵢᵀ K J_j for all pairs of markers: K = ∂w/∂(marker motions), to frames and their couplings.
void add_marker_stiffness(Workspace& work, const BlockStructure& blocks, const ConnectorRecord& record,
                          const ConstraintRows::Stiffness& K, double weight);

/// ∂w/∂(marker motions) by central differences (Level::position), or ∂w/∂(marker velocities); `wrenches(markers, w)`
/// fills one wrench a marker.
template <class WrenchesOf>
void difference(const Workspace& work, const ConnectorRecord& record, Level by, WrenchesOf&& wrenches,
                ConstraintRows::Stiffness& K) {
  MarkerKinematics moved[kMaxMarkers];
  const int n = record.marker_count;
  for (int m = 0; m < n; ++m) moved[m] = work.markers[record.slots[m].marker];
  Wrench plus[kMaxMarkers], minus[kMaxMarkers];
  double reach = 0;
  for (int m = 1; m < n; ++m) reach = std::max(reach, (moved[m].p - moved[0].p).norm());
  const double turn = 1e-5, shift = 1e-5 * (reach > 0 ? reach : 1);
  for (int m = 0; m < n; ++m)
    for (int a = 0; a < 6; ++a) {
      const MarkerKinematics kept = moved[m];
      const double step = a < 3 ? shift : turn;
      const auto displaced = [&](double d, Wrench* out) {
        if (by == Level::velocity)
          (a < 3 ? moved[m].v[a] : moved[m].w[a - 3]) += d;
        else if (a < 3)
          moved[m].p[a] = kept.p[a] + d;
        else
          moved[m].R = rotation_exp(d * Vector3::Unit(a - 3)) * kept.R;
        wrenches(moved, out);
        moved[m] = kept;
      };
      displaced(step, plus);
      displaced(-step, minus);
      for (int i = 0; i < n; ++i) {
        K.block<3, 1>(6 * i, 6 * m + a) += (plus[i].force - minus[i].force) / (2 * step);
        K.block<3, 1>(6 * i + 3, 6 * m + a) += (plus[i].torque - minus[i].torque) / (2 * step);
      }
    }
}

}  // namespace lithe::connector
