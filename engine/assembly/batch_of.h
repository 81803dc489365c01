#pragma once

#include <array>

#include "engine/assembly/batch.h"
#include "engine/assembly/connector_blocks.h"
#include "engine/assembly/rigid_pairs.h"
#include "engine/model/element_error.h"
#include "engine/model/rigid_frame_body.h"

/// The loops over all elements of one type. Include this where a new type is first added to a graph.
namespace lithe {

/// Whether the tangent of a body type is that of a rigid body.
template <class T>
inline constexpr bool kRigidTangent = [] {
  if constexpr (std::is_base_of_v<RigidFrameBody, T>)
    return std::is_same_v<decltype(&T::add_tangent), decltype(&RigidFrameBody::add_tangent)>;
  return false;
}();

template <class T>
class BodyBatchOf final : public BodyBatch {
 public:
  using Cache = typename T::Cache;

  void add(const Body& body, BodyRecord record) override {
    bodies_.push_back(static_cast<const T*>(&body));
    records_.push_back(std::move(record));
  }

  std::unique_ptr<Caches> make_caches() const override {
    auto caches = std::make_unique<TypedCaches>();
    caches->all.reserve(bodies_.size());
    for (const T* body : bodies_) caches->all.emplace_back(*body);
    return caches;
  }

  void evaluate(Workspace& work, Caches& caches, BatchRange range, Level level, Level markers) const override {
    for_each_named(bodies_, range, work.time, [&](std::size_t i) {
      const BodyRecord& record = records_[i];
      if constexpr (requires(const T& body) { body.prefetch_markers(); }) {
        if (i + 8 < bodies_.size()) bodies_[i + 8]->prefetch(), bodies_[i + 4]->prefetch_markers();
      }
      const BodyState state = state_of(work, caches, i);
      bodies_[i]->T::evaluate(state, level);
      for (const auto& [marker, place] : record.markers)
        bodies_[i]->T::marker_kinematics(state, marker, markers, work.markers[place]);
    });
  }

  void evaluate_loaded(Workspace& work, Caches& caches, BatchRange range, Level level) const override {
    for_each_named(bodies_, range, work.time, [&](std::size_t i) {
      const BodyRecord& record = records_[i];
      if (record.loaded.empty()) return;
      const BodyState state = state_of(work, caches, i);
      bodies_[i]->T::evaluate(state, level);
      for (const auto& [marker, place] : record.loaded)
        bodies_[i]->T::marker_kinematics(state, marker, level, work.markers[place]);
    });
  }

  void add_residual(Workspace& work, Caches& caches, BatchRange range, const double* v_dot, double* r) const override {
    for_each_named(bodies_, range, work.time, [&](std::size_t i) {
      bodies_[i]->T::add_residual(state_of(work, caches, i), v_dot + records_[i].v, work.gravity, r + records_[i].v);
    });
  }

  void write_tangent(Workspace& work, Caches& caches, BatchRange range, const BlockStructure& blocks,
                     const double* v_dot, const TangentWeights& weights, const double* increment) const override {
    double* values = work.values.data();
    for_each_named(bodies_, range, work.time, [&](std::size_t i) {
      const BodyRecord& record = records_[i];
      if constexpr (kRigidTangent<T>) {
        const auto& [mass, inertia] = bodies_[i]->rigid_inertia();
        rigid_pairs::write_tangent(values + blocks.frames[record.frame].values, mass, inertia,
                                   work.v.data() + record.v + 3, weights,
                                   increment ? increment + record.v + 3 : nullptr);
        return;
      }
      double *frame = nullptr, *frame_linear = nullptr, *linear_frame = nullptr, *linear = nullptr;
      int size = 0, entries = 0;
      if (record.frame >= 0) frame = values + blocks.frames[record.frame].values;
      if (record.linear >= 0) {
        const auto& L = blocks.linears[record.linear];
        size = L.size;
        entries = L.pattern ? static_cast<int>(L.pattern->rows.size()) : size;
        frame_linear = values + L.frame_linear, linear_frame = values + L.linear_frame, linear = values + L.values;
      }
      BodyTangent S{Eigen::Map<Matrix6>(frame), Eigen::Map<Matrix6X>(frame_linear, 6, record.frame < 0 ? 0 : size),
                    Eigen::Map<MatrixX>(linear_frame, record.frame < 0 ? 0 : size, 6),
                    Eigen::Map<VectorX>(linear, entries)};
      const int coupled = 6 * size * record.frames;
      for (const auto& [at, count] : {std::pair(frame, 36), std::pair(frame_linear, coupled),
                                      std::pair(linear_frame, coupled), std::pair(linear, entries)})
        if (at) std::fill_n(at, count, 0.0);
      if (record.frames > 1) return write_frames(work, caches, v_dot, weights, increment, i, S);
      bodies_[i]->T::add_tangent(state_of(work, caches, i), v_dot + record.v, work.gravity, weights, S);
      if (!increment || record.frame < 0) return;
      // d_dot = Jr⁻¹ omega: corrections of the increment turn the state by Jr(psi)
      const Matrix3 chart = right_jacobian_inverse(Eigen::Map<const Vector3>(increment + record.v + 3));
      auto turning = S.frame.template rightCols<3>();
      turning = turning.lazyProduct(chart).eval();
      auto columns = S.linear_frame.template rightCols<3>();
      for (int k = 0; k < size; ++k) columns.row(k) = (columns.row(k) * chart).eval();
    });
  }

 private:
  /// The tangent of a body with several frames; the blocks of their pairs are zero so far.
  void write_frames(Workspace& work, Caches& caches, const double* v_dot, const TangentWeights& weights,
                    const double* increment, std::size_t i, BodyTangent& S) const {
    const BodyRecord& record = records_[i];
    std::fill_n(S.frame.data() + 36, 36 * (record.frames - 1), 0.0);
    S.values = work.values.data();
    S.pairs = record.pairs;
    bodies_[i]->T::add_tangent(state_of(work, caches, i), v_dot + record.v, work.gravity, weights, S);
    if (!increment) return;
    const auto turn = [&](Eigen::Map<Matrix6> block, int frame) {
      const Matrix3 chart = right_jacobian_inverse(Eigen::Map<const Vector3>(increment + record.v + 6 * frame + 3));
      auto columns = block.template rightCols<3>();
      columns = columns.lazyProduct(chart).eval();
    };
    const auto turn_columns = [&](Eigen::Map<MatrixX> block, int frame) {
      const Matrix3 chart = right_jacobian_inverse(Eigen::Map<const Vector3>(increment + record.v + 6 * frame + 3));
      block.rightCols<3>() = block.rightCols<3>() * chart;
    };
    for (int k = 0; k < record.frames; ++k) turn(S.frame_block(k), k), turn_columns(S.linear_frame_block(k), k);
    const auto pairs = bodies_[i]->T::coordinates().pairs;
    for (int k = 0; k < static_cast<int>(pairs.size()); ++k)
      turn(S.upper_block(k), pairs[k].second), turn(S.lower_block(k), pairs[k].first);
  }

  struct TypedCaches final : Caches {
    std::vector<Cache> all;
    BodyCache& at(int i) override { return all[i]; }
  };
  BodyState state_of(const Workspace& work, Caches& caches, std::size_t i) const {
    return {work.q.data() + records_[i].q, work.v.data() + records_[i].v, &static_cast<TypedCaches&>(caches).all[i]};
  }

  std::vector<const T*> bodies_;
  std::vector<BodyRecord> records_;
};

namespace connector {

template <class T>
inline constexpr int kMarkersOf = [] {
  if constexpr (requires { T::kMarkers; }) return T::kMarkers;
  return 0;
}();
template <class T>
inline constexpr int kRowsOf = [] {
  if constexpr (requires { T::kRows; }) return T::kRows;
  return 0;
}();

template <class T>
inline constexpr bool kHasRigidRows = requires {
  T::kRigidRows;
};

template <class T>
int marker_count(const ConnectorRecord& record) {
  return kMarkersOf<T> > 0 ? kMarkersOf<T> : record.marker_count;
}

/// Of a joint whose markers the compiler knows, which act one and all: without asking which of them do.
template <class T>
const Wrench& wrench_of(const ConstraintRows& rows, int row, int marker) {
  constexpr bool all_act = (kMarkersOf<T>) > 0;
  return all_act ? rows.plain_wrench(row, marker) : rows.wrench(row, marker);
}

/// A force may give ∂w/∂(marker motions) of its rows' wrenches w, tensions held, where it has no loads:
///   void add_stiffness(std::span<const MarkerView>, const double* tensions, ConstraintRows::Stiffness& K) const
template <class T>
concept HasStiffness = requires(const T& force, std::span<const MarkerView> markers, const double* tensions,
                                ConstraintRows::Stiffness& K) {
  force.add_stiffness(markers, tensions, K);
};

/// Views of the connector's markers, for a number of markers that the compiler may know.
template <class T = Constraint>
class Views {
 public:
  Views(const MarkerKinematics* table, const ConnectorRecord& record) : count_(marker_count<T>(record)) {
    for (int m = 0; m < count_; ++m) new (at(m)) MarkerView(table[record.slots[m].marker], m);
  }
  Views(const MarkerKinematics* markers, int count) : count_(count) {
    for (int m = 0; m < count_; ++m) new (at(m)) MarkerView(markers[m], m);
  }
  operator std::span<const MarkerView>() { return {at(0), static_cast<std::size_t>(count_)}; }

 private:
  MarkerView* at(int m) { return reinterpret_cast<MarkerView*>(storage_) + m; }
  int count_;
  static constexpr int kRoom = kMarkersOf<T> > 0 ? kMarkersOf<T> : kMostMarkers;
  alignas(MarkerView) unsigned char storage_[kRoom * sizeof(MarkerView)];
};

}  // namespace connector

template <class T>
class ConstraintBatchOf final : public ConstraintBatch {
 public:
  void add(const Constraint& constraint, ConnectorRecord record) override {
    constraints_.push_back(static_cast<const T*>(&constraint));
    records_.push_back(record);
  }
  const RigidRows* rigid_rows() const override {
    if constexpr (connector::kHasRigidRows<T>) return &T::kRigidRows;
    return nullptr;
  }

  void evaluate(Workspace& work, BatchRange range, const BlockStructure& blocks, Level level) const override {
    constexpr int kRows = connector::kRowsOf<T>;
    for_each_named(constraints_, range, work.time, [&](std::size_t i) {
      const ConnectorRecord& record = records_[i];
      if constexpr (connector::kHasRigidRows<T>)
        if (record.rigid && level != Level::acceleration)
          return rigid_pairs::evaluate<T::kRigidRows>(work, blocks, record);
      const int markers = connector::marker_count<T>(record);
      ConstraintRows rows(markers);
      rows.want_bias(level == Level::acceleration);
      rows.recall(work.quarter_turns.data() + record.first_angle);
      connector::Views<T> views(work.markers.data(), record);
      constraints_[i]->T::evaluate(work.time, views, rows);
      const auto wrench = [&](int r, int m) -> const Wrench& { return connector::wrench_of<T>(rows, r, m); };
      const int count = kRows > 0 ? kRows : rows.count();
      for (int r = 0; r < count; ++r) {
        work.residual[record.first_row + r] = rows.residual(r);
        work.rate[record.first_row + r] = rows.rate(r);
      }
      const int first = rows.hold_point() ? 3 : 0;
      if (level == Level::acceleration) {
        double* to = work.bias.data() + record.first_row;
        if (first > 0)
          Eigen::Map<Vector3>{to} =
              work.markers[record.slots[1].marker].bias_v - work.markers[record.slots[0].marker].bias_v;
        for (int r = first; r < count; ++r) {
          double bias = rows.bias(r);
          for (int m = 0; m < markers; ++m) {
            const MarkerKinematics& k = work.markers[record.slots[m].marker];
            bias += wrench(r, m).force.dot(k.bias_v) + wrench(r, m).torque.dot(k.bias_w);
          }
          to[r] = bias;
        }
      }
      for (int s = 0; s < record.slot_count; ++s) {
        const MarkerSlot& slot = record.slots[s];
        const bool point = first > 0 && slot.share < 0;
        if (point) connector::write_point_jacobian(work, blocks, slot, count, slot.place == 0 ? -1 : 1);
        if (point && first == count) continue;
        connector::write_jacobian<kRows>(work, blocks, slot, point ? first : 0, count,
                                         [&](int r) -> const Wrench& { return wrench(r, slot.place); });
      }
    });
  }

  void add_stiffness(Workspace& work, BatchRange range, const BlockStructure& blocks, double weight,
                     const double* lambda) const override {
    constexpr int kRows = connector::kRowsOf<T>;
    for_each_named(constraints_, range, work.time, [&](std::size_t i) {
      const ConnectorRecord& record = records_[i];
      const int markers = connector::marker_count<T>(record);
      if (markers > kMaxMarkers) return;  // left out: Newton finds its way without
      const double* multipliers = lambda + record.first_row;
      if constexpr (connector::kHasRigidRows<T>)
        if (record.rigid) return rigid_pairs::add_stiffness<T::kRigidRows>(work, blocks, record, weight, multipliers);
      ConstraintRows::Stiffness K;  // rows that have any set it to zero first
      ConstraintRows rows(markers);
      rows.want_bias(false);
      rows.collect_stiffness(multipliers, &K);
      Wrench load[kMaxMarkers];
      const auto evaluate = [&](connector::Views<T>&& views, ConstraintRows& into, Wrench* out) {
        into.recall(work.quarter_turns.data() + record.first_angle);
        constraints_[i]->T::evaluate(work.time, views, into);
        const int count = kRows > 0 ? kRows : into.count(), first = into.hold_point() ? 3 : 0;
        for (int m = 0; m < markers; ++m) {
          out[m] = {Vector3::Zero(), Vector3::Zero()};
          if (first > 0) out[m].force = (m == 0 ? -1 : 1) * Eigen::Map<const Vector3>(multipliers);
          for (int r = first; r < count; ++r) {
            const Wrench& w = connector::wrench_of<T>(into, r, m);
            out[m].force += multipliers[r] * w.force;
            out[m].torque += multipliers[r] * w.torque;
          }
        }
      };
      evaluate({work.markers.data(), record}, rows, load);
      if (rows.written()) {  // its wrenches are differenced over the markers' motions
        K.setZero(6 * markers, 6 * markers);
        connector::difference(
            work, record, Level::position,
            [&](const MarkerKinematics* here, Wrench* out) {
              ConstraintRows moved(markers);
              evaluate({here, markers}, moved, out);
            },
            K);
      }
      for (int m = 0; m < markers; ++m) connector::add_load_stiffness(work, blocks, record.slots[m], load[m], weight);
      if (rows.written() || rows.stiff()) connector::add_marker_stiffness(work, blocks, record, K, weight);
    });
  }

 private:
  std::vector<const T*> constraints_;
  std::vector<ConnectorRecord> records_;
};

template <class T>
class ForceBatchOf final : public ForceBatch {
 public:
  void add(const ForceElement& force, ConnectorRecord record, ReactionRecord reaction) override {
    forces_.push_back(static_cast<const T*>(&force));
    records_.push_back(record);
    if (!reaction.joint) return;
    reacting_.push_back(static_cast<int>(forces_.size()) - 1);
    reactions_.push_back(reaction);
  }
  BatchRange all() const { return {0, static_cast<int>(forces_.size())}; }

  void evaluate(Workspace& work, BatchRange range, const BlockStructure& blocks) const override {
    constexpr int kRows = connector::kRowsOf<T>;
    const int constraints = static_cast<int>(work.residual.size());
    for_each_named(forces_, range, work.time, [&](std::size_t i) {
      const ConnectorRecord& record = records_[i];
      ForceRows rows(record.marker_count);
      if (!reactions_.empty()) {
        rows.set_reaction({Vector3::Zero(), Vector3::Zero()});  // until react()
        rows.leave_out_friction(work.friction_left_out);
      }
      evaluate(work, i, rows);
      for (int r = 0; r < rows.count(); ++r) {
        const int at = record.first_row - constraints + r;
        work.tension[at] = rows.tension(r);
        work.row_stiffness[at] = rows.stiffness(r);
        work.row_damping[at] = rows.damping(r);
      }
      work.force_energy[record.energy] = rows.energy();
      for (int s = 0; s < record.slot_count; ++s) {
        const int m = record.slots[s].place;
        if (record.marker_count <= kMaxMarkers)
          connector::add_wrench(work, record.slots[s], rows.load(m), work.load.data());
        if (rows.count() > 0)
          connector::write_jacobian<kRows>(work, blocks, record.slots[s], 0, rows.count(),
                                           [&](int r) -> const Wrench& { return rows.wrench(r, m); });
      }
    });
  }

  void add_tangent(Workspace& work, BatchRange range, const BlockStructure& blocks,
                   const TangentWeights& weights) const override {
    for_each_named(forces_, range, work.time,
                   [&](std::size_t i) { add_tangent_of(*forces_[i], records_[i], work, blocks, weights); });
  }
  /// The same for one element.
  static void add_tangent_of(const T& force, const ConnectorRecord& record, Workspace& work,
                             const BlockStructure& blocks, const TangentWeights& weights) {
    const int n = record.marker_count, first = record.first_row - static_cast<int>(work.residual.size());
    if (n > kMaxMarkers) return;  // it acts by rows, whose damping is theirs
    // Wrench on the left-hand side: tensions as they are now, loads with the opposite sign.
    bool loaded = false;
    const auto wrenches = [&](const MarkerKinematics* markers, Wrench* out) {
      ForceRows rows(n);
      rows.recall(work.quarter_turns.data() + record.first_angle);
      rows.set_reaction({Vector3::Zero(), Vector3::Zero()});
      rows.leave_out_friction(work.friction_left_out);
      force.T::evaluate(work.time, connector::Views<T>(markers, n), rows);
      loaded |= rows.loaded();
      for (int m = 0; m < n; ++m) {
        out[m] = {-rows.load(m).force, -rows.load(m).torque};
        for (int r = 0; r < rows.count(); ++r) {
          out[m].force += work.tension[first + r] * rows.wrench(r, m).force;
          out[m].torque += work.tension[first + r] * rows.wrench(r, m).torque;
        }
      }
    };
    ConstraintRows::Stiffness K;
    MarkerKinematics here[kMaxMarkers];
    for (int m = 0; m < n; ++m) here[m] = work.markers[record.slots[m].marker];
    Wrench load[kMaxMarkers];
    wrenches(here, load);
    if (weights.position != 0) {
      K.setZero(6 * n, 6 * n);
      if constexpr (connector::HasStiffness<T>)
        force.T::add_stiffness(connector::Views<T>(here, n), &work.tension[first], K);
      else
        connector::difference(work, record, Level::position, wrenches, K);
      for (int m = 0; m < n; ++m)
        connector::add_load_stiffness(work, blocks, record.slots[m], load[m], weights.position);
      connector::add_marker_stiffness(work, blocks, record, K, weights.position);
    }
    if (weights.velocity != 0 && (loaded || connector::kRowsOf<T> == 0)) {
      K.setZero(6 * n, 6 * n);
      connector::difference(work, record, Level::velocity, wrenches, K);
      connector::add_marker_stiffness(work, blocks, record, K, weights.velocity);
    }
  }

  void react(Workspace& work, const BlockStructure&, const double* lambda) const override {
    const int constraints = static_cast<int>(work.residual.size());
    for (std::size_t k = 0; k < reacting_.size(); ++k) {
      const ConnectorRecord& record = records_[reacting_[k]];
      ForceRows rows(record.marker_count);
      evaluate_reacting(work, k, lambda, rows, nullptr);
      for (int r = 0; r < rows.count(); ++r) {
        work.tension[record.first_row - constraints + r] = rows.tension(r);
        work.row_damping[record.first_row - constraints + r] = rows.damping(r);
      }
    }
  }

  void write_reaction_tangent(Workspace& work, const BlockStructure& blocks, const double* lambda) const override {
    for (std::size_t k = 0; k < reacting_.size(); ++k) {
      ForceRows rows(records_[reacting_[k]].marker_count);
      ConstraintRows joint(reactions_[k].record.marker_count);
      evaluate_reacting(work, k, lambda, rows, &joint);
      // ∂σ/∂λ_j = -(∂σ/∂reaction) · W_j, over the row's compliance
      const auto& coupling = blocks.row_couplings[reactions_[k].coupling];
      const int compliant = blocks.rows[coupling.rows].compliant;
      for (int j = 0; j < joint.count(); ++j)
        for (int r = 0; r < rows.count(); ++r) {
          const Wrench &by = rows.by_reaction(r), &W = joint.wrench(j, 1);
          work.values[coupling.values + r + rows.count() * j] =
              work.values[compliant + r] * (by.force.dot(W.force) + by.torque.dot(W.torque));
        }
    }
  }

 private:
  void evaluate(const Workspace& work, std::size_t i, ForceRows& rows) const {
    rows.recall(work.quarter_turns.data() + records_[i].first_angle);
    forces_[i]->T::evaluate(work.time, connector::Views<T>(work.markers.data(), records_[i]), rows);
  }

  /// The k-th element that wants a reaction, with the reaction that the multipliers make: -Σ W λ.
  void evaluate_reacting(const Workspace& work, std::size_t k, const double* lambda, ForceRows& rows,
                         ConstraintRows* joint_rows) const {
    const ReactionRecord& reaction = reactions_[k];
    ConstraintRows own(reaction.record.marker_count);
    ConstraintRows& joint = joint_rows ? *joint_rows : own;
    joint.recall(work.quarter_turns.data() + reaction.record.first_angle);
    reaction.joint->evaluate(work.time, connector::Views(work.markers.data(), reaction.record), joint);
    Wrench sum{Vector3::Zero(), Vector3::Zero()};
    for (int j = 0; j < joint.count(); ++j) {
      sum.force -= lambda[reaction.record.first_row + j] * joint.wrench(j, 1).force;
      sum.torque -= lambda[reaction.record.first_row + j] * joint.wrench(j, 1).torque;
    }
    rows.set_reaction(sum);
    rows.leave_out_friction(work.friction_left_out);
    evaluate(work, reacting_[k], rows);
  }

  std::vector<const T*> forces_;
  std::vector<ConnectorRecord> records_;
  std::vector<int> reacting_;  // those that want a joint's reaction
  std::vector<ReactionRecord> reactions_;
};

template <class T>
std::unique_ptr<BodyBatch> make_body_batch() {
  return std::make_unique<BodyBatchOf<T>>();
}
template <class T>
std::unique_ptr<ConstraintBatch> make_constraint_batch() {
  return std::make_unique<ConstraintBatchOf<T>>();
}
template <class T>
std::unique_ptr<ForceBatch> make_force_batch() {
  return std::make_unique<ForceBatchOf<T>>();
}

}  // namespace lithe
