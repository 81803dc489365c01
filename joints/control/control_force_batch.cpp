// Newton's matrix of control diagrams.
#include "engine/assembly/batch_in_parts.h"
#include "engine/assembly/connector_outer.h"
#include "joints/control/control_force.h"

namespace lithe {

/// The element with its signals made linear at one state: differences over it are exact, and do not evaluate blocks.
class LinearControl final : public ForceElement {
 public:
  LinearControl(const ControlForce& control, double time, std::span<const MarkerView> markers,
                const AngleMemory& memory)
      : control_(control) {
    const ControlProgram& program = control.program_;
    ControlForce::Point at;
    control.read(time, markers, memory, at);
    states_ = static_cast<int>(program.states.size()), in_ = 2 * control.coordinates_.count();
    std::copy_n(at.x, in_, inputs_);
    std::copy_n(at.z, states_, inputs_ + in_);
    for (const ControlProgram::State& state : program.states) add(program, at, state.rate);
    for (std::size_t k = 0; k < program.outputs.size(); ++k) {
      const auto& [coordinate, node] = program.outputs[k];
      const double* slopes = add(program, at, node);
      own_[2 * k] = slopes[2 * coordinate], own_[2 * k + 1] = slopes[2 * coordinate + 1];
    }
  }

  int marker_count() const override { return control_.marker_count(); }
  int row_count() const override { return control_.row_count(); }
  void evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const override {
    double moved[kWidth], out[kWidth];
    control_.measure(markers, rows, moved + in_, moved);
    for (int k = 0; k < in_ + states_; ++k) moved[k] -= inputs_[k];
    for (int i = 0; i < count_; ++i) {
      out[i] = value_[i];
      for (int k = 0; k < in_ + states_; ++k) out[i] += slopes_[i][k] * moved[k];
    }
    control_.act(markers, out, out + states_, own_, rows);
  }

 private:
  static constexpr int kWidth = 5 * kMaxMarkers;
  const double* add(const ControlProgram& program, const ControlForce::Point& at, int node) {
    value_[count_] = at.signals.value[node];
    program.differentiate(at.signals, node, slopes_[count_]);
    return slopes_[count_++];
  }

  const ControlForce& control_;
  int states_ = 0, in_ = 0, count_ = 0;
  double inputs_[kWidth], value_[kWidth], slopes_[kWidth][kWidth], own_[2 * kMaxMarkers];
};

/// A constant push along a coordinate, of which the tangent has how its wrenches turn.
class SteadyPush final : public ForceElement {
 public:
  SteadyPush(const JointCoordinate& coordinate, double effort) : coordinate_(coordinate), effort_(effort) {}
  int marker_count() const override { return 2; }
  int row_count() const override { return 0; }
  void evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const override {
    const MeasuredCoordinate x = measure(coordinate_.kind, coordinate_.axis, markers[0], markers[1]);
    rows.add_load(markers[0], coordinate_.sign * effort_ * x.on_A);
    rows.add_load(markers[1], coordinate_.sign * effort_ * x.on_B);
  }

 private:
  const JointCoordinate& coordinate_;
  const double effort_;
};

/// The tangent of a diagram in parts: of each number u that it acts by, -W (∂u/∂x W_x + ∂u/∂ẋ …)ᵀ over its markers and
/// those of what it depends on, but for what it owes to its own coordinate, which its row has; and how W turns.
class WideControl {
 public:
  WideControl(const ControlForce& control, const ConnectorRecord& record) : control_(control), record_(record) {
    const auto gather = [&](int marker, int place, std::vector<MarkerSlot>& into, bool extra) {
      for (int s = 0; s < record.slot_count; ++s)
        if (record.slots[s].place == marker && (s >= record.marker_count) == extra) {
          into.push_back(record.slots[s]);
          into.back().place = place;
        }
    };
    for (int c = 0; c < control.coordinates_.count(); ++c) {
      std::vector<MarkerSlot> both;
      for (const bool extra : {false, true})
        for (const int end : {0, 1}) gather(2 * c + end, end, both, extra);
      pairs_.push_back(std::move(both));
    }
    for (int m = 0; m < record.marker_count; ++m) {
      slots_.emplace_back();
      for (const bool extra : {false, true}) gather(m, 0, slots_.back(), extra);
    }
  }

  void add_tangent(Workspace& work, const BlockStructure& blocks, const TangentWeights& weights) const {
    const ControlProgram& program = control_.program_;
    const int coordinates = control_.coordinates_.count();
    ForceRows memory(record_.marker_count);
    memory.recall(work.quarter_turns.data() + record_.first_angle);
    connector::Views<ControlForce> views(work.markers.data(), record_);
    ControlForce::Point at;
    control_.read(work.time, views, memory, at);
    Input inputs[kMostMarkers / 2];
    for (int c = 0; c < coordinates; ++c) inputs[c] = input(work, c, views, memory, weights);
    double slopes[ControlForce::kMostInputs];
    const auto add = [&](int marker, const Wrench& on) {
      const std::vector<MarkerSlot>& to = slots_[static_cast<std::size_t>(marker)];
      for (int c = 0; c < coordinates; ++c)
        for (const int end : {0, 1})
          if (const double by = slopes[2 * c], by_rate = slopes[2 * c + 1]; by != 0 || by_rate != 0)
            connector::add_outer(work, blocks, to, on, slots_[static_cast<std::size_t>(2 * c + end)],
                                 -by * inputs[c].by_value[end] - by_rate * inputs[c].by_rate[end]);
      for (std::size_t i = 0; i < program.states.size(); ++i)
        if (const double by = slopes[2 * coordinates + static_cast<int>(i)]; by != 0)
          connector::add_outer(work, blocks, to, on, slots_[static_cast<std::size_t>(2 * coordinates) + i / 3],
                               force(-weights.velocity * by * Vector3::Unit(static_cast<int>(i % 3))));
    };
    for (const auto& [coordinate, node] : program.outputs) {
      program.differentiate(at.signals, node, slopes);
      if (weights.position != 0)
        ForceBatchOf<SteadyPush>::add_tangent_of({control_.coordinates_[coordinate], at.signals.value[node]},
                                                 pair(coordinate), work, blocks,
                                                 {weights.position, 0, weights.acceleration});
      slopes[2 * coordinate] = slopes[2 * coordinate + 1] = 0;
      add(2 * coordinate, inputs[coordinate].on[0]);
      add(2 * coordinate + 1, inputs[coordinate].on[1]);
    }
    for (std::size_t i = 0; i < program.states.size(); ++i) {
      program.differentiate(at.signals, program.states[i].rate, slopes);
      add(2 * coordinates + static_cast<int>(i / 3), force(Vector3::Unit(static_cast<int>(i % 3))));
    }
  }

 private:
  /// A coordinate: the wrenches of a unit push, and as weighted the derivatives of its value and rate by the motions of
  /// either marker.
  struct Input {
    Wrench on[2], by_value[2], by_rate[2];
  };

  ConnectorRecord pair(int coordinate) const {
    const std::vector<MarkerSlot>& slots = pairs_[static_cast<std::size_t>(coordinate)];
    ConnectorRecord record = record_;
    record.marker_count = 2, record.slots = slots.data(), record.slot_count = static_cast<int>(slots.size());
    record.first_angle += coordinate;
    return record;
  }

  Input input(const Workspace& work, int c, std::span<const MarkerView> views, const AngleMemory& memory,
              const TangentWeights& weights) const {
    const MeasuredCoordinate x = control_.coordinates_.measure(c, views, memory);
    const JointCoordinate& coordinate = control_.coordinates_[c];
    Input in{{x.on_A, x.on_B}, {}, {}};
    ConstraintRows::Stiffness K;
    if (weights.position != 0 && x.rate != 0) {
      K.setZero(12, 12);
      connector::difference(
          work, pair(c), Level::position,
          [&](const MarkerKinematics* here, Wrench* out) {
            const MeasuredCoordinate moved = measure(coordinate.kind, coordinate.axis, {here[0], 0}, {here[1], 1});
            out[0] = force(coordinate.sign * moved.rate * Vector3::UnitX());
            out[1] = {Vector3::Zero(), Vector3::Zero()};
          },
          K);
    }
    for (const int end : {0, 1}) {
      in.by_value[end] = weights.position * in.on[end];
      in.by_rate[end] = weights.velocity * in.on[end];
      if (K.size() == 0) continue;
      in.by_rate[end].force += weights.position * K.block<1, 3>(0, 6 * end).transpose();
      in.by_rate[end].torque += weights.position * K.block<1, 3>(0, 6 * end + 3).transpose();
    }
    return in;
  }

  const ControlForce& control_;
  const ConnectorRecord record_;
  std::vector<std::vector<MarkerSlot>> pairs_, slots_;  // of the markers of each coordinate; of each marker
};

template <>
std::unique_ptr<ForceBatch> make_force_batch<ControlForce>() {
  return std::make_unique<ForceBatchInParts<ControlForce, LinearControl, WideControl>>();
}

}  // namespace lithe
