#include "models/fmu/fmu_force_internal.h"

#include <algorithm>

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

std::vector<FmuWires::Part> FmuWires::parts(int states) const {
  if (marker_count() <= kMaxMarkers && static_cast<int>(outputs.size()) <= kMaxRows) return {};
  std::vector<Part> all;
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const int c = outputs[o].coordinate;
    const auto has = [&](const Part& part) {
      return std::find(part.coordinates.begin(), part.coordinates.end(), c) != part.coordinates.end();
    };
    if (all.empty() || static_cast<int>(all.back().outputs.size()) == kMaxRows ||
        (2 * static_cast<int>(all.back().coordinates.size()) == kMaxMarkers && !has(all.back())))
      all.emplace_back();
    if (!has(all.back())) all.back().coordinates.push_back(c);
    all.back().outputs.push_back(static_cast<int>(o));
  }
  for (int first = 0; first < states; first += kMaxRows)
    all.push_back({.first_state = first, .states = std::min(kMaxRows, states - first)});
  return all;
}

void FmuWires::act(const Part& part, std::span<const MarkerView> markers, const VectorX& rates, int states,
                   ForceRows& rows) const {
  // 1. The markers that it acts on.
  std::vector<int> acting;
  for (const int c : part.coordinates) acting.insert(acting.end(), {2 * c, 2 * c + 1});
  const int first = static_cast<int>(acting.size());
  for (int i = 0; i < part.states; i += 3) acting.push_back(2 * coordinates.count() + (part.first_state + i) / 3);
  rows.act_on(acting);
  const auto open = [&] {
    Wrench* W = rows.open();
    std::fill_n(W, acting.size(), Wrench{Vector3::Zero(), Vector3::Zero()});
    return W;
  };
  // 2. A row for each number.
  for (const int o : part.outputs) {
    const Out& out = outputs[static_cast<std::size_t>(o)];
    const MeasuredCoordinate x = coordinates.measure(out.coordinate, markers, rows);
    const auto at = std::find(part.coordinates.begin(), part.coordinates.end(), out.coordinate);
    Wrench* W = open() + 2 * (at - part.coordinates.begin());
    W[0] = x.on_A, W[1] = x.on_B;
    rows.finish(-rates[states + out.place], -out.by_value, -out.by_rate);
  }
  for (int i = 0; i < part.states; ++i) {
    open()[first + i / 3] = force(Vector3::Unit(i % 3));
    rows.finish(-rates[part.first_state + i], 0, 0);
  }
}

void FmuForce::evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const {
  ExchangeEquations& fmu = equations();
  const auto lock = fmu.lock();
  p_.wires.read(time, markers, rows, fmu.z, fmu.u);
  const VectorX& rates = fmu.rates(time);
  if (is_whole())
    p_.wires.act(markers, rates, fmu.state_count(), rows);
  else
    p_.wires.act(*p_.part, markers, rates, fmu.state_count(), rows);
}

void FmuForce::set_as_drawn(bool drawn) const {
  if (!is_first()) return;
  const auto lock = equations().lock();
  equations().set_as_drawn(drawn);
}

}  // namespace lithe
