#include "models/fmu/fmu_force_internal.h"

#include "engine/assembly/linearized_batch.h"
#include "joints/forces/coordinate_effort.h"
#include "joints/forces/first_order_states.h"

namespace lithe {

void FmuWires::read(double time, std::span<const MarkerView> markers, const AngleMemory& memory, VectorX& z,
                    VectorX& u) const {
  const std::span<const MarkerView> at = markers.subspan(2 * static_cast<std::size_t>(coordinates.count()));
  for (int i = 0; i < z.size(); ++i) z[i] = at[static_cast<std::size_t>(i / 3)].v[i % 3];
  for (const In& in : inputs) {
    if (in.coordinate < 0) {
      u[in.place] = in.law(time).value;
      continue;
    }
    const MeasuredCoordinate x = coordinates.measure(in.coordinate, markers, memory);
    u[in.place] = in.rate ? x.rate : x.value;
  }
}

void FmuWires::act(std::span<const MarkerView> markers, const VectorX& rates, int states, ForceRows& rows) const {
  for (int i = 0; i < states; ++i)
    rows.add_load(markers[static_cast<std::size_t>(2 * coordinates.count() + i / 3)],
                  force(rates[i] * Vector3::Unit(i % 3)));
  for (const Out& out : outputs)
    push_coordinate(coordinates, out.coordinate, {rates[states + out.place], out.by_value, out.by_rate}, markers, rows);
}

void FmuForce::evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const {
  ExchangeEquations& fmu = equations();
  const auto lock = fmu.lock();
  p_.wires.read(time, markers, rows, fmu.z, fmu.u);
  p_.wires.act(markers, fmu.rates(time), fmu.state_count(), rows);
}

void FmuForce::set_as_drawn(bool drawn) const {
  const auto lock = equations().lock();
  equations().set_as_drawn(drawn);
}

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

}  // namespace

template <>
std::unique_ptr<ForceBatch> make_force_batch<FmuForce>() {
  return std::make_unique<LinearizedForceBatch<FmuForce, LinearFmuForce>>();
}

}  // namespace lithe
