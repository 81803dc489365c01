#include "examples/support/energy_account.h"

#include <algorithm>
#include <cmath>

namespace machine {

using namespace lithe;

namespace {

/// W that the damping of a beam takes: σ_d · ε̇ along its elements, of uncoupled sections.
double damping_power(const Beam& beam, const BodyState& state) {
  double sum = 0;
  for (int i = 0; i < beam.element_count(); ++i) {
    const BeamSpan& span = beam.element(i);
    const BeamSection& section = span.section();
    const Vector6 viscous = beam.resultants(state, i) - section.stiffness * beam.strain(state, i);
    for (int k = 0; k < 6; ++k)
      if (section.damping[k] > 0)
        sum += span.length() * viscous[k] * viscous[k] / (section.stiffness(k, k) * section.damping[k]);
  }
  return sum;
}

double damping_power(const FlexibleBody& body, const BodyState& state) {
  const VectorX force = body.damping_force(state);
  return -force.dot(Eigen::Map<const VectorX>(state.v, force.size()));
}

double damping_power(const Body& body, Snapshot& now) {
  BodyState state = now.body_state(body);
  if (const auto* beam = dynamic_cast<const Beam*>(&body)) return damping_power(*beam, state);
  if (const auto* flexible = dynamic_cast<const FlexibleBody*>(&body)) return damping_power(*flexible, state);
  const auto* slender = dynamic_cast<const SlenderBody*>(&body);
  if (!slender) return 0;
  state.cache = static_cast<SlenderBody::Cache*>(state.cache)->inner.get();
  return slender->beam() ? damping_power(*slender->beam(), state) : damping_power(*slender->flexible(), state);
}

}  // namespace

EnergyAccount::EnergyAccount(const SystemGraph& graph, std::vector<Sensor> more)
    : graph_(graph), gains_(std::move(more)) {
  for (const SystemGraph::ForceEntry& entry : graph.forces()) gains_.push_back(lithe::power(*entry.force));
  for (const SystemGraph::ConstraintEntry& entry : graph.constraints())
    if (dynamic_cast<const CoordinateDrive*>(entry.constraint)) gains_.push_back(lithe::power(*entry.constraint));
  for (const SystemGraph::BodyEntry& entry : graph.bodies())
    if (!dynamic_cast<const Ground*>(entry.body)) stored_.push_back(total_energy(*entry.body));
}

void EnergyAccount::observe(Snapshot& now) {
  double energy = 0, power = 0;
  for (const Sensor& sensor : stored_) energy += sensor.value(now);
  for (const Sensor& sensor : gains_) power += sensor.value(now);
  for (const SystemGraph::BodyEntry& entry : graph_.bodies()) power -= damping_power(*entry.body, now);
  if (!times_.empty() && now.time() <= times_.back()) {  // an event: what begins there
    powers_.back() = power;
    return;
  }
  times_.push_back(now.time()), energies_.push_back(energy), powers_.push_back(power);
}

EnergyAccount::Sum EnergyAccount::sum() const {
  Sum sum{energies_.back() - energies_.front(), 0, 0};
  const std::size_t last = times_.size() - 1;
  const auto secant = [&](std::size_t i) { return (powers_[i] - powers_[i - 1]) / (times_[i] - times_[i - 1]); };
  // Slope at point `at` of the interval that ends at i: of the parabola through its neighbours. Where steps become much
  // shorter a method began anew: there the power may have a kink, which the longer interval must not see.
  const auto slope = [&](std::size_t at, std::size_t i) {
    const std::size_t other = at == i ? i + 1 : i - 1;
    if (other == 0 || other > last) return secant(i);
    const double h = times_[i] - times_[i - 1], beside = times_[other] - times_[other - 1];
    return beside < 0.1 * h ? secant(i) : (beside * secant(i) + h * secant(other)) / (h + beside);
  };
  for (std::size_t i = 1; i <= last; ++i) {
    const double h = times_[i] - times_[i - 1];
    sum.work += 0.5 * h * (powers_[i] + powers_[i - 1]) + h * h / 12 * (slope(i - 1, i) - slope(i, i));
    sum.turned_over += 0.5 * h * (std::abs(powers_[i]) + std::abs(powers_[i - 1]));
    sum.turned_over = std::max(sum.turned_over, std::abs(energies_[i] - energies_.front()));
  }
  return sum;
}

}  // namespace machine
