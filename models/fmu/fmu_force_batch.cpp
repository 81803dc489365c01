// Newton's matrix of FMUs for model exchange.
#include "engine/assembly/batch_in_parts.h"
#include "models/fmu/fmu_force_internal.h"

namespace lithe {
namespace {

/// The force with the FMU's equations made linear at one state.
class LinearFmuForce final : public ForceElement {
 public:
  LinearFmuForce(const FmuForce& force, double time, std::span<const MarkerView> markers, const AngleMemory& memory)
      : wires_(force.wires()) {
    ExchangeEquations& fmu = force.equations();
    const auto lock = fmu.lock();
    wires_.read(time, markers, memory, fmu.z, fmu.u);
    z_ = fmu.z, u_ = fmu.u;
    rates_ = fmu.rates(time);
    jacobian_ = fmu.jacobian(time);
  }

  int marker_count() const override { return wires_.marker_count(); }
  int row_count() const override { return static_cast<int>(wires_.outputs.size()); }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override {
    VectorX z = z_, u = u_;
    wires_.read(time, markers, rows, z, u);
    const auto n = z.size();
    const VectorX rates =
        rates_ + jacobian_.leftCols(n).lazyProduct(z - z_) + jacobian_.rightCols(u.size()).lazyProduct(u - u_);
    wires_.act(markers, rates, static_cast<int>(n), rows);
  }

 private:
  const FmuWires& wires_;
  VectorX z_, u_, rates_;
  MatrixX jacobian_;
};

/// ∂(wrenches on the left-hand side)/∂(marker motions) of all markers of an FMU, six rows and columns each, but for
/// what its outputs owe to their own coordinates, which their rows have: -Σ T J Sᵀ, where T are the wrenches of unit
/// rates and outputs, and S those of unit states and inputs. How these turn with the markers is left out: Newton finds
/// its way without.
struct FmuTangent {
  MatrixX by_position, by_velocity;

  FmuTangent(const FmuForce& force, double time, std::span<const MarkerView> markers, const AngleMemory& memory) {
    const FmuWires& wires = force.wires();
    ExchangeEquations& fmu = force.equations();
    const auto lock = fmu.lock();
    wires.read(time, markers, memory, fmu.z, fmu.u);
    MatrixX J = fmu.jacobian(time);
    const Eigen::Index size = 6 * std::ssize(markers), n = fmu.state_count();
    MatrixX positions = MatrixX::Zero(size, J.cols()), velocities = positions;
    const auto coordinate = [&](int i, auto&& column) {
      const MeasuredCoordinate x = wires.coordinates.measure(i, markers, memory);
      column.segment(12 * i, 12) << x.on_A.force, x.on_A.torque, x.on_B.force, x.on_B.torque;
    };
    const auto place = [&](Eigen::Index state) { return 6 * (2 * wires.coordinates.count() + state / 3) + state % 3; };
    for (Eigen::Index i = 0; i < n; ++i) velocities(place(i), i) = 1;
    for (const FmuWires::In& in : wires.inputs)
      if (in.coordinate >= 0) coordinate(in.coordinate, (in.rate ? velocities : positions).col(n + in.place));
    by_position.setZero(size, size), by_velocity.setZero(size, size);
    const auto add = [&](const VectorX& on, Eigen::Index row) {
      by_position -= on * (positions * J.row(row).transpose()).transpose();
      by_velocity -= on * (velocities * J.row(row).transpose()).transpose();
    };
    for (Eigen::Index i = 0; i < n; ++i) add(VectorX::Unit(size, place(i)), i);
    for (const FmuWires::Out& out : wires.outputs) {
      VectorX on = VectorX::Zero(size);
      coordinate(out.coordinate, on);
      add(on, n + out.place);
      by_position += out.by_value * on * on.transpose();
      by_velocity += out.by_rate * on * on.transpose();
    }
  }
};

/// K to the frames of a connector with any number of markers.
void add_stiffness_of_all(Workspace& work, const BlockStructure& blocks, const ConnectorRecord& record,
                          const MatrixX& K, double weight) {
  for (int i = 0; i < record.marker_count; ++i)
    for (int j = 0; j < record.marker_count; ++j) {
      const auto Kij = K.block<6, 6>(6 * i, 6 * j);
      if (Kij.isZero(0)) continue;
      // As if it were of a connector with these two alone.
      std::vector<MarkerSlot> slots;
      for (int s = 0; s < record.slot_count; ++s) {
        MarkerSlot slot = record.slots[s];
        if (slot.place != i && slot.place != j) continue;
        slot.place = slot.place == i ? 0 : 1;
        slots.push_back(slot);
      }
      ConnectorRecord pair = record;
      pair.slots = slots.data(), pair.slot_count = static_cast<int>(slots.size());
      ConstraintRows::Stiffness both = ConstraintRows::Stiffness::Zero(12, 12);
      both.block<6, 6>(0, i == j ? 0 : 6) = Kij;
      connector::add_marker_stiffness(work, blocks, pair, both, weight);
    }
}

/// Of an FMU in parts.
class WideFmu {
 public:
  WideFmu(const FmuForce& first, const ConnectorRecord& record) : first_(first), record_(record) {}

  void add_tangent(Workspace& work, const BlockStructure& blocks, const TangentWeights& weights) const {
    ForceRows memory(record_.marker_count);
    memory.recall(work.quarter_turns.data() + record_.first_angle);
    connector::Views<FmuForce> views(work.markers.data(), record_);
    const FmuTangent tangent(first_, work.time, views, memory);
    add_stiffness_of_all(work, blocks, record_, tangent.by_position, weights.position);
    add_stiffness_of_all(work, blocks, record_, tangent.by_velocity, weights.velocity);
  }

 private:
  const FmuForce& first_;
  const ConnectorRecord record_;
};

}  // namespace

template <>
std::unique_ptr<ForceBatch> make_force_batch<FmuForce>() {
  return std::make_unique<ForceBatchInParts<FmuForce, LinearFmuForce, WideFmu>>();
}

}  // namespace lithe
